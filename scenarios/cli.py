"""The `remote-agent` command. Exit status: 0 done, 1 ran but fell short, 2 bad input (and nothing written)."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

DONE, FELL_SHORT, BAD_INPUT = 0, 1, 2

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="A spacecraft autonomy testbed: plan, fly, break, replan, record.",
)
stnu_app = typer.Typer(no_args_is_help=True, help="Temporal networks with uncertainty: check and simulate.")
app.add_typer(stnu_app, name="stnu")

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on standard output and nothing else there.")]


def main() -> None:
    """Run the command; every complaint about input is one message on standard error and exit status 2."""
    from executive.errors import ExecutiveError
    from planner.errors import PlannerError
    from scenarios.errors import ScenarioError
    from sim.errors import SimulatorError

    try:
        app()
    except (ScenarioError, PlannerError, ExecutiveError, SimulatorError) as error:
        print(f"remote-agent: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except KeyboardInterrupt:
        print("remote-agent: interrupted; what was written so far is readable", file=sys.stderr)
        sys.exit(130)


@app.command("scenarios")
def list_scenarios(as_json: AsJson = False) -> None:
    """The scenarios that come with the project."""
    from scenarios.config import built_in, load

    rows = [{"name": name, "summary": load(name).summary} for name in built_in()]
    _print_rows(rows, ("name", "summary"), as_json)


@app.command("faults")
def list_faults(as_json: AsJson = False) -> None:
    """The faults that the spacecraft can have."""
    from sim import FAULTS

    rows = [{"name": fault.name, "component": fault.component, "summary": fault.meaning} for fault in FAULTS.values()]
    _print_rows(rows, ("name", "summary"), as_json)


@app.command("engines")
def list_engines(as_json: AsJson = False) -> None:
    """The search engines of the planner."""
    rows = [{"name": "chronological", "summary": "depth first, the newest decision undone first"}]
    _print_rows(rows, ("name", "summary"), as_json)


@app.command("run")
def run_scenario(
    scenario: Annotated[str, typer.Argument(help="A built-in scenario's name, or the path of a .toml file.")],
    fault: Annotated[
        list[str] | None, typer.Option(help="NAME or NAME@TIME (seconds or 3h20m), instead of the scenario's own faults.")
    ] = None,
    no_faults: Annotated[bool, typer.Option("--no-faults", help="Inject no fault.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of everything that is random.")] = 0,
    out: Annotated[Path | None, typer.Option(help="The run folder; made, must not hold anything.")] = None,
    images: Annotated[bool, typer.Option("--images/--no-images", help="Render the cameras.")] = True,
    as_json: AsJson = False,
) -> None:
    """Fly a scenario end to end, into a run folder."""
    from scenarios.config import load
    from scenarios.errors import ScenarioError
    from scenarios.faults import chosen_faults

    if seed < 0:
        raise ScenarioError(f"--seed: expected a whole number of at least 0, found {seed}")
    if fault and no_faults:
        raise ScenarioError("--fault and --no-faults contradict each other")
    loaded = load(scenario)
    faults = chosen_faults(loaded, [] if no_faults else fault)
    with _progress(f"{loaded.name}", loaded.horizon, as_json) as advance:
        from scenarios.folder import new_folder
        from scenarios.run import RunOptions, run
        from scenarios.summary import fell_short

        folder = new_folder(out, loaded.name)
        summary = run(loaded, RunOptions(seed, faults, images), folder, advance)
    if as_json:
        print(json.dumps(summary))
    else:
        from scenarios.console import print_summary

        print_summary(summary, folder)
    raise typer.Exit(FELL_SHORT if fell_short(summary) else DONE)


@app.command("check")
def check_plan(
    plan: Annotated[Path, typer.Argument(help="A plan file.")],
    problem: Annotated[str, typer.Argument(help="The scenario that the plan is for.")],
    as_json: AsJson = False,
) -> None:
    """Judge a plan independently of the planner: every violated requirement by name."""
    from planner.checker import check
    from planner.plan import FlexiblePlan
    from scenarios.config import load
    from scenarios.ds1.capability import capability_of
    from scenarios.ds1.domain import build_model

    judged = FlexiblePlan.load(plan)
    model = build_model(capability_of(load(problem).spacecraft_config()))
    violations = check(judged, model)
    if as_json:
        rows = [{"kind": v.kind, "tokens": list(v.tokens), "explanation": v.explanation} for v in violations]
        print(json.dumps({"valid": not violations, "violations": rows}))
    else:
        print(f"{plan}: {'valid' if not violations else f'{len(violations)} violated requirements'}")
        for violation in violations:
            print(f"  {violation.kind}: {violation.explanation}")
    raise typer.Exit(FELL_SHORT if violations else DONE)


@app.command("review")
def review_run(
    run_dir: Annotated[Path, typer.Argument(help="A run folder.")],
    png: Annotated[Path | None, typer.Option(help="Write pictures of the recording's tabs here; needs no display.")] = None,
    as_json: AsJson = False,
) -> None:
    """Open a run's recording in the Rerun viewer, or make pictures of it."""
    from scenarios.review import open_viewer, recording_of, take

    recording = recording_of(run_dir)
    if png is None:
        open_viewer(recording)
        return
    pictures = take(recording, png)
    if as_json:
        print(json.dumps({"pictures": [str(p) for p in pictures]}))
    else:
        for picture in pictures:
            print(picture)


@stnu_app.command("check")
def stnu_check(
    files: Annotated[list[Path], typer.Argument(help="Network files.")],
    as_json: AsJson = False,
) -> None:
    """Whether each network is dynamically controllable; one JSON line a file."""
    from time import perf_counter

    from planner.temporal.controllability import check
    from planner.temporal.stnu import Stnu

    del as_json  # the lines are JSON either way
    networks = [(file, Stnu.load(file)) for file in files]
    bad = False
    for file, network in networks:
        started = perf_counter()
        verdict = check(network)
        row = {
            "file": str(file),
            "dynamically_controllable": verdict.controllable,
            "milliseconds": round((perf_counter() - started) * 1e3, 3),
            "conflict": list(verdict.conflict),
        }
        print(json.dumps(row))
        bad |= not verdict.controllable
    raise typer.Exit(FELL_SHORT if bad else DONE)


def _print_rows(rows: list[dict[str, Any]], columns: tuple[str, str], as_json: bool) -> None:
    for row in rows:
        print(json.dumps(row) if as_json else f"{row[columns[0]]:24}{row[columns[1]]}")


@contextmanager
def _progress(title: str, total: int, quiet: bool) -> Iterator[Callable[[int], None]]:
    """A progress bar on standard error if that is a terminal, else nothing."""
    if quiet or not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=total)
        yield lambda done: progress.update(task, completed=done)
