"""The constraint `uses(resource, quantity, start, end)`: a use that is not a token of the resource."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Owner, TimeVariable
from planner.errors import ModelError
from planner.model.classes import ModelObject, objects_in
from planner.tokens.resources.resource import Resource
from planner.tokens.resources.transaction import Transaction
from planner.trail import Trail


class PendingUse:
    """Posts the use once its resource is decided."""

    __slots__ = ("owner", "quantity", "queued", "resources", "scope", "times", "trail", "transaction")

    def __init__(
        self, resources: Mapping[ModelObject, Resource], scope: Sequence[AnyVariable], owner: Owner, trail: Trail
    ) -> None:
        which, self.quantity, start, end = scope
        if not isinstance(start, TimeVariable) or not isinstance(end, TimeVariable):
            raise ModelError(f"{owner!r}: uses: expected the start and the end of tokens, found {start!r} and {end!r}")
        strangers = [thing for thing in _values(which) if thing not in resources]
        if strangers:
            raise ModelError(f"{owner!r}: uses: expected a reusable resource, found {strangers[0]}")
        self.resources = resources
        self.scope: Sequence[AnyVariable] = (which,)
        self.times = (start, end)
        self.owner = owner
        self.trail = trail
        self.transaction: Transaction | None = None
        self.queued = False

    def run(self, network: ConstraintNetworkManager) -> None:
        """Add the transaction when the resource is known, once."""
        domain = self.scope[0].domain
        if self.transaction is not None or not domain.is_singleton or domain.is_open:
            return
        (thing,) = objects_in(domain)
        name = self.times[0].name.removesuffix(".start")
        posted = self.resources[thing].use(name, self.quantity, self.times, self.scope[0], self.owner)
        self.trail.assign(self, "transaction", posted)

    def withdraw(self) -> None:
        """Take the use out again, if it was posted: to be called while the resource is still decided."""
        if self.transaction is not None:
            (thing,) = objects_in(self.scope[0].domain)
            self.resources[thing].leave(self.transaction)
            self.trail.assign(self, "transaction", None)


def _values(variable: AnyVariable) -> list[Any]:
    domain = variable.domain
    return [domain] if domain.is_numeric else list(domain.values())
