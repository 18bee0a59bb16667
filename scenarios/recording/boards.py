"""The two lanes that tell the story at a glance: plan, planner and faults; and what became of the goals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from scenarios.recording.lanes import Block, Lane
from scenarios.recording.style import AMBER, BLUE, DARK_RED, FADED_RED, GREEN, GREY, ORANGE, RED, dim
from scenarios.words import most_like

HEADER_PATH = "/mission/0_plan_planner_fault_goals"
FAULTS_PATH = "/faults"
GOALS_PATHS = ("/goals/1", "/goals/2")
_PLAN, _PLANNER, _FAULT, _GOALS = range(4)
_PLAN_COLOURS = (BLUE, 0x0F766EFF, 0x5B43C8FF, 0x3F6212FF)
_STAGES = {
    "unseen": (DARK_RED, "{name}: not yet detected"),
    "detected": (RED, "{name}: detected, {detail}"),
    "answered": (ORANGE, "{name}: detected, {detail}"),
    "handled": (FADED_RED, "{name}: handled by {detail}"),
}
_SEVERITY = ("handled", "answered", "unseen", "detected")


@dataclass
class _Fault:
    stage: str = "unseen"
    detail: str = ""
    planned_for: bool = False


@dataclass
class HeaderLane:
    """Four lines: the plan in force, what the planner is at, the active faults, the tally of goals.

    `each_fault`: a lane of its own, with a line for each fault from the moment that it occurs until it is gone; a fault
    that comes again has the line that it had.
    """

    lane: Lane = field(default_factory=lambda: Lane(HEADER_PATH, 4))
    each_fault: Lane = field(default_factory=lambda: Lane(FAULTS_PATH, 0))
    plans: int = 0
    _faults: dict[str, _Fault] = field(default_factory=dict)
    _fault_lines: dict[str, int] = field(default_factory=dict)
    _seen_by: dict[str, str] = field(default_factory=dict)
    _latest_fault: str | None = None

    def plan(self, plan_id: str, reason: str, handover: int) -> None:
        """The plan is in force from the handover on, whatever was before."""
        self.lane.withdraw(handover, _PLAN)
        label = f"{plan_id}: {reason}" if reason else plan_id
        colour = _PLAN_COLOURS[self.plans % len(_PLAN_COLOURS)]
        self.lane.put(handover, _PLAN, Block(f"in_force:{plan_id}", label, colour))
        self.plans += 1

    def handed_over(self, time: int, plan_id: str) -> None:
        """The new plan has taken over: what was known when it was asked for is handled by it."""
        handled = [name for name, fault in self._faults.items() if fault.planned_for and fault.stage != "handled"]
        for name in handled:
            self._faults[name] = _Fault("handled", plan_id, True)
        if handled:
            self._draw_faults(time)

    def goals(self, time: int, board: GoalsBoard) -> None:
        """Goals changed."""
        lost = any(status in ("dropped", "missed") for status in board.status.values())
        open_ = any(status in ("pending", "active") for status in board.status.values())
        colour = dim(ORANGE, 0.7) if lost else dim(GREEN, 0.7) if not open_ else 0x3A424EFF
        self.lane.put(time, _GOALS, Block(board.tally(), board.tally(), colour))

    def requested(self, time: int, reason: str) -> None:
        """The planner begins to think, knowing what has been detected."""
        for fault in self._faults.values():
            fault.planned_for = fault.stage != "unseen"
        self._planner(time, f"planning: {reason}", AMBER)

    def adopted(self, time: int, plan_id: str, handover: int) -> None:
        """The planner is done; the plan waits for its handover."""
        self.lane.withdraw(time, _PLANNER)
        if handover > time:
            self._planner(time, f"{plan_id} ready", GREEN)
        self.lane.put(max(time, handover), _PLANNER, None)

    def failed(self, time: int, reason: str) -> None:
        """The planner found no plan."""
        self._planner(time, f"no plan: {reason}", RED)

    def standby(self, time: int, reason: str) -> None:
        """No plan is in force: the spacecraft waits in standby."""
        self.lane.withdraw(time, _PLAN)
        self.lane.put(time, _PLAN, Block(f"standby:{reason}", f"standby: {reason}", AMBER))

    def standby_left(self, time: int) -> None:
        """Standby is over; a plan follows, at this instant or later."""
        if not self.lane.changes_from(time, _PLAN):
            self.lane.put(time, _PLAN, None)

    def fault_injected(self, time: int, name: str) -> None:
        """Something broke; nobody aboard knows."""
        self._faults[name] = _Fault()
        self._draw_faults(time)

    def fault_detected(self, time: int, name: str, diagnosis: str) -> str:
        """The executive noticed. A name that was not injected is taken for the fault, still unseen, most like it.

        Returns the name under which the fault is shown.
        """
        monitor = name
        if name not in self._faults:
            unseen = [known for known, fault in self._faults.items() if fault.stage == "unseen"]
            seen = self._seen_by.get(monitor, "")
            name = seen if seen in self._faults else most_like(unseen, name, diagnosis) or name
        self._seen_by[monitor] = name
        self._faults[name] = _Fault("detected", diagnosis)
        self._latest_fault = name
        self._draw_faults(time)
        return name

    def fault_answered(self, time: int, name: str | None, response: str) -> None:
        """The executive responded, to the fault that was seen under this name, or to the one detected last."""
        name = self._shown(name)
        if name is not None and name in self._faults:
            seen = self._faults[name].detail if self._faults[name].stage in ("detected", "answered") else ""
            known, _, _ = seen.partition("; ")
            self._faults[name] = _Fault("answered", f"{known}; {response}" if known else response)
            self._draw_faults(time)

    def fault_recovered(self, time: int, name: str | None, cured: bool) -> None:
        """A recovery worked: the fault is gone, or is still there and worked around."""
        name = self._shown(name)
        if name is not None and name in self._faults:
            how = self._faults[name].detail.rpartition("; ")[2] or "recovery"
            self._faults[name] = _Fault("handled", how if cured else f"{how}, worked around")
            self._draw_faults(time)

    def _shown(self, name: str | None) -> str | None:
        """The name under which the fault is shown that was seen under this one."""
        if name is None or name in self._faults:
            return name or self._latest_fault
        return self._seen_by.get(name, self._latest_fault)

    def fault_cleared(self, time: int, name: str) -> None:
        """The fault is gone."""
        self._faults.pop(name, None)
        self._draw_faults(time)

    def faults(self) -> list[tuple[str, str]]:
        """Active faults: name and what is known of each."""
        return [(name, self._text(name, fault)) for name, fault in self._faults.items()]

    def _draw_faults(self, time: int) -> None:
        block = None
        if self._faults:
            worst = max((fault.stage for fault in self._faults.values()), key=_SEVERITY.index)
            text = " | ".join(text for _, text in self.faults())
            block = Block(f"fault:{text}", text, _STAGES[worst][0])
        self.lane.put(time, _FAULT, block)
        for name in self._faults:
            if name not in self._fault_lines:
                self._fault_lines[name] = self.each_fault.add_line()
        for name, line in self._fault_lines.items():
            fault = self._faults.get(name)
            text = "" if fault is None else self._text(name, fault)
            shown = None if fault is None else Block(text, text, _STAGES[fault.stage][0])
            self.each_fault.put(time, line, shown)

    @staticmethod
    def _text(name: str, fault: _Fault) -> str:
        text = _STAGES[fault.stage][1].format(name=name, detail=fault.detail)
        return text.removesuffix(", ").removesuffix(": ")

    def _planner(self, time: int, text: str, colour: int) -> None:
        self.lane.withdraw(time, _PLANNER)
        self.lane.put(time, _PLANNER, Block(f"planner:{text}", text, colour))


GOAL_COLOURS = {
    "pending": 0x3A424EFF,
    "active": 0xB08A2EFF,
    "achieved": GREEN,
    "dropped": ORANGE,
    "missed": RED,
}


@dataclass
class GoalsBoard:
    """A line for each goal: pending, active, then achieved, dropped or missed; in two columns, to show many."""

    lanes: tuple[Lane, ...] = field(default_factory=lambda: tuple(Lane(path, 0) for path in GOALS_PATHS))
    status: dict[str, str] = field(default_factory=dict)
    _places: dict[str, tuple[Lane, int]] = field(default_factory=dict)

    def expect(self, time: int, goals: Iterable[str]) -> None:
        """These goals are to be reached; those already known stay as they are."""
        for goal in goals:
            if goal not in self.status:
                self.change(time, goal, "pending")

    def activate(self, time: int, goal: str) -> None:
        """A token of a pending goal has started."""
        if self.status.get(goal) == "pending":
            self.change(time, goal, "active")

    def change(self, time: int, goal: str, status: str) -> None:
        """The goal has that status from now on."""
        if goal not in self._places:
            lane = self.lanes[len(self._places) % len(self.lanes)]
            self._places[goal] = (lane, lane.add_line())
        self.status[goal] = status
        lane, line = self._places[goal]
        lane.put(time, line, Block(f"{goal}:{status}", f"{goal}: {status}", GOAL_COLOURS.get(status, GREY)))

    def tally(self) -> str:
        """How many of the goals are achieved, and how many are lost."""
        counts = {status: sum(s == status for s in self.status.values()) for status in ("dropped", "missed")}
        achieved = sum(status == "achieved" for status in self.status.values())
        lost = [f", {count} {status}" for status, count in counts.items() if count]
        return f"{achieved} of {len(self.status)} achieved" + "".join(lost)
