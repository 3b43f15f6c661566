#!/usr/bin/python3
"""Measures how fast the backends are, against each other and against the targets that the project has set: coupled runs
of four muscles, or of scenes of your own, and Google Benchmark kernels, one after the other on a quiet machine. Prints a
table of what was to be reached, what was measured, how well that is known, and whether the target is held.

A measurement goes on where it was stopped: complete cases are skipped until their arguments, a program or the data
change.
"""

import sys
from pathlib import Path

from musclebench.cases.study_command import add_run_options, check_options, end, folders_of, require_results, study_parser
from musclebench.experiments.command import print_plan
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.kernels import MICRO_PROGRAM, micro_beside
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.program.cli import add_scene_options, check_program, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.speed import quick, speed_report


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("speed", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first table in some minutes: one muscle, fewer frames, repetitions and sizes")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {quick.MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"rounds of all cases (default {file.repetitions}; with --quick {quick.REPETITIONS})")
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s, preset="bench")
    how.add_argument("--micro", type=Path, metavar="PROGRAM",
                     help=f"the kernels (default: micro/{MICRO_PROGRAM} beside the program)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="make the table of what is there, run nothing")
    return parser.parse_args(arguments)


def check_input(options) -> None:
    check_options(options, "speed")
    if not options.report_only:
        options.micro = options.micro or micro_beside(options.musclebench)
        check_program(options.micro, "tools/speed")


def measure_and_report(arguments) -> int:
    file = of_project("speed")
    options = parse_arguments(arguments, file)
    check_input(options)
    folders, problems = folders_of(options, "speed"), []
    if options.report_only:
        require_results(folders.out_dir)
    else:
        file, options.jobs = quick.quick(file) if options.quick else file, file.jobs
        sweep = sweep_of(file, options, read_registry(options.musclebench), folders, quick.MUSCLE if options.quick else None)
        if options.dry_run:
            print_plan(sweep.cases, sweep, options.jobs)
            return 0
        problems = sweep.run(sweep.cases, limits_of(options))
    files = speed_report.write_report(folders.out_dir)[1]
    print(f"\n{(folders.out_dir / 'speed.txt').read_text()}\n{speed_report.CAPTION}")
    return end("speed", files, problems)


def main(arguments=None) -> int:
    return run_command("speed", lambda: measure_and_report(arguments),
                       "complete cases are kept, unfinished ones removed (--report-only shows them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
