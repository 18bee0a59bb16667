"""The heaviest closed set of a partial order, by maximum flow.

Picard, "Maximal closure of a graph and applications to combinatorial problems", Management Science 22, 1976; the flow
by Dinic, "Algorithm for solution of a problem of maximum flow in networks with power estimation", Soviet Mathematics
Doklady 11, 1970. The order is transitively closed, so the network has two layers: flow goes from an element that gains
straight to one that costs and that it requires. Sets of elements are bits of whole numbers, so that a step of the
breadth-first search looks at all edges of a node at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence


def heaviest_closure(gains: Sequence[float], requires: Sequence[int], among: int) -> int:
    """The closed subset of `among` with the greatest sum of gains, the smallest such, as bits.

    `requires[i]`: the elements that every set with i must have, as bits; transitively closed.
    """
    flow = _Flow(gains, requires, among)
    flow.run()
    return flow.cut()


def elements(bits: int) -> Iterator[int]:
    """The positions of the bits that are set, lowest first."""
    while bits:
        low = bits & -bits
        yield low.bit_length() - 1
        bits ^= low


class _Flow:
    """Supplies (elements that gain), demands (elements that cost) and what flows from each to each."""

    def __init__(self, gains: Sequence[float], requires: Sequence[int], among: int) -> None:
        self.supply: dict[int, float] = {}
        self.demand: dict[int, float] = {}
        for element in elements(among):
            if gains[element] > 0:
                self.supply[element] = gains[element]
            elif gains[element] < 0:
                self.demand[element] = -gains[element]
        self.among = among
        self.requires = requires
        self.costs = sum(1 << element for element in self.demand)
        self.unmet = self.costs
        # What each element that costs gets, and from which: never an entry of zero.
        self.inflow: dict[int, dict[int, float]] = {element: {} for element in self.demand}

    def run(self) -> None:
        """Maximum flow: what is at hand first, then phases of shortest augmenting paths.

        At hand first comes who has the fewest to give to: where these sets are nested that is all there is to do.
        """
        for source in sorted(self.supply, key=lambda s: (self.requires[s] & self.costs).bit_count()):
            for sink in elements(self.requires[source] & self.unmet):
                self._send(source, sink, min(self.supply[source], self.demand[sink]))
                if not self.supply[source]:
                    break
        while self.unmet and self._phase():
            pass

    def _send(self, source: int, sink: int, amount: float) -> None:
        """A direct flow that uses up the source or the sink."""
        self.supply[source] -= amount
        self.demand[sink] -= amount
        self.inflow[sink][source] = self.inflow[sink].get(source, 0.0) + amount
        if not self.demand[sink]:
            self.unmet &= ~(1 << sink)

    def _layers(self) -> tuple[list[int], dict[int, int]]:
        """Breadth-first from all sources with supply left: the sinks of each layer, and the layer of each source.

        The last layer of sinks is the first that has one with demand left; if none has, all that can be reached is
        there.
        """
        layer = [source for source, left in self.supply.items() if left]
        depth = dict.fromkeys(layer, 0)
        sinks: list[int] = []
        seen = 0
        while layer:
            reached = 0
            for source in layer:
                reached |= self.requires[source]
            reached &= self.costs & ~seen
            seen |= reached
            if not reached:
                break
            sinks.append(reached)
            if reached & self.unmet:
                break
            layer = []
            for sink in elements(reached):
                for source in self.inflow[sink]:
                    if source not in depth:
                        depth[source] = len(sinks)
                        layer.append(source)
        return sinks, depth

    def _phase(self) -> bool:
        """A blocking flow in the layered network; whether anything flowed."""
        sinks, depth = self._layers()
        if not sinks or not sinks[-1] & self.unmet:
            return False
        left = {source: self.requires[source] & sinks[d] for source, d in depth.items() if d < len(sinks)}
        for source in [s for s, d in depth.items() if d == 0]:
            while self.supply[source] and self._augment(source, left, depth, len(sinks) - 1):
                pass
        return True

    def _augment(self, source: int, left: dict[int, int], depth: dict[int, int], last: int) -> bool:
        """One path from the source to a sink with demand left, depth first; `left`: the sinks not yet tried."""
        sources, sinks = [source], list[int]()
        while sources:
            at = sources[-1]
            tries = left[at] & self.unmet if depth[at] == last else left[at]
            if not tries:
                left[at] = 0
                sources.pop()
                if (
                    sinks
                ):  # the way here leads nowhere: nor will it from this source by this sink unless others are left
                    self._next_giver(sources, sinks, left, depth)
                continue
            sink = (tries & -tries).bit_length() - 1
            sinks.append(sink)
            if depth[at] == last:
                self._push(sources, sinks)
                return True
            self._next_giver(sources, sinks, left, depth)
        return False

    def _next_giver(self, sources: list[int], sinks: list[int], left: dict[int, int], depth: dict[int, int]) -> None:
        """Go on from the last sink of the path to a source that gives to it and has sinks to try, or leave the sink."""
        sink = sinks[-1]
        below = depth[sources[-1]] + 1
        for giver in self.inflow[sink]:
            if depth.get(giver) == below and left[giver]:
                sources.append(giver)
                return
        left[sources[-1]] &= ~(1 << sink)
        sinks.pop()

    def _push(self, sources: list[int], sinks: list[int]) -> None:
        """As much as the path takes: forward to each sink, back from it to the source that it had the flow from."""
        amount = min(self.supply[sources[0]], self.demand[sinks[-1]])
        for sink, giver in zip(sinks, sources[1:], strict=False):
            amount = min(amount, self.inflow[sink][giver])
        for source, sink in zip(sources, sinks, strict=True):
            self.inflow[sink][source] = self.inflow[sink].get(source, 0.0) + amount
        for sink, giver in zip(sinks, sources[1:], strict=False):
            self.inflow[sink][giver] -= amount
            if not self.inflow[sink][giver]:
                del self.inflow[sink][giver]
        self.supply[sources[0]] -= amount
        self.demand[sinks[-1]] -= amount
        if not self.demand[sinks[-1]]:
            self.unmet &= ~(1 << sinks[-1])

    def cut(self) -> int:
        """What the sources with supply left reach in the residual network: the smallest heaviest closed set."""
        _, depth = self._layers()
        found = 0
        for source in depth:
            found |= self.requires[source] | 1 << source
        return found & self.among
