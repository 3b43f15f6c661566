#!/usr/bin/python3
"""Measures how fast the backends are, against each other and against the targets that the project has set: coupled runs
of four muscles, or of scenes of your own, and Google Benchmark kernels, one after the other on a quiet machine. Prints a
table of what was to be reached, what was measured, how well that is known, and whether the target is held.

A measurement goes on where it was stopped: complete cases are skipped until their arguments, a program or the data
change.
"""

import shutil
import sys
from pathlib import Path

from musclebench.cases.case import Case, Folders
from musclebench.cases.pool import Limits
from musclebench.cases.progress import duration
from musclebench.cases.scene import chosen_names, survey
from musclebench.cases.study_command import (
    add_run_options, check_options, end, folders_of, require_results, run_missing, study_parser,
)
from musclebench.program.cli import add_scene_options, check_program, data_set_of, run_command
from musclebench.program.machine_state import last_core
from musclebench.program.registry import Registry, read_registry, save_registry
from musclebench.program.release_build import check_release
from musclebench.results.run_folder import ResultProblem
from musclebench.speed import speed_report
from musclebench.speed.speed_cases import MICRO_PROGRAM, STRUCTURES_DIR
from musclebench.speed.speed_experiment import SpeedExperiment
from musclebench.speed.speed_plan import MAIN_MUSCLE, QUICK_FRAMES, Request, plan

REPETITIONS, QUICK_REPETITIONS = 3, 2


def parse_arguments(arguments):
    parser = study_parser("speed", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first table in under 3 minutes: one muscle, fewer frames, repetitions and sizes")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {MAIN_MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"rounds of all cases (default {REPETITIONS}; with --quick {QUICK_REPETITIONS})")
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=1800.0, preset="bench")
    how.add_argument("--micro", type=Path, metavar="PROGRAM",
                     help=f"the kernels (default: micro/{MICRO_PROGRAM} beside the program)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="make the table of what is there, run nothing")
    return parser.parse_args(arguments)


def check_input(options) -> None:
    check_options(options, "speed")
    if not options.report_only:
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


def print_plan(cases: list[Case], experiment: SpeedExperiment) -> None:
    print("  seconds  threads  case")
    for case in cases:
        note = "  (complete)" if not experiment.wants(case) else ""
        print(f"{case.guessed_seconds:9.1f}  {case.threads:7}  {case.name}{note}")
    left = sum(case.guessed_seconds for case in cases if experiment.wants(case))
    print(f"{len(cases)} cases; about {duration(left)} left, one after the other")


def run(cases: list[Case], experiment: SpeedExperiment, options) -> list[str]:
    """Runs what is not complete yet; a line for each case that failed."""
    # One case at a time: a second one takes cache and memory bandwidth away, and the clock with it. Fields of another
    # build may be in another format, or another field.
    stale = experiment.folders.out_dir / STRUCTURES_DIR
    return run_missing(cases, experiment, Limits([last_core()], options.timeout),
                       begin=lambda: shutil.rmtree(stale, ignore_errors=True))


def measure_and_report(options) -> int:
    check_input(options)
    folders, problems = folders_of(options, "speed"), []
    out_dir = folders.out_dir
    if options.report_only:
        require_results(out_dir)
    else:
        registry = read_registry(options.musclebench)
        cases = plan(request_of(options, registry, folders), registry)
        experiment = SpeedExperiment(options.musclebench, micro_of(options), folders, options.force)
        if options.dry_run:
            print_plan(cases, experiment)
            return 0
        if not options.any_build:
            check_release(options.musclebench)
        problems = run(cases, experiment, options)
        save_registry(registry, out_dir)
    table, files = speed_report.write_report(out_dir)
    print(f"\n{(out_dir / 'speed.txt').read_text()}\n{speed_report.CAPTION}")
    return end("speed", files, problems)


def main(arguments=None) -> int:
    return run_command("speed", lambda: measure_and_report(parse_arguments(arguments)),
                       "complete cases are kept, unfinished ones removed (--report-only shows them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
