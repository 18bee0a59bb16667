"""What a constraint network knows of its consistency (paper, sections 4 and 5): of a constraint, of a value, of all.

Locally, a constraint procedure decides on assigned variables and may refuse a value before that. Globally, propagation
to the fixpoint proves inconsistency or does not; and once every variable is assigned, it decides. Times are never
assigned in a flexible plan, but at its fixpoint the temporal network is consistent by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal

from planner.constraints.network import AnyVariable, Constraint, ConstraintNetworkManager, Inconsistency, Owner
from planner.domains import Domain, Interval, singleton

Verdict = Literal["consistent", "inconsistent", "undecided"]


def of_constraint(constraint: Constraint) -> Verdict:
    """Whether a constraint by itself has solutions among the domains of its scope; undecided while they have several
    values and none of them is refused outright."""
    domains = [variable.domain for variable in constraint.scope]
    if _refused(constraint, domains):
        return "inconsistent"
    return "consistent" if all(d.is_singleton and not d.is_open for d in domains) else "undecided"


def allows(variable: AnyVariable, value: Any) -> bool:
    """Whether every constraint on a variable, each by itself, leaves it a value: a value that one of them refuses is in
    no solution."""
    one = only(variable.domain, value)
    if one.is_empty:
        return False
    return not any(
        _refused(constraint, with_value(constraint, variable, one)) for constraint in constraints_on(variable)
    )


def of_network(network: ConstraintNetworkManager) -> tuple[Verdict, list[Owner]]:
    """Propagate, and say whether the network has a solution; and where it has none, who is to blame.

    Open a level of the trail before: what propagation narrows stays.
    """
    try:
        network.propagate()
    except Inconsistency as inconsistency:
        return "inconsistent", network.explain(inconsistency)
    # Constraints that were taken out in place are watched by nobody.
    there = (p for p in network.propagators if isinstance(p, Constraint) and _is_there(p))
    decided = all(of_constraint(constraint) == "consistent" for constraint in there)
    return "consistent" if decided else "undecided", []


def constraints_on(variable: AnyVariable) -> Iterator[Constraint]:
    """The constraints whose scope a variable is in."""
    return (w for w in variable.watchers if isinstance(w, Constraint))


def with_value(constraint: Constraint, variable: AnyVariable, one: Domain) -> list[Domain]:
    """The domains of a scope, with one of its variables assigned."""
    return [one if v is variable else v.domain for v in constraint.scope]


def only(domain: Domain, value: Any) -> Domain:
    """The domain that has one value of another, or none."""
    return domain.intersect(singleton(value)) if isinstance(domain, Interval) else domain.keep((value,))


def _refused(constraint: Constraint, domains: Sequence[Domain]) -> bool:
    narrowed = constraint.procedure.narrow(domains)
    return narrowed is None or any(domain.is_empty for domain in narrowed)


def _is_there(constraint: Constraint) -> bool:
    return any(watcher is constraint for watcher in constraint.scope[0].watchers)
