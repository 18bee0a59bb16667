"""The project as a whole: documents that tell the truth, files of a readable size, data that reaches a wheel."""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

from scenarios.cli import app

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("planner", "executive", "sim", "scenarios", "assets")
README = (ROOT / "README.md").read_text(encoding="utf-8")
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

MAX_LINES = 400
LONG_FILES = {
    "planner/temporal/kernel_python.py": "compiled as one unit, with the data layout that all of it shares",
    "planner/temporal/_controllability_kernel.py": "compiled as one unit, twin of the plain Python one",
    "tests/executive/test_executive.py": "one scripted plant, one behaviour a test",
    "tests/executive/test_succession.py": "golden transcripts: most of it is what they say",
    "tests/planner/test_checker.py": "one mutation of a valid plan a case, each with the violation that it must give",
    "tests/executive/test_transcripts.py": "golden transcripts: most of it is what they say",
}
MADE = {".git", ".hypothesis", ".venv", "__pycache__", "build", "dist", "runs"}
FOREIGN = re.compile(
    r"(?<![\w.~$}])/(?:work|home|root|Users|mnt|workspace)/\w"
    r"|\b(?:pypi|pythonhosted|anaconda|debian|ubuntu|npmjs)\.(?:org|com|io|net)\b"
    r"|\b(?:extra-)?index-url\b|\btrusted-host\b|\bfind-links\b"
)


def files_of(*folders: str) -> Iterator[Path]:
    """The project's own files below its folders, those that tools make left out."""
    for folder in folders:
        for place, inner, names in os.walk(ROOT / folder):
            inner[:] = sorted(d for d in inner if d not in MADE and not d.endswith(("_cache", ".egg-info")))
            for name in sorted(set(names) - MADE):  # .git is a file in a work tree beside the first
                yield Path(place, name)


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


PYTHON_FILES = [path for path in files_of(*PACKAGES, "tests") if path.suffix == ".py"]
OWN_FILES = [path for path in PYTHON_FILES if named(path).partition("/")[0] in PACKAGES]


def test_every_file_says_what_it_is_for() -> None:
    silent = [named(p) for p in OWN_FILES if not ast.get_docstring(ast.parse(p.read_text(encoding="utf-8")))]
    assert len(OWN_FILES) > 80
    assert silent == []


def test_files_are_of_a_readable_size() -> None:
    lengths = {named(path): len(path.read_text(encoding="utf-8").splitlines()) for path in PYTHON_FILES}
    too_long = {name for name, lines in lengths.items() if lines > MAX_LINES}
    assert too_long - set(LONG_FILES) == set(), f"split these, or say why not in LONG_FILES: over {MAX_LINES} lines"
    assert set(LONG_FILES) - too_long == set(), "these need no exception any more"


def test_what_numbas_own_cache_keeps_needs_no_other_file() -> None:
    """It watches the file of the function alone; functions that need others go through `sim.kernel_cache`."""
    compiled = [path for path in OWN_FILES if "cache=True)" in path.read_text(encoding="utf-8")]
    sources = {path.with_name("kernel_python.py") if path.stem == "kernel" else path for path in compiled}
    assert len(sources) == 3
    for path in sources:
        imported = [
            node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.ImportFrom)
        ]
        assert [node.module for node in imported if (node.module or "").startswith(PACKAGES)] == [], named(path)


def test_every_folder_of_python_is_a_package() -> None:
    folders = {path.parent for path in PYTHON_FILES}
    assert [named(folder) for folder in sorted(folders) if not (folder / "__init__.py").is_file()] == []


def test_every_data_file_is_declared_for_wheels() -> None:
    """Whatever is not Python and lies in a package must match `package-data`, or an installed project lacks it."""
    declared = PYPROJECT["tool"]["setuptools"]["package-data"]
    assert set(declared) - {"*"} <= set(PACKAGES)
    for package in PACKAGES:
        folder = ROOT / package
        shipped = {path for pattern in declared.get(package, ()) for path in folder.glob(pattern)}
        for path in files_of(package):
            if path.suffix != ".py" and path.name not in declared["*"]:
                assert path in shipped, f"{named(path)} would not be in a wheel"


@pytest.mark.parametrize("package", ["planner", "executive", "sim", "scenarios"])
def test_packages_are_typed(package: str) -> None:
    assert (ROOT / package / "py.typed").is_file()


@pytest.mark.parametrize("package", ["planner", "executive", "sim"])
def test_packages_have_a_page_of_their_own(package: str) -> None:
    text = (ROOT / package / "README.md").read_text(encoding="utf-8")
    assert all(heading in text for heading in ("## Reading order", "## Invariants", "## Decisions"))
    named_files = set(re.findall(r"`([\w/]+\.py)`", text))
    missing = [name for name in named_files if not any((ROOT / base / name).exists() for base in (package, "."))]
    assert missing == []


def test_links_in_documents_lead_somewhere() -> None:
    for document in (path for path in files_of(".") if path.suffix == ".md"):
        for target in re.findall(r"\]\(([^)#:]+)\)", document.read_text(encoding="utf-8")):
            assert (document.parent / target).exists(), f"{named(document)}: {target}"


def test_the_readme_s_make_commands_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))
    told = set(re.findall(r"(?:^    |`)make (?:\w+=\S+ )*([a-z-]+)", README, re.MULTILINE))
    assert {"demo", "test", "clean"} <= told <= targets
    quick_start = README.partition("## Quick start")[2].partition("\n## ")[0]
    assert re.findall(r"^    (.+)$", quick_start, re.MULTILINE) == ["make demo", "make test"]


def test_the_readme_s_verbs_are_those_of_the_command() -> None:
    verbs = {}
    for name, command in typer.main.get_command(app).commands.items():
        inner = getattr(command, "commands", None)
        verbs |= {name: command} if inner is None else {f"{name} {verb}": inner[verb] for verb in inner}
    told = set(re.findall(r"`remote-agent ((?:stnu )?[a-z]+)", README))
    assert told == set(verbs)
    options = {o for verb in verbs.values() for param in verb.params for o in (*param.opts, *param.secondary_opts)}
    assert set(re.findall(r"--[a-z][a-z-]*", README)) - {"--help"} <= options


def test_the_readme_s_example_does_what_it_says() -> None:
    [(code, said)] = re.findall(r"```python\n(.*?)```\n+```text\n(.*?)```", README, re.DOTALL)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {"__name__": "readme"})
    assert printed.getvalue() == said


def test_no_file_speaks_of_one_machine_or_registry() -> None:
    """Set-up reaches whatever index and mirror the machine is set to: nothing names one, nor a path of a machine."""
    found = []
    for path in files_of("."):
        if path.suffix in (".py", ".md", ".toml", ".xml", "") and path != Path(__file__).resolve():
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if FOREIGN.search(line):
                    found.append(f"{named(path)}:{number}: {line.strip()}")
    assert found == []


def test_ci_runs_the_readme_s_test_command() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    lines = [line for line in script.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    assert lines == ["set -euo pipefail", 'cd "$(dirname "${BASH_SOURCE[0]}")/.."', "make test"]


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_make_test_runs_every_check() -> None:
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    planned = subprocess.run(
        ["make", "-n", "test"], cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    ).stdout
    steps = ["scripts/set_up dev", "ruff check", "ruff format --check", "mypy", "lint-imports", "codespell", "pytest"]
    places = [planned.find(step) for step in steps]
    assert -1 not in places
    assert places == sorted(places)


def test_set_up_refuses_an_interpreter_that_will_not_do(tmp_path: Path) -> None:
    """A copy in a folder with a space: one line says what was expected, and nothing is made."""
    place = tmp_path / "a checkout" / "scripts"
    place.mkdir(parents=True)
    shutil.copy(ROOT / "scripts" / "set_up", place)
    old = tmp_path / "old python"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    for kind, python, status, message in (
        ("run", str(old), 1, f"set-up: PYTHON={old}: expected Python 3.11 or newer\n"),
        ("run", "no-such-python", 1, "set-up: PYTHON=no-such-python: expected Python 3.11 or newer\n"),
        ("everything", "", 2, "scripts/set_up: expected run or dev, found everything\n"),
    ):
        result = subprocess.run(
            ["sh", str(place / "set_up"), kind],
            env={**os.environ, "PYTHON": python},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (result.returncode, result.stdout, result.stderr) == (status, "", message)
    assert [p.name for p in place.parent.iterdir()] == ["scripts"]
