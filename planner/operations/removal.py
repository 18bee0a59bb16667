"""Taking out of a plan in place what goes with one operation."""

from __future__ import annotations

import math

from planner.constraints import retraction as network_retraction
from planner.constraints.network import Variable
from planner.operations.restricting import restrict
from planner.operations.retraction import Retraction
from planner.operations.statements import Insertion, Restriction
from planner.tokens import withdrawal
from planner.tokens.instance import GuardInstance
from planner.tokens.token import Token, TokenState


class Removal:
    """After `carry_out`, propagation and `unsettle`, what was found is gone and what still holds is derived."""

    def __init__(self, found: Retraction) -> None:
        self.found = found
        self.database = found.database

    def carry_out(self) -> None:
        """Take it all out, and queue what must be derived anew. The caller propagates."""
        found, tokens, network, trail = self.found, self.database.tokens, self.database.network, self.database.trail
        for instance in found.instances:
            trail.assign(instance, "withdrawn", True)
        for propagator in found.propagators.values():
            network_retraction.detach(network, propagator)
            if isinstance(propagator, GuardInstance):
                withdrawal.forget_guard(tokens, propagator)
        for variable in found.variables.values():
            withdrawal.forget_variable(tokens, variable)
        for use in found.uses.values():
            use.withdraw()
        gaps = self._leave()
        network.temporal.remove(sorted(found.edges))
        for key in found.dead & found.cuts.keys():
            del found.cuts[key]
        for cut in found.cuts.values():
            if cut.last == math.inf:
                network_retraction.reset(network, cut.variable, cut.first)
            elif isinstance(cut.variable, Variable):
                network_retraction.splice(network, cut.variable, cut.first, int(cut.last))
        for guard in found.undone.values():
            if id(guard) not in found.propagators:
                trail.assign(guard, "fired", False)
                trail.assign(guard, "bodies", [])
                network_retraction.enqueue(network, [guard])
        network_retraction.enqueue(network, (use for key, use in found.uses.items() if key not in found.propagators))
        network_retraction.enqueue(network, withdrawal.prune_anew(tokens))
        for first in gaps:
            self._close_gap(first)
        for operation in found.suspended.values():
            found.register.suspend(operation)
        self._restrict_anew()

    def unsettle(self) -> None:
        """After propagation: what was decided before and is not any more."""
        for cut in self.found.cuts.values():
            if isinstance(cut.variable, Variable):
                withdrawal.unsettle(self.database.tokens, cut.variable)
        withdrawal.reopen(self.database.tokens)

    def _leave(self) -> list[Token]:
        """Take the tokens out; those on timelines that get another successor."""
        gaps = []
        freed = [token for key, token in self.found.released.items() if key not in self.found.destroyed]
        for token in [*self.found.destroyed.values(), *freed]:
            if token.state is TokenState.ACTIVE and token.kind == "timeline":
                sequence = self.database.tokens.timeline_of(token).sequence
                place = sequence.index(token)
                if place > 0:
                    gaps.append(sequence[place - 1])
                self.found.precedences.forget(token)
            if id(token) in self.found.destroyed:
                withdrawal.destroy(self.database.tokens, token)
            else:
                withdrawal.release(self.database.tokens, token)
        return gaps

    def _close_gap(self, first: Token) -> None:
        if id(first) in self.found.released or id(first) in self.found.destroyed:
            return
        sequence = self.database.tokens.timeline_of(first).sequence
        place = sequence.index(first) + 1
        if place < len(sequence):
            self.found.precedences.link(first, sequence[place])

    def _restrict_anew(self) -> None:
        """Operations whose restrictions said nothing new before, or went with an earlier change, speak again."""
        for cut in self.found.cuts.values():
            if cut.last < math.inf:
                continue
            of = cut.variable.of
            for operation in self.found.register.about(of.path if isinstance(of, Token) else cut.variable.name):
                if isinstance(operation.statement, Restriction | Insertion):
                    restrict(self.database, operation)
