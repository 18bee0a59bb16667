"""Dynamic controllability of a network, and the dispatchable network that proves it.

A network is dynamically controllable when some strategy keeps every requirement link whatever the contingent durations
turn out to be, looking only at the past. The check is the back-propagation of Morris, "Dynamic controllability and
dispatchability relationships" (CPAIOR 2014), in the normal form where each contingent link is a fixed duration and then
one from zero; the waits that it derives are kept, so that what was found can be executed (an extended STNU: Hunsberger
and Posenato, "Foundations of dispatchability for simple temporal networks with uncertainty", 2024). O(n^3). A network
that is not controllable yields a semi-reducible negative cycle, told as the links it was derived from (in the manner
of Bhargava, Vaquero and Williams, "Faster conflict generation for dynamic controllability", IJCAI 2017).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from planner.temporal.stnu import CONTINGENT, FROM, MAX, MIN, TO, UNBOUNDED, Stnu

IntArray = NDArray[np.int64]
CheckLinks = Callable[[int, IntArray], tuple[IntArray, IntArray, IntArray, bool]]


@dataclass(frozen=True, eq=False)
class DispatchableNetwork:
    """What real-time execution needs: ordinary edges, waits and contingent links, in ticks. The arrays are read-only.

    `edges`: (e, 3) rows x, y, weight: `t_y - t_x <= weight`; one row a pair, sorted by x, then y.
    `waits`: (w, 3) rows contingent, x, weight (negative): x waits until the contingent's end has happened or until
    -weight after its activation; sorted by contingent, then x.
    `contingents`: (k, 5) rows activation, end, min, max, link: the durations that nature decides, and the link's index.
    """

    timepoints: tuple[str, ...]
    ticks_per_unit: int
    edges: IntArray
    waits: IntArray
    contingents: IntArray

    def __repr__(self) -> str:
        return (
            f"DispatchableNetwork({len(self.timepoints)} timepoints, {len(self.edges)} edges, {len(self.waits)} waits)"
        )

    @cached_property
    def leaving(self) -> IntArray:
        """(n + 1,): the edges leaving x are rows `leaving[x]` to `leaving[x + 1]` of `edges`."""
        return np.searchsorted(self.edges[:, 0], np.arange(len(self.timepoints) + 1))

    @cached_property
    def by_target(self) -> IntArray:
        """`edges` sorted by y."""
        return self.edges[np.argsort(self.edges[:, 1], kind="stable")]

    @cached_property
    def entering(self) -> IntArray:
        """(n + 1,): the edges entering y are rows `entering[y]` to `entering[y + 1]` of `by_target`."""
        return np.searchsorted(self.by_target[:, 1], np.arange(len(self.timepoints) + 1))

    @cached_property
    def waiting(self) -> IntArray:
        """(k + 1,): the waits on contingent c are rows `waiting[c]` to `waiting[c + 1]` of `waits`."""
        return np.searchsorted(self.waits[:, 0], np.arange(len(self.contingents) + 1))


@dataclass(frozen=True, eq=False)
class Verdict:
    """The answer of `check`: the network to dispatch, or the conflict as indices into the network's links, sorted.

    The links of a conflict alone, without the rest of the network, are already not controllable.
    """

    controllable: bool
    network: DispatchableNetwork | None
    conflict: tuple[int, ...]


def check(stnu: Stnu) -> Verdict:
    """Whether the network is dynamically controllable, and the form to dispatch or why not.

    Also finds a network that cannot be satisfied at all. A contingent link with min == max constrains like an ordinary
    one; its end is still nature's to perform, so a circle of such links of duration 0 never begins: not controllable.
    """
    return check_with(_fastest(), stnu)


def check_with(check_links: CheckLinks, stnu: Stnu) -> Verdict:
    """`check` by a given implementation: `check_links` of the compiled kernel or of its plain twin."""
    circle = _circle_of_instants(stnu)
    if circle:
        return Verdict(False, None, circle)
    edges, waits, conflict, found = check_links(len(stnu.timepoints), stnu.table)
    if found:
        return Verdict(False, None, tuple(conflict.tolist()))
    return Verdict(True, _network(stnu, edges, waits), ())


def original_network(stnu: Stnu) -> DispatchableNetwork:
    """The links as they are, nothing derived: for executing a network that is not controllable as well as one can."""
    tightest: dict[tuple[int, int], int] = {}
    for from_, to, lower, upper, _ in stnu.table.tolist():
        for x, y, weight in ((from_, to, upper), (to, from_, -lower)):
            if weight != UNBOUNDED:
                tightest[x, y] = min(weight, tightest.get((x, y), weight))
    rows = np.array([(x, y, weight) for (x, y), weight in sorted(tightest.items())], dtype=np.int64)
    return _network(stnu, rows.reshape(-1, 3), np.empty((0, 3), np.int64))


def check_file(path: Path) -> dict[str, object]:
    """One line of a report: file, dynamically_controllable, milliseconds (of the check alone), conflict (link indices).

    Raises NetworkFormatError for a file that is not a network.
    """
    stnu = Stnu.load(path)
    _fastest()
    begin = time.perf_counter()
    verdict = check(stnu)
    milliseconds = 1e3 * (time.perf_counter() - begin)
    return {
        "file": str(path),
        "dynamically_controllable": verdict.controllable,
        "milliseconds": round(milliseconds, 3),
        "conflict": list(verdict.conflict),
    }


def _circle_of_instants(stnu: Stnu) -> tuple[int, ...]:
    """Contingent links of duration 0 that begin one another in a circle, if any; any longer circle is inconsistent."""
    instants = np.nonzero((stnu.table[:, CONTINGENT] != 0) & (stnu.table[:, MAX] == 0))[0].tolist()
    begun_by = {int(stnu.table[link, TO]): (int(stnu.table[link, FROM]), link) for link in instants}
    while begun_by:
        node, path = next(iter(begun_by)), list[int]()
        seen: dict[int, int] = {}
        while node in begun_by and node not in seen:
            seen[node] = len(path)
            node, link = begun_by[node]
            path.append(link)
        if node in seen:
            return tuple(sorted(path[seen[node] :]))
        begun_by = {end: begin for end, begin in begun_by.items() if end not in seen}
    return ()


def _network(stnu: Stnu, edges: IntArray, waits: IntArray) -> DispatchableNetwork:
    chosen = np.nonzero(stnu.table[:, CONTINGENT])[0]
    contingents = np.column_stack((stnu.table[chosen][:, (FROM, TO, MIN, MAX)], chosen))
    for array in (edges, waits, contingents):
        array.setflags(write=False)
    return DispatchableNetwork(stnu.timepoints, stnu.ticks_per_unit, edges, waits, contingents)


@cache
def _fastest() -> CheckLinks:
    """The compiled kernel, loaded when first needed, or its plain twin where numba is missing."""
    try:
        from planner.temporal import _controllability_kernel as kernel
    except ImportError:
        from planner.temporal import _controllability_python as plain

        return plain.check_links
    kernel.check_links(2, Stnu.from_ticks("ab", [(0, 1, 0, 1, True)]).table)  # compiles, or loads what was compiled
    return kernel.check_links
