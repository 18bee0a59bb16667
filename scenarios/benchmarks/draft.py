"""Plans written down by hand, for benchmarks and tests of execution: no search, no model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from planner.plan import ORIGIN, Bounds, FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken, Value
from planner.problem import TokenPattern

INFINITY = float("inf")


@dataclass
class Draft:
    """A plan being written down. Each timeline's tokens meet; bounds of starts and ends are propagated at the end."""

    horizon: tuple[int, int]
    tokens: dict[str, PlanToken] = field(default_factory=dict)
    lines: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    constraints: list[PlanConstraint] = field(default_factory=list)
    begun: dict[str, int] = field(default_factory=dict)

    def given(self, line: tuple[str, str], pattern: TokenPattern) -> str:
        """A token of the problem's state, which may have begun before the horizon."""
        parameters = {name: str(value) for name, value in pattern.parameters.items()}
        duration: Bounds = (0, None) if pattern.duration == (None, None) else pattern.duration
        token_id = self.token(line, pattern.predicate, duration, parameters, bool(pattern.contingent))
        if pattern.start[0] is not None:
            self.begun[token_id] = pattern.start[0]
        return token_id

    def token(
        self,
        line: tuple[str, str],
        predicate: str,
        duration: Bounds = (0, None),
        parameters: Mapping[str, Value] | None = None,
        contingent: bool = False,
        goal: str | None = None,
        master: str | None = None,
    ) -> str:
        """Add a token at the end of a line `(object, attribute)`; returns its id."""
        token_id = f"t{len(self.tokens) + 1}"
        before = self.lines.setdefault(line, [])
        if before:
            self.at(f"{before[-1]}.end", f"{token_id}.start", 0, 0, "meets")
        before.append(token_id)
        any_time: Bounds = (None, None)
        self.tokens[token_id] = PlanToken(
            token_id, *line, predicate, parameters or {}, any_time, any_time, duration, contingent, goal, False, master
        )
        return token_id

    def at(self, from_: str, to: str, lower: int | None, upper: int | None, why: str) -> None:
        """Add the constraint lower <= to - from_ <= upper."""
        self.constraints.append(PlanConstraint(from_, to, lower, upper, why))

    def plan(self) -> FlexiblePlan:
        """The plan so far, its bounds propagated."""
        bounds = self._propagated()
        tokens = tuple(
            replace(token, start=bounds[f"{i}.start"], end=bounds[f"{i}.end"]) for i, token in self.tokens.items()
        )
        lines = tuple(PlanTimeline(*line, tuple((i,) for i in ids)) for line, ids in self.lines.items())
        objects = tuple(dict.fromkeys(line[0] for line in self.lines))
        return FlexiblePlan("scripted", self.horizon, objects, lines, tokens, tuple(self.constraints))

    def _propagated(self) -> dict[str, Bounds]:
        """Bellman and Ford, plainly. A token that no rule and no goal asked for holds at the start of the horizon."""
        opening = self.horizon[0]
        lower = {f"{i}.{which}": float(opening) for i in self.tokens for which in ("start", "end")} | {ORIGIN: 0.0}
        upper = dict.fromkeys(lower, INFINITY) | {ORIGIN: 0.0}
        for i, token in self.tokens.items():
            if token.master is None and token.goal is None:
                upper[f"{i}.start"] = float(self.begun.get(i, opening))
                lower[f"{i}.start"] = float(self.begun.get(i, opening))
        links = [(c.from_, c.to, c.min, c.max) for c in self.constraints]
        links += [(f"{i}.start", f"{i}.end", *token.duration) for i, token in self.tokens.items()]
        for _ in lower:
            before = dict(lower), dict(upper)
            for x, y, least, most in links:
                if least is not None:
                    lower[y] = max(lower[y], lower[x] + least)
                    upper[x] = min(upper[x], upper[y] - least)
                if most is not None:
                    upper[y] = min(upper[y], upper[x] + most)
                    lower[x] = max(lower[x], lower[y] - most)
            if before == (lower, upper):
                break
        return {name: (int(lower[name]), None if upper[name] == INFINITY else int(upper[name])) for name in lower}
