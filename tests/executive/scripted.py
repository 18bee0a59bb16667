"""Scripted environments: a plant that follows a table, a small domain, and a planner that lays out turn and image.

The domain: a craft that turns (nature decides how long) and takes images while it holds the target. Goals are images.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from executive.bindings import Activity, Bindings, Finish, Maintained, Standby, plan_next
from executive.conditions import Condition, Telemetry
from executive.executive import Executive
from executive.journal import Journal
from executive.monitor import Diagnoser
from executive.port import Acknowledgement, Command, Observation, Plant, TelemetryValue
from executive.protection import Monitor, Recovery, Response, Step
from executive.records import Settings
from executive.sends import Conclusion, Confirmation, Send
from planner.plan import Bounds, FlexiblePlan
from planner.problem import DroppedGoal, Goal, Planner, PlanningResult, Problem, TokenPattern
from scenarios.benchmarks.draft import Draft


@dataclass(frozen=True)
class Reaction:
    """What one sending of a command does: `after` some seconds `changes` appear. `"$x"` is the argument x.

    `answer`: True accepted, False refused, None a dead terminal.
    """

    after: int = 1
    changes: Mapping[str, TelemetryValue] = field(default_factory=dict)
    answer: bool | None = True
    then: tuple[tuple[int, Mapping[str, TelemetryValue]], ...] = ()


class ScriptedPlant:
    """Follows a table: for each command its reactions (the last one repeats), and what happens by itself."""

    def __init__(
        self,
        telemetry: Mapping[str, TelemetryValue],
        reactions: Mapping[str, Sequence[Reaction]],
        events: Mapping[int, Mapping[str, TelemetryValue]] | None = None,
    ) -> None:
        self.now: int | None = None
        self.sent: list[Command] = []
        self._values: dict[str, TelemetryValue] = dict(telemetry)
        self._changed: dict[str, TelemetryValue] = dict(telemetry)
        self._reactions = {name: list(known) for name, known in reactions.items()}
        self._queue: list[tuple[int, int, Mapping[str, TelemetryValue]]] = [
            (time, number, changes) for number, (time, changes) in enumerate((events or {}).items())
        ]
        self._answers: list[Acknowledgement] = []

    def send(self, command: Command) -> None:
        assert self.now is not None
        self.sent.append(command)
        known = self._reactions.get(command.name)
        if known is None:
            self._answers.append(Acknowledgement(command.id, False, "unknown command"))
            return
        reaction = known.pop(0) if len(known) > 1 else known[0]
        if reaction.answer is not None:
            reason = "" if reaction.answer else "refused by script"
            self._answers.append(Acknowledgement(command.id, reaction.answer, reason))
        for after, changes in ((reaction.after, reaction.changes), *reaction.then):
            filled = {
                name: command.arguments[value[1:]] if isinstance(value, str) and value.startswith("$") else value
                for name, value in changes.items()
            }
            self._queue.append((self.now + after, 1000 + len(self.sent), filled))

    def advance(self, until: int) -> Observation:
        assert self.now is None or until > self.now
        self.now = until
        due = sorted((entry for entry in self._queue if entry[0] <= until), key=lambda entry: entry[:2])
        self._queue = [entry for entry in self._queue if entry[0] > until]
        for _, _, changes in due:
            for name, value in changes.items():
                if self._values.get(name) != value:
                    self._values[name] = self._changed[name] = value
        changes, self._changed = self._changed, {}
        answers, self._answers = tuple(self._answers), []
        return Observation(until, changes, answers)


# -- the domain --------------------------------------------------------------------------------------------------------

AT_START: dict[str, TelemetryValue] = {
    "acs.mode": "hold",
    "acs.target": "earth",
    "acs.settled": True,
    "camera.state": "ready",
    "camera.images": 0,
    "noise": 0.0,
}
DEAD = Conclusion("camera dead", "the camera does not take images any more")
LOST = Conclusion("wheel lost", "the attitude control gave up")
HUNG = Conclusion("camera hung", "the camera hangs")
BY_RESET = Response(
    HUNG.name, (Recovery("reset", (Step((Send("camera.reset"),)),), within=3, attempts=2),), otherwise=DEAD
)


def turn(seconds: int, overhead: int = 1) -> Reaction:
    """A turn that begins to show after `overhead` seconds and is done after `seconds`."""
    moving: dict[str, TelemetryValue] = {"acs.mode": "turn", "acs.target": "$target", "acs.settled": False}
    return Reaction(overhead, moving, then=((seconds, {"acs.mode": "hold", "acs.settled": True}),))


def image(seconds: int, count: int) -> Reaction:
    return Reaction(
        1, {"camera.state": "exposing"}, then=((seconds, {"camera.state": "ready", "camera.images": count}),)
    )


def reactions(**changed: Sequence[Reaction]) -> dict[str, Sequence[Reaction]]:
    """The nominal table; keywords replace rows (`turn`, `image`, `standby`, `halt`, `reset`)."""
    rows: dict[str, Sequence[Reaction]] = {
        "acs.turn": changed.get("turn", [turn(10)]),
        "camera.image": changed.get("image", [image(4, 1), image(4, 2), image(4, 3)]),
        "camera.close": changed.get("close", [Reaction()]),
        "safe.standby": changed.get(
            "standby", [Reaction(2, {"acs.mode": "hold", "acs.target": "earth", "acs.settled": True})]
        ),
        "camera.halt": changed.get("halt", [Reaction(1, {"camera.state": "ready"})]),
        "camera.reset": changed.get("reset", [Reaction(1, {"camera.state": "ready"})]),
    }
    return rows


def state(telemetry: Telemetry, conclusions: frozenset[str]) -> tuple[TokenPattern, ...]:
    camera = "Camera.dead" if "camera dead" in conclusions else "Camera.idle"
    return (
        TokenPattern("Attitude.holding", "acs", {"target": str(telemetry["acs.target"])}),
        TokenPattern(camera, "camera"),
    )


HOLDS = Condition("acs.settled", "==", True)


def bindings(
    *monitors: Monitor,
    image_retries: int = 1,
    hold_early: bool = False,
    responses: tuple[Response, ...] = (BY_RESET,),
) -> Bindings:
    return Bindings(
        activities=(
            Activity(
                "Attitude.turning",
                parameters=("target",),
                contingent=True,
                start=(Send("acs.turn", {"target": "$target"}),),
                started=Confirmation((Condition("acs.target", "==", "$target"),), within=3),
                finish=Finish((Condition("acs.mode", "==", "hold"), HOLDS), hold_early=hold_early),
            ),
            Activity(
                "Attitude.holding",
                parameters=("target",),
                maintained=(Maintained("pointing", (HOLDS, Condition("acs.target", "==", "$target")), persistence=1),),
            ),
            Activity(
                "Camera.imaging",
                parameters=("target",),
                contingent=True,
                start=(Send("camera.image", {"target": "$target"}),),
                started=Confirmation(
                    (Condition("camera.state", "==", "exposing"),), 3, retries=image_retries, conclusion=DEAD
                ),
                finish=Finish((Condition("camera.images", "increased_by", 1),)),
                end=(Send("camera.close"),),
                stop=(Send("camera.halt"),),
            ),
            plan_next("Planner.planNext"),
        ),
        standby=Standby((Send("safe.standby"),), Confirmation((Condition("acs.target", "==", "earth"), HOLDS), 10)),
        state=state,
        state_channels=("acs.target",),
        monitors=monitors,
        responses=responses,
    )


STUCK = Monitor("camera-stuck", (Condition("camera.state", "==", "stuck"),), 2, DEAD)
RESET = replace(STUCK, conclusion=HUNG)
TUMBLES = Monitor("tumbling", (Condition("acs.mode", "==", "tumble"),), 0, LOST)


# -- plans -------------------------------------------------------------------------------------------------------------


ATTITUDE, CAMERA, PLANNER = ("acs", "attitude"), ("camera", "mode"), ("planner", "activity")
LINES = {"Attitude": ATTITUDE, "Camera": CAMERA, "Planner": PLANNER}
TURN, EXPOSURE = (5, 20), (3, 8)


def layout(
    problem: Problem, turn: Bounds = TURN, exposure: Bounds = EXPOSURE, latest_end: int | None = None
) -> FlexiblePlan:
    """For every goal in turn: turn to its target, and image it while holding it; then hold the last one.

    `latest_end`: from the start of the holding to the end of the image.
    """
    draft = Draft(problem.horizon)
    for pattern in problem.state:
        given = draft.given(LINES[pattern.predicate.partition(".")[0]], pattern)
        if pattern.predicate == "Attitude.turning":
            draft.token(ATTITUDE, "Attitude.holding", parameters=draft.tokens[given].parameters, master=given)
        if pattern.predicate == "Camera.imaging":
            draft.token(CAMERA, "Camera.idle", master=given)
            draft.at(f"{given}.end", f"{draft.lines[ATTITUDE][-1]}.end", 0, None, "image while holding")
    for goal in problem.goals:
        if goal.token.predicate == "Planner.planNext":
            asking = draft.token(PLANNER, "Planner.planNext", (1, 20), contingent=True, goal=goal.id)
            draft.token(PLANNER, "Planner.idle", master=asking)
            continue
        target = {"target": goal.id.removeprefix("image-")}
        taken = draft.token(CAMERA, "Camera.imaging", exposure, target, contingent=True, goal=goal.id)
        draft.token(ATTITUDE, "Attitude.turning", turn, target, contingent=True, master=taken)
        held = draft.token(ATTITUDE, "Attitude.holding", parameters=target, master=taken)
        draft.token(CAMERA, "Camera.idle", master=taken)
        draft.at(f"{held}.start", f"{taken}.start", 0, None, f"{goal.id} while holding")
        if latest_end is not None:
            draft.at(f"{held}.start", f"{taken}.end", None, latest_end, f"{goal.id} soon")
        draft.at(f"{taken}.end", f"{held}.end", 0, None, f"{goal.id} while holding")
    return draft.plan()


def planner(problem: Problem) -> PlanningResult:
    """Images as long as the camera lives."""
    if any(pattern.predicate == "Camera.dead" for pattern in problem.state):
        dropped = tuple(DroppedGoal(goal.id, "unreachable", "the camera is dead") for goal in problem.goals)
        return PlanningResult(layout(replace(problem, goals=())), dropped)
    return PlanningResult(layout(problem))


def goals(*names: str) -> tuple[Goal, ...]:
    """Images of those targets, the first with the highest priority."""
    return tuple(
        Goal(f"image-{name}", TokenPattern("Camera.imaging", "camera"), priority=len(names) - i)
        for i, name in enumerate(names)
    )


# -- a run -------------------------------------------------------------------------------------------------------------


@dataclass
class Run:
    """A finished run and its journal."""

    executive: Executive
    text: str

    @property
    def entries(self) -> list[dict[str, object]]:
        return [json.loads(line) for line in self.text.splitlines()]

    def times(self) -> dict[str, int]:
        """When each timepoint was executed, the latest plan's for each name."""
        return {str(e["timepoint"]): int(str(e["t"])) for e in self.entries if e["event"] == "timepoint.executed"}

    def told(self, *events: str) -> list[dict[str, object]]:
        return [entry for entry in self.entries if entry["event"] in events]


def fly(
    plant: Plant,
    bound: Bindings | None = None,
    plan: Planner = planner,
    wanted: tuple[Goal, ...] | None = None,
    horizon: tuple[int, int] = (0, 120),
    settings: Settings | None = None,
    step: Callable[[Executive], None] | None = None,
    diagnosers: tuple[Diagnoser, ...] = (),
) -> Run:
    stream = io.StringIO()
    chosen = settings or Settings("scripted", 1, budget=5, retry_delay=10)
    executive = Executive(
        plant,
        bindings() if bound is None else bound,
        plan,
        goals("vesta") if wanted is None else wanted,
        horizon,
        Journal(stream),
        chosen,
        diagnosers,
    )
    if step is None:
        executive.run_until(horizon[1])
    else:
        step(executive)
    executive.finish()
    return Run(executive, stream.getvalue())


_QUIET = {"observation", "plan.answered", "bounds", "timepoint.executed", "command.acknowledged"}
_INPUTS = ("scenario", "seed", "text", "goals", "settings")
_GOAL = ("contingent", "duration", "end", "object", "parameters", "predicate", "priority", "start")


def transcript(run: Run, since: int = 0, until: int = 1000) -> str:
    """The journal in short: a line an event, without what only a chart needs."""
    lines = []
    for entry in run.entries:
        event = str(entry["event"])
        if event in _QUIET or not since <= int(str(entry["t"])) <= until:
            continue
        words = [f"{entry['t']:>3} {event}"]
        if event.startswith("token."):
            arguments = entry["parameters"]
            assert isinstance(arguments, dict)
            words.append(f"{entry['token']} {entry['predicate']}({', '.join(map(str, arguments.values()))})")
            words += [str(entry[name]) for name in ("verdict", "reason") if name in entry]
        else:
            left_out = ("t", "event", *_INPUTS, *(_GOAL if event == "goal.given" else ()))
            words += [f"{n}={_short(v)}" for n, v in entry.items() if n not in left_out]
        lines.append(" ".join(words))
    return "".join(line + "\n" for line in lines)


def _short(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {v}" for k, v in value.items()) + "}"
    return str(value)
