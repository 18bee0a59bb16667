"""The verbs `campaign` and `compare`. What they need is imported when they are called: the command starts fast."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from scenarios.interrupt import interruptible
from scenarios.progress import progress_bar
from scenarios.status import DONE, FELL_SHORT, INTERRUPTED


def fly_campaign(
    scenario: Annotated[str, typer.Argument(help="A built-in scenario's name, or the path of a .toml file.")],
    runs: Annotated[int, typer.Option(min=1, help="How many runs.")] = 100,
    faults: Annotated[
        Literal["scenario", "all", "random", "none"],
        typer.Option(help="The scenario's own; each fault there is in turn, at any time; or by chance, one a run."),
    ] = "scenario",
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that differs between runs.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes on this machine.")] = 2,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler instead, such as tcp://host:8786.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The campaign's folder. Without it: campaigns/SCENARIO.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the campaign in the folder.")] = False,
    recorded: Annotated[int, typer.Option(min=0, help="How many of the worst runs to fly again, recorded.")] = 3,
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object on standard output and nothing else there.")
    ] = False,
) -> None:
    """Fly many seeded variations of a scenario, and say what came of them with confidence intervals."""
    from scenarios.campaign.campaign import campaign
    from scenarios.campaign.workers import SchedulerLostError
    from scenarios.config import load
    from scenarios.run import Listener

    loaded = load(scenario)
    folder = out or Path("campaigns", loaded.name)
    with progress_bar(loaded.name, runs, as_json) as (progress, warn), interruptible() as check:
        try:
            found = campaign(
                loaded,
                runs,
                faults,
                seed,
                folder,
                workers=workers,
                scheduler=scheduler,
                resume=resume,
                recorded=recorded,
                listener=Listener(progress, warn, check),
            )
        except SchedulerLostError as error:
            warn(f"{folder}: {error}")
            raise typer.Exit(FELL_SHORT) from None
        except KeyboardInterrupt:
            warn(f"interrupted; what was flown is kept in {folder}: go on with --resume")
            raise typer.Exit(INTERRUPTED) from None
    if as_json:
        print(json.dumps(found))
    else:
        _print_campaign(found, folder)
    total = found["table"][0]
    bad = total["crashed"] or total["rule_violations"] or total["invalid_plans"] or total["unexplained"]
    raise typer.Exit(FELL_SHORT if bad else DONE)


def compare_campaigns(
    before: Annotated[Path, typer.Argument(help="The folder of a campaign.")],
    after: Annotated[Path, typer.Argument(help="The folder of one with the same seed, flown after a change.")],
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object on standard output and nothing else there.")
    ] = False,
) -> None:
    """Compare two campaigns run by run; exit status 1 when the second is worse."""
    from scenarios.campaign.comparison import compare

    found = compare(before, after)
    if as_json:
        print(json.dumps(found))
    else:
        _print_comparison(found)
    raise typer.Exit(FELL_SHORT if found["regression"] else DONE)


def _print_campaign(found: dict[str, Any], folder: Path) -> None:
    from scenarios.tables import lines

    rows = [_for_a_person(row) for row in found["table"]]
    worst = [{name: row[name] for name in ("run", "fault", "outcome", "folder")} for row in found["worst"]]
    seconds = {_TIMINGS[name]: value for name, value in found["timing"].items()}
    shown = {"by fault": rows, "seconds of a run on this machine": seconds, "worst runs, flown again to record": worst}
    print(f"{found['scenario']}: {found['runs']} runs, faults: {found['faults']}, seed {found['seed']}")
    print("\n".join(lines(shown)))
    print("\n".join(_LEGEND))
    print(f"all runs, a row each: {folder / 'runs.parquet'}")


def _print_comparison(found: dict[str, Any]) -> None:
    from scenarios.tables import lines

    runs, change = found["runs"], "was changed in between" if found["scenario_changed"] else "is the same"
    print(f"{runs} runs compared, each with itself before and after; the scenario {change}")
    print(f"runs that missed no goal within reach: {found['kept_before']} before, {found['kept_after']} after")
    shown = {
        "such runs before, but not after": found["lost"],
        "such runs after, but not before": found["gained"],
        "crashed, broke a flight rule, had an invalid plan or lost a goal without a reason, and did not before": found[
            "newly_broken"
        ],
        "changes of a run's mean, after minus before, with 95 % confidence intervals": found["differences"],
    }
    print("\n".join(lines(shown)))
    print(f"chance that so many runs or more differ one way if neither is better: {found['probability']:.3g} (McNemar)")
    print("verdict: " + ("worse than before" if found["regression"] else "not worse than before"))


_TIMINGS = {
    "planning_s_median": "planning, median",
    "planning_s_p99": "planning, 99 of 100 below",
    "wall_s_median": "whole run, median",
}
_LEGEND = (
    "kept: runs that missed no goal within reach; goals: achieved of all; replans: mean; steps: of search, median",
    "makespan h: when the last achieved goal was; rules: of flight, broken; invalid: plans the judge rejects",
    "unexplained: runs that lost a goal without a reason; [ ]: 95 % confidence interval",
)


def _for_a_person(row: dict[str, Any]) -> dict[str, str]:
    return {
        "fault": row["fault"],
        "runs": str(row["runs"]),
        "kept": _share(row["kept"], row["kept_interval"]),
        "goals": _share(row["achieved"], row["achieved_interval"]),
        "replans": _mean(row["replans"], row["replans_interval"]),
        "steps": "" if row["plan_steps_median"] is None else f"{row['plan_steps_median']:.0f}",
        "makespan h": _mean(row["makespan_s_median"], row["makespan_s_interval"], 3600.0),
        "rules": str(row["rule_violations"]),
        "invalid": str(row["invalid_plans"]),
        "unexplained": str(row["unexplained"]),
        "crashed": str(row["crashed"]),
    }


def _share(value: float | None, interval: tuple[float, float] | None) -> str:
    if value is None or interval is None:
        return ""
    return f"{value:.1%} [{interval[0]:.0%} {interval[1]:.0%}]"


def _mean(value: float | None, interval: tuple[float, float] | None, unit: float = 1.0) -> str:
    if value is None or interval is None:
        return ""
    return f"{value / unit:.2f} [{interval[0] / unit:.2f} {interval[1] / unit:.2f}]"
