"""What the commands that run a study share: options and their checks, the folder, the cases that are missing, the end."""

import argparse
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment
from ..cases.pool import Limits, run_cases
from ..program.cli import OneLineParser, Problem, check_data, check_positive, check_program, out_name_of
from ..program.out_folder import claimed
from ..program.release_build import add_build_option

PROJECT = Path(__file__).resolve().parents[3]


def study_parser(name: str, description: str) -> OneLineParser:
    return OneLineParser(prog=f"tools/{name}", description=description,
                         formatter_class=argparse.RawDescriptionHelpFormatter)


def add_run_options(group, timeout: float | None, preset: str = "release", is_timed: bool = True) -> None:
    """`timeout`: None is the experiment's own. `is_timed`: times of the cases are used."""
    group.add_argument("--out", type=Path, metavar="DIR",
                       help="default: reports/out/STUDY-synthetic, -lhdl or -SCENE; STUDY-quick-... with --quick")
    group.add_argument("--timeout", type=float, default=timeout, metavar="SECONDS",
                       help=f"of one case (default: {'the experiment' + chr(39) + 's' if timeout is None else f'{timeout:g} s'})")
    group.add_argument("--force", action="store_true", help="run complete cases again")
    group.add_argument("--musclebench", type=Path, default=PROJECT / "build" / preset / "bench" / "musclebench",
                       metavar="PROGRAM", help=f"the program to measure (default: that of the preset {preset})")
    if is_timed:
        add_build_option(group)


def add_structures_option(group) -> None:
    group.add_argument("--structures", type=Path, metavar="DIR",
                       help="keep built structures here, with the time that building took, where every experiment that names "
                            "the folder finds them by their content (default: in --out, until all cases are complete)")


def add_jobs_option(group) -> None:
    group.add_argument("--jobs", type=int, metavar="N",
                       help="cases at a time, each on a core; 1 gives the quietest times (default: 2, or 1 on one core)")


def check_options(options, name: str) -> None:
    """All numbers are above 0, and only memory may be without limit. Only a report of what is there needs no program."""
    check_data(options.data)
    for option, value in vars(options).items():
        if option == "memory_gb" and value == math.inf:
            continue
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            check_positive(f"--{option.replace('_', '-')}", value)
    if not getattr(options, "report_only", False) and not getattr(options, "merge", None):
        check_program(options.musclebench, f"tools/{name}")


def folders_of(options, name: str) -> Folders:
    words = [name, *(["quick"] if getattr(options, "quick", False) else []), out_name_of(options)]
    out_dir = options.out or PROJECT / "reports" / "out" / "-".join(words)
    structures_dir = getattr(options, "structures", None)
    return Folders(out_dir.absolute(), options.data and options.data.resolve(), structures_dir and structures_dir.absolute())


def require_results(out_dir: Path) -> None:
    if not (out_dir / "raw").is_dir():
        raise Problem(f"{out_dir}: holds no study; run one, or name its folder with --out")


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


def end(name: str, files: Iterable[Path], problems: list[str]) -> int:
    """Names the files and tells the problems; the exit code."""
    print("\nWritten:", *(f"  {path}" for path in files), sep="\n")
    for problem in problems:
        print(f"{name}: {problem}", file=sys.stderr)
    return 1 if problems else 0
