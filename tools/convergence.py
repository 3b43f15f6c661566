#!/usr/bin/python3
"""Runs scenes with ever more substeps and writes the table. Options: musclebench/options/convergence.py."""

import sys

from musclebench.cases.study_command import end, folders_of
from musclebench.convergence.convergence_report import write_report
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.options.convergence import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_markdown


def run_and_report(arguments) -> int:
    file = of_project("convergence")
    options = parse_arguments(arguments, file)
    check_options(options, "convergence")
    folders, registry = folders_of(options, "convergence"), read_registry(options.musclebench)
    file = file.with_groups(substeps=options.substeps, backends=(backend_of(options.backend, registry),))
    sweep = sweep_of(file, options, registry, folders)
    problems = sweep.run(sweep.cases, limits_of(options))
    table, files = write_report(list(sweep.done("substeps").values()), folders.out_dir / "tables")
    print(as_markdown(table))
    return end("convergence", files, problems, folders.out_dir)


def main(arguments=None) -> int:
    return run_command("convergence", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
