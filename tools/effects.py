#!/usr/bin/python3
"""Runs the study of effects and writes its tables and figures. Options: musclebench/options/effects.py."""

import sys

from musclebench.cases.study_command import end, folders_of
from musclebench.effects.effect_report import write_report
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.options.effects import QUICK_FRAMES, QUICK_MUSCLE, parse_arguments
from musclebench.options.shared import check_options
from musclebench.page.of_study import page_of
from musclebench.program.cli import run_command
from musclebench.program.registry import read_registry
from musclebench.results.disturbance import disturbed, note
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.tables.table_formats import as_text

QUICK_SETS = ("own", "all", "own+each")


def run_and_report(arguments) -> int:
    file = of_project("effects")
    options = parse_arguments(arguments, file)
    check_options(options, "effects")
    folders, registry = folders_of(options, "effects"), read_registry(options.musclebench)
    file = file.with_groups(backends=(backend_of(options.backend, registry),))
    if options.quick:
        file = file.with_groups(effects=QUICK_SETS)
        options.frames_limit = options.frames_limit or QUICK_FRAMES
    sweep = sweep_of(file, options, registry, folders, QUICK_MUSCLE if options.quick else None)
    problems = sweep.run(sweep.cases, limits_of(options))
    done, returned, guarded, drawn = (sweep.done(group) for group in ("sets", "returns", "guards", "shown"))
    tables, files = write_report(done, returned, guarded, drawn, dict(registry.effect_colours), folders.out_dir)
    for table in tables:
        print(f"\n{table.caption}\n\n{as_text(table)}")
    busy = disturbed({case.name: read_run(folder).record for case, folder in done.items()})
    if busy:
        print(f"\n{note(busy, len(done))}")
    files = [*files, *page_of("effects", folders.out_dir, options)]
    return end("effects", files, problems, folders.out_dir)


def main(arguments=None) -> int:
    return run_command("effects", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
