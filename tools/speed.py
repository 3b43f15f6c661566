#!/usr/bin/python3
"""Runs coupled runs and kernels and writes the table of targets. Options: musclebench/options/speed.py."""

import sys

from musclebench.cases.study_command import end, folders_of, require_results
from musclebench.experiments.command import print_plan
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.kernels import micro_beside
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.options.shared import check_options
from musclebench.options.speed import parse_arguments
from musclebench.program.cli import check_program, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.speed import quick, speed_report


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
