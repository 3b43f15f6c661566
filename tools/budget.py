#!/usr/bin/python3
"""Refines each source of error of a scene alone and writes the budget. Options: musclebench/options/budget.py."""

import sys
from dataclasses import replace

from musclebench.budget.budget_report import write_report
from musclebench.cases.study_command import end, folders_of
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import check_backend
from musclebench.figures import looks
from musclebench.options.budget import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import Problem, run_command
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_text


def asked(file: ExperimentFile, options, registry: Registry) -> ExperimentFile:
    """With factors that double up to --finest, and the backends of --backend."""
    groups = []
    for group in file.groups:
        changes = {key: doubled(getattr(group, key), options.finest) for key in ("times_substeps", "times_iterations") if getattr(group, key)}
        if group.name == "collision" and options.backend:
            changes["backends"] = tuple(check_backend(name, registry) for name in options.backend)
        groups.append(replace(group, **changes))
    return replace(file, groups=tuple(groups))


def doubled(factors: tuple[float, ...], finest: int) -> tuple[float, ...]:
    """Those below 2, and then 2, 4, ... as long as they are no more than `finest`."""
    more = [float(2**power) for power in range(1, finest.bit_length()) if 2**power <= finest]
    return (*(factor for factor in factors if factor < 2), *more)


def run_and_report(arguments) -> int:
    file = of_project("budget")
    options = parse_arguments(arguments, file)
    check_options(options, "budget")
    if options.finest < 2:
        raise Problem(f"--finest {options.finest}: nothing is refined; it must be 2 or more")
    folders, registry = folders_of(options, "budget"), read_registry(options.musclebench)
    looks.know(registry)
    sweep = sweep_of(asked(file, options, registry), options, registry, folders)
    problems = sweep.run(sweep.cases, limits_of(options))
    done = sweep.done(*(group.name for group in file.groups))
    if not done:
        return end("budget", [], problems)
    table, sentences, files = write_report(done, folders.out_dir)
    print("\n" + "\n".join([as_text(table), "", *sentences]))
    return end("budget", files, problems, folders.out_dir)


def main(arguments=None) -> int:
    return run_command("budget", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
