#!/usr/bin/python3
"""Measures how fast the backends are, against each other and against the targets that the project has set: coupled runs
of four muscles, or of scenes of your own, and Google Benchmark kernels, one after the other on a quiet machine. Prints a
table of what was to be reached, what was measured, how well that is known, and whether the target is held.

A measurement goes on where it was stopped: complete cases are skipped until their arguments, a program or the data
change.
"""

import argparse
import shutil
import sys
from pathlib import Path

from musclebench.cases.case import Case, Folders
from musclebench.cases.pool import Limits, run_cases
from musclebench.cases.progress import duration
from musclebench.cases.scene import chosen_names, survey
from musclebench.program.cli import (
    OneLineParser, Problem, add_scene_options, check_data, check_positive, check_program, data_set_of, out_name_of,
    run_command,
)
from musclebench.program.machine_state import last_core
from musclebench.program.out_folder import claimed
from musclebench.program.registry import Registry, read_registry, save_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.speed import speed_report
from musclebench.speed.speed_cases import MICRO_PROGRAM, STRUCTURES_DIR
from musclebench.speed.speed_experiment import SpeedExperiment
from musclebench.speed.speed_plan import MAIN_MUSCLE, QUICK_FRAMES, Request, plan

PROJECT = Path(__file__).resolve().parent.parent
PROGRAM = PROJECT / "build" / "bench" / "bench" / "musclebench"
REPETITIONS, QUICK_REPETITIONS = 3, 2


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/speed", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first table in under 3 minutes: one muscle, fewer frames, repetitions and sizes")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {MAIN_MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"rounds of all cases (default {REPETITIONS}; with --quick {QUICK_REPETITIONS})")
    how = parser.add_argument_group("how it runs")
    how.add_argument("--out", type=Path, metavar="DIR", help="default: reports/out/speed[-quick]-synthetic or -lhdl")
    how.add_argument("--timeout", type=float, default=1800.0, metavar="SECONDS", help="of one case (default 1800 s)")
    how.add_argument("--force", action="store_true", help="run complete cases again")
    how.add_argument("--musclebench", type=Path, default=PROGRAM, metavar="PROGRAM",
                     help="the program to measure (default: that of the preset bench)")
    how.add_argument("--micro", type=Path, metavar="PROGRAM",
                     help=f"the kernels (default: micro/{MICRO_PROGRAM} beside the program)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="make the table of what is there, run nothing")
    return parser.parse_args(arguments)


def check_input(options) -> None:
    check_data(options.data)
    for option in ("repetitions", "timeout"):
        check_positive(f"--{option}", getattr(options, option))
    if not options.report_only:
        check_program(options.musclebench, "tools/speed")
        check_program(micro_of(options), "tools/speed")


def micro_of(options) -> Path:
    return options.micro or options.musclebench.resolve().parent / "micro" / MICRO_PROGRAM


def request_of(options, registry: Registry, folders: Folders) -> Request:
    names = chosen_names(options.scene, options.muscle, data_set_of(options), registry,
                         MAIN_MUSCLE if options.quick else None)
    frames = QUICK_FRAMES if options.quick else None
    scenes = survey(names, options.musclebench, registry, folders, frames)
    repetitions = options.repetitions or (QUICK_REPETITIONS if options.quick else REPETITIONS)
    return Request(tuple(scenes), repetitions, options.quick)


def out_dir_of(options) -> Path:
    name = "-".join(["speed", *(["quick"] if options.quick else []), out_name_of(options)])
    return (options.out or PROJECT / "reports" / "out" / name).absolute()


def print_plan(cases: list[Case], experiment: SpeedExperiment) -> None:
    print("  seconds  threads  case")
    for case in cases:
        note = "  (complete)" if not experiment.wants(case) else ""
        print(f"{case.guessed_seconds:9.1f}  {case.threads:7}  {case.name}{note}")
    left = sum(case.guessed_seconds for case in cases if experiment.wants(case))
    print(f"{len(cases)} cases; about {duration(left)} left, one after the other")


def run(cases: list[Case], experiment: SpeedExperiment, options) -> list[str]:
    """Runs what is not complete yet; a line for each case that failed."""
    todo = [case for case in cases if experiment.wants(case)]
    if len(todo) < len(cases):
        print(f"{len(cases) - len(todo)} of {len(cases)} cases are complete already (--force runs them again)")
    # One case at a time: a second one takes cache and memory bandwidth away, and the clock with it.
    with claimed(experiment.folders.out_dir, "raw"):
        # Fields of another build may be in another format, or another field.
        shutil.rmtree(experiment.folders.out_dir / STRUCTURES_DIR, ignore_errors=True)
        statuses = run_cases(todo, experiment, Limits([last_core()], options.timeout))
    return [f"{case.name}: {status}, see {experiment.folder(case) / 'run.json'}"
            for case, status in statuses.items() if status not in experiment.final_statuses]


def measure_and_report(options) -> int:
    check_input(options)
    out_dir, problems = out_dir_of(options), []
    if options.report_only:
        if not (out_dir / "raw").is_dir():
            raise Problem(f"{out_dir}: holds no measurement; run one, or name its folder with --out")
    else:
        registry = read_registry(options.musclebench)
        folders = Folders(out_dir, options.data and options.data.resolve())
        cases = plan(request_of(options, registry, folders), registry)
        experiment = SpeedExperiment(options.musclebench, micro_of(options), folders, options.force)
        if options.dry_run:
            print_plan(cases, experiment)
            return 0
        problems = run(cases, experiment, options)
        save_registry(registry, out_dir)
    table, files = speed_report.write_report(out_dir)
    print(f"\n{(out_dir / 'speed.txt').read_text()}\n{speed_report.CAPTION}\n\nWritten:")
    for path in files:
        print(f"  {path}")
    for problem in problems:
        print(f"speed: {problem}", file=sys.stderr)
    return 1 if problems else 0


def main(arguments=None) -> int:
    return run_command("speed", lambda: measure_and_report(parse_arguments(arguments)),
                       "complete cases are kept, unfinished ones removed (--report-only shows them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
