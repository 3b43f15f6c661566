"""What the commands that run a study share: the folder, the cases that are missing, the end."""

import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment
from ..cases.pool import Limits, run_cases
from ..program.cli import Problem, out_name_of
from ..program.out_folder import claimed
from .written_files import forget_old_files

PROJECT = Path(__file__).resolve().parents[3]


def folders_of(options, name: str) -> Folders:
    words = [name, *(["quick"] if getattr(options, "quick", False) else []), out_name_of(options)]
    out_dir = options.out or PROJECT / "reports" / "out" / "-".join(words)
    structures_dir = getattr(options, "structures", None)
    return Folders(out_dir.absolute(), options.data and options.data.resolve(), structures_dir and structures_dir.absolute())


def require_results(out_dir: Path) -> None:
    if not (out_dir / "raw").is_dir():
        raise Problem(f"{out_dir}: holds no study; run the study first, or name its folder with --out")


def missing(cases: list[Case], experiment: Experiment) -> list[Case]:
    """Those that are not complete yet; says how many are."""
    todo = [case for case in cases if experiment.wants(case)]
    if len(todo) < len(cases):
        print(f"{len(cases) - len(todo)} of {len(cases)} cases are complete already (--force runs them again)")
    return todo


def run_missing(cases: list[Case], experiment: Experiment, limits: Limits,
                begin: Callable[[], None] = lambda: None) -> list[str]:
    """A line for each case that failed. `begin`: called when the folder is this process's own."""
    todo, out_dir = missing(cases, experiment), experiment.folders.out_dir
    with claimed(out_dir, "raw"):
        begin()
        statuses = run_cases(todo, experiment, limits)
    return [problem_of(case, status, experiment) for case, status in statuses.items()
            if status not in experiment.final_statuses and experiment.is_ever_run(case)]


def problem_of(case: Case, status: str, experiment: Experiment) -> str:
    return f"{case.name}: {status}, see {experiment.folder(case) / 'run.json'}"


def end(name: str, files: Iterable[Path], problems: list[str], out_dir: Path | None = None) -> int:
    """Names the files and tells the problems; the exit code. `out_dir`: of a study whose old tables and figures go."""
    files = list(files)
    if out_dir is not None:
        forget_old_files(out_dir, files)
    print("\nWritten:", *(f"  {path}" for path in files), sep="\n")
    for problem in problems:
        print(f"{name}: {problem}", file=sys.stderr)
    return 1 if problems else 0
