"""The `remote-agent` command.

Exit status: 0 done, 1 ran but fell short or broke off on a full disk, 2 bad input (nothing written), 130 interrupted.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from scenarios.campaign.verbs import compare_campaigns, fly_campaign
from scenarios.interrupt import interruptible
from scenarios.progress import loading, progress_bar
from scenarios.status import BAD_INPUT, DONE, FELL_SHORT, INTERRUPTED

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="A spacecraft autonomy testbed: plan, fly, break, replan, record.",
)
stnu_app = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Temporal networks with uncertainty: check and simulate."
)
app.add_typer(stnu_app, name="stnu")
app.command("campaign")(fly_campaign)
app.command("compare")(compare_campaigns)

Includes = Annotated[list[Path] | None, typer.Option("-I", "--include", help="Look here for included files.")]
Procedures = Annotated[
    list[str] | None,
    typer.Option(metavar="FILE.py|MODULE", help="Constraint procedures of the model's own; can be repeated."),
]
Drawing = Annotated[
    Path | None, typer.Option("--svg", metavar="FILE", help="Draw the plan's timelines and constraints here.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on standard output and nothing else there.")]


def main() -> None:
    """Run the command; every complaint about input is one message on standard error and exit status 2."""
    from executive.errors import ExecutiveError
    from planner.errors import PlannerError
    from scenarios.errors import RunBrokenError, ScenarioError
    from sim.errors import SimulatorError

    try:
        app()
    except RunBrokenError as error:
        print(f"remote-agent: {error}", file=sys.stderr)
        sys.exit(FELL_SHORT)
    except (ScenarioError, PlannerError, ExecutiveError, SimulatorError) as error:
        print(f"remote-agent: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)


@app.command("scenarios")
def list_scenarios(
    template: Annotated[bool, typer.Option("--template", help="Print one to start your own from instead.")] = False,
    as_json: AsJson = False,
) -> None:
    """The scenarios that come with the project."""
    from scenarios.config import built_in, load, template_text

    if template:
        print(template_text(), end="")
        return
    rows = [{"name": name, "summary": load(name).summary} for name in built_in()]
    _print_rows(rows, ("name", "summary"), as_json)


@app.command("faults")
def list_faults(as_json: AsJson = False) -> None:
    """The faults that the spacecraft can have, with their parameters."""
    from scenarios.faults import table_of_faults

    _print_rows(table_of_faults(), ("name", "summary"), as_json)


@app.command("engines")
def list_engines(as_json: AsJson = False) -> None:
    """The search engines of the planner."""
    from planner.search.engines import ENGINES

    rows = [{"name": engine.name, "summary": engine.summary} for engine in ENGINES.values()]
    _print_rows(rows, ("name", "summary"), as_json)


@app.command("run")
def run_scenario(
    scenario: Annotated[str, typer.Argument(help="A built-in scenario's name, or the path of a .toml file.")],
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[@TIME]",
            help="Inject this fault instead of the scenario's own; can be repeated. TIME: seconds or 3h20m; without "
            "it, the time that the scenario gives.",
        ),
    ] = None,
    no_faults: Annotated[bool, typer.Option("--no-faults", help="Inject no fault.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of everything that is random.")] = 0,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="The run folder, which must not hold anything yet. Without it: runs/SCENARIO, numbered."
        ),
    ] = None,
    images: Annotated[
        bool, typer.Option("--images/--no-images", help="Record pictures; those from outside need offscreen OpenGL.")
    ] = True,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the run in --out, which was broken off; all else as it was.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Fly a scenario end to end, into a run folder."""
    from scenarios.errors import ScenarioError

    if seed < 0:
        raise ScenarioError(f"--seed: expected a whole number of at least 0, found {seed}")
    if fault and no_faults:
        raise ScenarioError("--fault and --no-faults contradict each other")
    with loading(scenario, as_json):
        from scenarios.config import load
        from scenarios.faults import chosen_faults

        loaded = load(scenario)
        faults = chosen_faults(loaded, [] if no_faults else fault, seed)
    with progress_bar(loaded.name, loaded.horizon, as_json) as (progress, warn), interruptible() as check:
        from scenarios.folder import folder_to_resume, new_folder
        from scenarios.report import write_report
        from scenarios.run import Flight, Listener, RunOptions
        from scenarios.summary import fell_short

        flight = Flight(loaded, RunOptions(seed, faults, images))
        folder = folder_to_resume(out) if resume else new_folder(out, loaded.name)
        try:
            summary = flight.fly(folder, Listener(progress, warn, check), resume)
        except KeyboardInterrupt:
            warn(f"interrupted; what was written so far is readable: {folder}")
            raise typer.Exit(INTERRUPTED) from None
        write_report(folder)
    if as_json:
        print(json.dumps(summary))
    else:
        from scenarios.console import print_summary

        print_summary(summary, folder)
    raise typer.Exit(FELL_SHORT if fell_short(summary) else DONE)


@app.command("replay")
def replay_run(
    run_dir: Annotated[Path, typer.Argument(help="A run folder.")],
    as_json: AsJson = False,
) -> None:
    """Re-run the executive from a run's journal and say whether it does the same, byte for byte."""
    from executive.replay import replay
    from scenarios.ds1.bindings import BINDINGS
    from scenarios.errors import ScenarioError
    from scenarios.folder import JOURNAL

    journal = run_dir / JOURNAL
    if not journal.is_file():
        raise ScenarioError(f"{run_dir}: expected a run folder with {JOURNAL}, found none")
    result = replay(journal, BINDINGS)
    difference = result.first_difference
    if as_json:
        told = None if difference is None else asdict(difference)
        print(json.dumps({"identical": result.identical, "lines": result.lines, "first_difference": told}))
    elif difference is None:
        print(f"{journal}: identical, {result.lines} lines")
    else:
        print(f"{journal}:{difference.line}: recorded {difference.recorded}, replayed {difference.replayed}")
    raise typer.Exit(DONE if result.identical else FELL_SHORT)


@app.command("plan")
def plan_problem(
    problem: Annotated[Path, typer.Argument(help="A problem in NDDL.")],
    engine: Annotated[str, typer.Option(help="The search engine; `remote-agent engines` lists them.")] = "portfolio",
    max_seconds: Annotated[float, typer.Option(min=0.0, help="Give up after this long.")] = 60.0,
    max_steps: Annotated[int | None, typer.Option(min=1, help="Give up after this many decisions.")] = None,
    horizon: Annotated[
        tuple[int, int] | None, typer.Option(metavar="START END", help="Instead of the file's own.")
    ] = None,
    include: Includes = None,
    procedures: Procedures = None,
    out: Annotated[Path | None, typer.Option(help="Write the plan file here.")] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say why each token is there, or which statements leave no plan.")
    ] = False,
    svg: Drawing = None,
    hints: Annotated[
        Path | None,
        typer.Option(help="A TOML file of solver hints; without it the one beside the problem: rover.hints.toml."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random orders that hints ask for.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Plan one problem."""
    from scenarios.plan_verb import plan_file, write_files

    answer = plan_file(
        problem,
        engine=engine,
        horizon=horizon,
        max_seconds=max_seconds,
        max_steps=max_steps,
        include=include or (),
        procedures=procedures or (),
        explain=explain,
        hints=hints,
        seed=seed,
    )
    write_files(answer, out, svg)
    if as_json:
        print(json.dumps(answer.to_json()))
    elif answer.plan is None:
        print(f"{problem}: {answer.reason}")
    else:
        from scenarios.console import print_plan

        print_plan(answer.plan, answer.steps, answer.solve_seconds)
    if answer.explanation is not None and not as_json:
        print("\n".join(answer.explanation.lines()))
    raise typer.Exit(DONE if answer.solved else FELL_SHORT)


@app.command("check")
def check_plan(
    plan: Annotated[Path, typer.Argument(help="A plan file.")],
    problem: Annotated[str, typer.Argument(help="What the plan is for: a scenario's name, a .toml or an .nddl file.")],
    include: Includes = None,
    procedures: Procedures = None,
    svg: Drawing = None,
    as_json: AsJson = False,
) -> None:
    """Judge a plan independently of the planner: every violated requirement by name."""
    from planner.plan import FlexiblePlan
    from scenarios.config import load
    from scenarios.drawing.svg import save
    from scenarios.judging import violations_against, violations_of
    from scenarios.plan_verb import write_file

    judged = FlexiblePlan.load(plan)
    if problem.endswith(".nddl"):
        violations = violations_against(judged, Path(problem), include or (), procedures or ())
    else:
        violations = violations_of(judged, load(problem))
    write_file("--svg", svg, partial(save, judged))
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
    png: Annotated[
        Path | None,
        typer.Option(
            help="A folder for pictures of the recording's tabs, when each fault was noticed and at the end; needs no "
            "display.",
            metavar="DIR",
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            help="With --png: pictures of this time instead, as 3h20m or 1d 02:00; repeatable.", metavar="TIME"
        ),
    ] = None,
    html: Annotated[
        Path | None, typer.Option(help="Write the report page here; needs no display.", metavar="FILE")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Open a run's recording in the Rerun viewer; or, without a display, make pictures of it or its report page."""
    from scenarios.review import moments_of, open_viewer, recording_of, take

    moments = moments_of(at, png)
    made: dict[str, Any] = {}
    if html is not None:
        from scenarios.report import write_report

        made["report"] = str(write_report(run_dir, html))
    if png is not None:
        taken = take(recording_of(run_dir), png, moments, quiet=as_json)
        made["pictures"] = [str(picture) for picture in taken]
    if not made:
        open_viewer(recording_of(run_dir))
    if as_json:
        print(json.dumps(made))
    else:
        for line in (*made.get("pictures", ()), *([made["report"]] if "report" in made else ())):
            print(line)


@app.command("bench")
def bench(
    names: Annotated[
        list[str] | None,
        typer.Argument(help="Which: planner, temporal, executive, sim, run, survival; without any, all."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """The project's own benchmarks, ratios beside the figures; each takes up to some minutes, survival ten."""
    from planner.errors import nearest
    from scenarios.benchmarks.registry import BENCHMARKS
    from scenarios.errors import ScenarioError
    from scenarios.tables import lines

    chosen = names or list(BENCHMARKS)
    for name in chosen:
        if name not in BENCHMARKS:
            raise ScenarioError(
                f"bench: expected one of {', '.join(BENCHMARKS)}, found {name!r}{nearest(name, BENCHMARKS)}"
            )
    for name in chosen:
        figures = BENCHMARKS[name].measure()
        if as_json:
            print(json.dumps(figures if len(chosen) == 1 else {"benchmark": name, **figures}), flush=True)
        else:
            print("\n".join([f"{name}: {BENCHMARKS[name].summary}", *lines(figures, "  ")]), flush=True)


@app.command("doctor")
def examine_machine(as_json: AsJson = False) -> None:
    """What this machine has of what a run needs, and the package to install for what is missing."""
    from sim.doctor import examine

    findings = examine(Path())
    for finding in findings:
        if as_json:
            print(json.dumps(asdict(finding)))
        else:
            state = "ok" if finding.ok else "missing" if finding.required else "optional"
            print(f"{state:9}{finding.need}: {finding.found}{'' if finding.ok else f'; {finding.remedy}'}")
    raise typer.Exit(FELL_SHORT if any(f.required and not f.ok for f in findings) else DONE)


@stnu_app.command("check")
def stnu_check(
    files: Annotated[list[Path], typer.Argument(help="Network files.")],
    as_json: AsJson = False,
) -> None:
    """Whether each network is dynamically controllable: one JSON object a line and file, status 0 either way."""
    from planner.temporal.controllability import check_file
    from planner.temporal.stnu import Stnu

    del as_json  # the lines are JSON either way
    for file in files:
        Stnu.load(file)  # all of them are read before the first is checked: bad input is told before any result
    for file in files:
        print(json.dumps(check_file(file)), flush=True)


@stnu_app.command("simulate")
def stnu_simulate(
    files: Annotated[list[Path], typer.Argument(help="Network files.")],
    runs: Annotated[int, typer.Option(min=1, help="How many executions of each network.")] = 100,
    strategy: Annotated[
        Literal["rte", "stn"],
        typer.Option(help="rte: knows which durations nature decides; stn: takes them for its own to choose."),
    ] = "rte",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the durations that are drawn.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Execute networks against drawn durations: one JSON object a line and file, status 0 whatever came of it."""
    from executive.simulate import simulate_file
    from planner.temporal.stnu import Stnu

    del as_json  # the lines are JSON either way
    for file in files:
        Stnu.load(file)  # all of them are read before the first is executed: bad input is told before any result
    for file in files:
        print(json.dumps(simulate_file(file, runs, strategy, seed)), flush=True)


def _print_rows(rows: list[dict[str, Any]], columns: tuple[str, str], as_json: bool) -> None:
    for row in rows:
        print(json.dumps(row) if as_json else f"{row[columns[0]]:24}{row[columns[1]]}")
