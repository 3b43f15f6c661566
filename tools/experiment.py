#!/usr/bin/python3
"""Runs the cases of an experiment file and writes their tables. Options: musclebench/options/experiment.py."""

import sys
from pathlib import Path

from musclebench.cases.study_command import end, folders_of, require_results
from musclebench.experiments.case_tables import write_tables
from musclebench.experiments.command import chosen, print_plan
from musclebench.experiments.experiment_file import experiment_path, read_experiment
from musclebench.experiments.merging import merge
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.options.experiment import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_text


def report(out_dir: Path, problems: list[str]) -> int:
    answers, spread, files = write_tables(out_dir)
    if len(spread.rows):
        print(f"\n{spread.caption}\n\n{as_text(spread)}")
    counts = ", ".join(f"{count} {status}" for status, count in answers["status"].value_counts().items())
    print(f"\n{len(answers)} cases: {counts}")
    return end("experiment", files, problems)


def run_and_report(options) -> int:
    check_options(options, "build release")
    file = read_experiment(experiment_path(options.experiment))
    folders = folders_of(options, file.name)
    if options.report_only:
        require_results(folders.out_dir)
        return report(folders.out_dir, [])
    if options.merge:
        return report(folders.out_dir, merge(options.merge, folders.out_dir))
    options.jobs, options.timeout = options.jobs or file.jobs, options.timeout or file.timeout_s
    sweep = sweep_of(file, options, read_registry(options.musclebench), folders)
    cases = chosen(sweep, options.shard, options.filter)
    if options.list_cases:
        print(*(case.name for case in cases), sep="\n")
        return 0
    limits = limits_of(options)
    if options.dry_run:
        print_plan(cases, sweep, len(limits.cores))
        return 0
    return report(folders.out_dir, sweep.run(cases, limits))


def main(arguments=None) -> int:
    return run_command("experiment", lambda: run_and_report(parse_arguments(arguments)),
                       "complete cases are kept, unfinished ones removed (--report-only shows them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
