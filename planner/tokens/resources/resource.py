"""A resource of the model in a plan: its transactions, its ledgers, and what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from planner.constraints.network import (
    AnyVariable,
    ConstraintNetworkManager,
    Inconsistency,
    Owner,
    TimeVariable,
    Variable,
)
from planner.constraints.retraction import detach
from planner.domains import Interval
from planner.errors import ModelError, nearest
from planner.model.classes import ModelObject
from planner.model.manager import ModelManager
from planner.model.resources import ENVELOPE, GROUNDED, PROFILES
from planner.tokens.resources.clash import Clash, Overdraft, overdraft_of
from planner.tokens.resources.ledger import RESOLUTION, Band, Ledger
from planner.tokens.resources.steps import Steps
from planner.tokens.resources.timetable import Timetable
from planner.tokens.resources.transaction import Event, Flow, Transaction
from planner.tokens.token import Token
from planner.trail import Trail

_FLOWS: dict[str, Flow] = {"produce": "produces", "consume": "consumes"}
_NEVER = Steps.constant(math.inf)


class Pruning:
    """Has a resource prune when a transaction of it changes."""

    __slots__ = ("owner", "queued", "resource", "scope")

    def __init__(self, resource: Resource, transaction: Transaction) -> None:
        self.resource = resource
        self.scope: Sequence[AnyVariable] = transaction.scope
        self.owner: Owner = transaction.owner
        self.queued = False

    def run(self, network: ConstraintNetworkManager) -> None:
        """Narrow what all transactions leave no room for; Inconsistency when they cannot be together."""
        self.resource.prune()


class Resource:
    """The transactions on one object of a resource class, which `planner.model.resources` describes.

    Everything that search may undo is trailed. `prune` removes what no schedule allows, whatever transactions are still
    to come; `clash` finds what some schedule of the flexible plan allows and should not.
    """

    def __init__(
        self, thing: ModelObject, model: ModelManager, network: ConstraintNetworkManager, trail: Trail
    ) -> None:
        self.object = thing
        self.network = network
        self.trail = trail
        self.transactions: list[Transaction] = []
        self.is_reservoir = model.is_subclass(thing.cls, "Reservoir")
        self._types = model.members_of(thing.cls)
        self._model = model
        grounded = self._profile() == GROUNDED
        level_min = self._steps("level_min", 0.0)
        if self.is_reservoir:
            self.base = self._steps("initial")
            if len(self.base.values) > 1:
                raise ModelError(f"object {thing}: expected a number as its member 'initial'")
            self.top = self._steps("level_max", math.inf)
        else:
            self.base = self._steps("capacity")
            self.top = _NEVER
        self._check_start(level_min)
        floor = level_min.minus(self.base)
        ceiling = self.top.minus(self.base) if self.is_reservoir else _NEVER
        self.level = Ledger(floor, ceiling, not self.is_reservoir, grounded, network.temporal, trail)
        self.bottom = level_min
        self.rates: dict[Flow, Ledger] = {}
        self.sums: dict[Flow, float] = {}
        takes: Flow = "consumes" if self.is_reservoir else "uses"
        for flow, name in ((takes, "consumption"), ("produces", "production")):
            rate = self._steps(f"{name}_rate_max", math.inf)
            if any(math.isfinite(value) for value in rate.values):
                self.rates[flow] = Ledger(rate.negated(), _NEVER, True, grounded, network.temporal, trail)
            most = self._steps(f"{name}_max", math.inf)
            if math.isfinite(most.values[0]):
                self.sums[flow] = most.values[0]
        self._pruned_at: tuple[int, int] | None = None

    def __repr__(self) -> str:
        if not self.is_reservoir:
            return f"{self.object} (capacity {_told(self.base)})"
        return f"{self.object} (level {_told(self.bottom)} to {_told(self.top)})"

    @property
    def users(self) -> Sequence[Transaction]:
        """The transactions, in the order in which they came."""
        return self.transactions

    # Members

    def _profile(self) -> str:
        found = self.object.members.get("profile", ENVELOPE)
        if found not in PROFILES:
            hint = nearest(str(found), PROFILES)
            raise ModelError(f"object {self.object}: expected a profile of {PROFILES}, found {found!r}{hint}")
        return str(found)

    def _steps(self, name: str, default: float | None = None) -> Steps:
        thing, where = self.object, f"object {self.object}, member {name!r}"
        if name in thing.members:
            return Steps.parse(thing.members[name], where)
        if name in self._types:
            domain = self._model.domain_of(self._types[name])
            if domain.is_singleton:
                return Steps.parse(domain.value, where)
        if default is None:
            raise ModelError(f"object {thing} of class {thing.cls}: a resource needs a value for its member {name!r}")
        return Steps.constant(default)

    def _check_start(self, level_min: Steps) -> None:
        """Without transactions the level of a reusable keeps its limits; a reservoir's is judged once it has some."""
        for tick in sorted({*self.base.starts, *level_min.starts, *self.top.starts}):
            low, level, high = level_min.at(tick), self.base.at(tick), self.top.at(tick)
            if not self.is_reservoir and not low <= level <= high:
                when = "to begin with" if math.isinf(tick) else f"from tick {tick:g} on"
                raise ModelError(
                    f"object {self.object}: expected a level of {low:g} to {high:g} {when}, found {level:g}"
                )

    # Transactions

    def add(self, token: Token) -> None:
        """A token becomes a transaction here."""
        quantity: AnyVariable | None = token.parameters.get("quantity")
        if quantity is None:
            quantity = Variable(f"{token.name}.quantity", Interval(1, 1), None)
        shortest = max(0, int(token.duration.stated.lower))
        if not self.is_reservoir:
            times = (token.start, token.end)
            self._enter(Transaction(token.name, "uses", quantity, times, token.object, token.owner, token, shortest))
            return
        if token.predicate.name not in _FLOWS:
            raise ModelError(f"{token!r} on reservoir {self.object}: expected a predicate of {sorted(_FLOWS)}")
        flow = _FLOWS[token.predicate.name]
        times = (token.start, token.start)
        self._enter(Transaction(token.name, flow, quantity, times, token.object, token.owner, token))

    def use(
        self,
        name: str,
        quantity: AnyVariable,
        times: tuple[TimeVariable, TimeVariable],
        where: AnyVariable,
        owner: Owner,
    ) -> Transaction:
        """A use of this reusable resource that is not a token of it; ModelError on a reservoir. `where`: the variable
        by which the resource was chosen."""
        if self.is_reservoir:
            raise ModelError(f"{owner!r}: {self.object} is a reservoir, expected a reusable resource")
        return self._enter(Transaction(name, "uses", quantity, times, where, owner))

    def _enter(self, transaction: Transaction) -> Transaction:
        self.trail.append(self.transactions, transaction)
        start, flow = transaction.start, transaction.flow
        if flow == "uses":
            ends = (Event(start, 0, -1, transaction, True), Event(transaction.end, 0, 1, transaction, True))
            self.level.add(transaction, ends)
        else:
            self.level.add(transaction, [Event(start, 0, 1 if flow == "produces" else -1, transaction, False)])
        if flow in self.rates:
            # What moves at one tick is in use for that tick.
            tick = (Event(start, 0, -1, transaction, True), Event(start, 1, 1, transaction, True))
            self.rates[flow].add(transaction, tick)
        if self.rates or self.sums or not self.is_reservoir:
            transaction.watch = Pruning(self, transaction)
            self.network.watch(transaction.watch)
        return transaction

    def remove(self, token: Token) -> None:
        """Take a token out, whenever it came. What it narrowed is the caller's to take back."""
        self.leave(next(t for t in self.transactions if t.token is token))

    def leave(self, transaction: Transaction) -> None:
        """Take a transaction out, whenever it came."""
        place = self.transactions.index(transaction)
        self.trail.call(self.transactions.insert, place, self.transactions.pop(place))
        for ledger in (self.level, *self.rates.values()):
            ledger.remove(transaction)
        if transaction.watch is not None:
            detach(self.network, transaction.watch)

    def prunings(self) -> list[Pruning]:
        """What has it prune."""
        return [t.watch for t in self.transactions if isinstance(t.watch, Pruning)]

    def forget(self) -> None:
        """Derive everything anew: to be called when constraints were taken out other than by undo."""
        for ledger in (self.level, *self.rates.values()):
            ledger.forget()

    # Pruning

    def prune(self) -> None:
        """Narrow quantities and times; Inconsistency when the transactions cannot be together. Nothing to do since the
        last time unless something changed."""
        moment = self.network.temporal.mark(), self.network.now().changes
        if moment == self._pruned_at:
            return
        for flow in self.sums:
            self._prune_sum(flow)
        for ledger in (self.level, *self.rates.values()):
            if ledger.uses and sum(e.transaction.most for e in ledger.events[::2]) > -max(ledger.floor.values):
                Timetable(self, ledger, self.network).narrow()
        if moment == (self.network.temporal.mark(), self.network.now().changes):
            self.trail.assign(self, "_pruned_at", moment)

    def _prune_sum(self, flow: Flow) -> None:
        moved = [t for t in self.transactions if t.flow == flow]
        least, limit = math.fsum(t.least for t in moved), self.sums[flow]
        slack = RESOLUTION * max(1.0, abs(limit))
        if least > limit + slack:
            raise Inconsistency(because=self._too_much(flow, least))
        for transaction in moved:
            room = limit - least + transaction.least
            if transaction.most > room + slack:
                domain = Interval(-math.inf, room, integer=False)
                self.network.restrict(transaction.quantity, domain, self._too_much(flow, least))

    def _too_much(self, flow: Flow, total: float) -> Clash:
        moved = [t for t in self.transactions if t.flow == flow]
        return Clash(self, moved, f"{total:g} may be {_DONE[flow]} in all, at most {self.sums[flow]:g} are allowed")

    # Judgement

    def clash(self) -> Clash | None:
        """The first violation of a limit that some schedule commits; None: the resource is kept."""
        for ledger in (self.level, *self.rates.values()):
            scenario = ledger.violation()
            if scenario is not None:
                return overdraft_of(self, scenario)
        for flow, limit in self.sums.items():
            most = math.fsum(t.most for t in self.transactions if t.flow == flow)
            if most > limit + RESOLUTION * max(1.0, abs(limit)):
                return self._too_much(flow, most)
        return None

    def envelope(self) -> list[Band]:
        """The lowest and the highest level over time, among all schedules that the flexible plan allows."""
        return self._levels(self.level.envelope())

    def grounded(self) -> list[Band]:
        """The level over time when everything happens as early as it can."""
        return self._levels(self.level.profile())

    def _levels(self, bands: Sequence[Band]) -> list[Band]:
        """From sums of steps to levels, with the steps of the capacity."""
        levels: list[Band] = []
        starts = sorted({*(b.start for b in bands), *self.base.starts})
        number = 0
        for start in starts:
            while number + 1 < len(bands) and bands[number + 1].start <= start:
                number += 1
            base = self.base.at(start)
            levels.append(Band(start, base + bands[number].lowest, base + bands[number].highest))
        return levels

    def complaint(self, overdraft: Overdraft) -> str:
        """What a schedule does, in words."""
        scenario, total = overdraft.scenario, overdraft.total
        tick = scenario.tick
        when = f"at {tick}" if abs(tick) < 1 << 49 else "at some time"
        if scenario.ledger is not self.level:
            flow = next(f for f, ledger in self.rates.items() if ledger is scenario.ledger)
            return f"{-total:g} may be {_DONE[flow]} {when}, at most {-scenario.limit:g} are allowed at one tick"
        if not self.is_reservoir:
            return f"{-total:g} may be in use {when}, there are {-scenario.limit:g}"
        level = self.base.values[0] + total
        if scenario.low:
            return f"the level may fall to {level:g} {when}, at least {self.bottom.at(tick):g} are required"
        return f"the level may rise to {level:g} {when}, at most {self.top.at(tick):g} are allowed"


_DONE: dict[Flow, str] = {"uses": "taken", "produces": "produced", "consumes": "consumed"}


def _told(steps: Steps) -> str:
    first, *rest = zip(steps.starts, steps.values, strict=True)
    return ", ".join([f"{first[1]:g}", *(f"{value:g} from {start:g} on" for start, value in rest)])
