"""Two slow judges of dynamic controllability that share nothing with the check: constraint propagation, and a game."""

from __future__ import annotations

from functools import cache

import numpy as np

from planner.temporal.stnu import UNBOUNDED, Stnu

_NONE = 1 << 40


def controllable_by_propagation(stnu: Stnu) -> bool:
    """The reductions of the labelled distance graph to their fixpoint, with the cutoff on the number of rounds
    (Morris and Muscettola, "Temporal dynamic controllability revisited", AAAI 2005), contingent links as they are.
    """
    n = len(stnu.timepoints)
    plain = np.full((n, n), _NONE, dtype=np.int64)
    np.fill_diagonal(plain, 0)
    natural = []
    never_begun = {row[1]: row[0] for row in stnu.table.tolist() if row[4]}
    while leaves := {end for end, begin in never_begun.items() if begin not in never_begun}:
        never_begun = {end: begin for end, begin in never_begun.items() if end not in leaves}
    if never_begun:  # contingent links that wait for one another
        return False
    for a, c, low, high, contingent in stnu.table.tolist():
        if high != UNBOUNDED:
            plain[a, c] = min(plain[a, c], high)
        if low != -UNBOUNDED:
            plain[c, a] = min(plain[c, a], -low)
        if contingent and low < high:
            natural.append((a, c, low, high))
    labelled = np.full((len(natural), n), _NONE, dtype=np.int64)
    for k, (_, c, _, high) in enumerate(natural):
        labelled[k, c] = -high
    for _ in range(n * n + n * len(natural) + len(natural) + 1):
        before = plain.copy(), labelled.copy()
        _reduce(plain, labelled, natural)
        longest = plain.copy()
        for k, (a, *_) in enumerate(natural):
            longest[:, a] = np.minimum(longest[:, a], labelled[k])
        if _has_negative_cycle(longest):
            return False
        if np.array_equal(before[0], plain) and np.array_equal(before[1], labelled):
            return True
    return False


def _reduce(plain: np.ndarray, labelled: np.ndarray, natural: list[tuple[int, int, int, int]]) -> None:
    for middle in range(len(plain)):
        through = plain[:, middle, None] + plain[None, middle, :]
        np.minimum(plain, np.where(through < _NONE // 2, through, _NONE), out=plain)
    for k, (a, _, low, _) in enumerate(natural):
        through = (plain + labelled[k][None, :]).min(axis=1)
        labelled[k] = np.minimum(labelled[k], np.where(through < _NONE // 2, through, _NONE))
        for j, (other_a, other_c, other_low, _) in enumerate(natural):
            if j != k and labelled[k, other_c] < 0:
                labelled[k, other_a] = min(labelled[k, other_a], other_low + labelled[k, other_c])
        # A wait no longer than the least duration is no wait; any wait lasts at least as long as that.
        plain[:, a] = np.minimum(plain[:, a], np.where(labelled[k] < _NONE // 2, np.maximum(labelled[k], -low), _NONE))
    for a, c, low, _ in natural:
        plain[a] = np.where(plain[c] < 0, np.minimum(plain[a], low + plain[c]), plain[a])


def _has_negative_cycle(weights: np.ndarray) -> bool:
    distance = weights.copy()
    for middle in range(len(distance)):
        through = distance[:, middle, None] + distance[None, middle, :]
        np.minimum(distance, np.where(through < _NONE // 2, through, _NONE), out=distance)
        if (np.diagonal(distance) < 0).any():
            return True
    return False


def controllable_by_game(stnu: Stnu) -> bool:
    """Whether the executive wins the game against nature on whole ticks, by trying everything.

    At each tick nature ends what it likes among the running contingent links and the executive sees it; then the
    executive performs timepoints one by one, nature answering at once where a duration may be zero, until it waits.
    For networks of up to about 4 timepoints with bounds of a few ticks.
    """
    n = len(stnu.timepoints)
    rows = stnu.table.tolist()
    natural = {c: (a, low, high) for a, c, low, high, contingent in rows if contingent}
    horizon = sum(abs(bound) for row in rows for bound in row[2:4] if abs(bound) != UNBOUNDED) + 1

    def broken(times: tuple[int | None, ...]) -> bool:
        for a, c, low, high, _ in rows:
            start, end = times[a], times[c]
            if start is not None and end is not None and not low <= end - start <= high:
                return True
        return False

    def with_time(times: tuple[int | None, ...], node: int, now: int) -> tuple[int | None, ...]:
        return (*times[:node], now, *times[node + 1 :])

    @cache
    def nature(times: tuple[int | None, ...], now: int, asked: int) -> bool:
        """Nature decides on links from number `asked` on; the executive must win whatever it does."""
        for c in range(asked, n):
            if c not in natural or times[c] is not None:
                continue
            a, low, high = natural[c]
            start = times[a]
            if start is None or now - start < low:
                continue
            ended = nature(with_time(times, c, now), now, 0)
            return ended and (now - start == high or nature(times, now, c + 1))
        return executive(times, now)

    def begun(node: int) -> tuple[int, ...]:
        return tuple(c for c, (a, low, _) in natural.items() if a == node and low == 0)

    @cache
    def answer(times: tuple[int | None, ...], now: int, pending: tuple[int, ...]) -> bool:
        """Nature may at once end the `pending` links, begun at this instant, and what these begin in turn."""
        if not pending:
            return executive(times, now)
        c, others = pending[0], pending[1:]
        ended = answer(with_time(times, c, now), now, others + begun(c))
        return ended and (natural[c][2] == 0 or answer(times, now, others))

    @cache
    def executive(times: tuple[int | None, ...], now: int) -> bool:
        if broken(times) or now > horizon:
            return False
        if all(time is not None for time in times):
            return True
        for node in range(n):
            if times[node] is None and node not in natural and answer(with_time(times, node, now), now, begun(node)):
                return True
        return nature(times, now + 1, 0)

    return nature((None,) * n, 0, 0)
