#!/usr/bin/python3
"""Runs muscles over their joints' range and writes their moment arms. Options: musclebench/options/moment_arms.py."""

import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd

from musclebench.cases.study_command import end, folders_of
from musclebench.experiments.caveats import caveats
from musclebench.experiments.running import Sweep, limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.figures.moment_arms import draw_moment_arms
from musclebench.moment_arms.moment_report import arm_table, course_files, course_of
from musclebench.moment_arms.published import Published, read_published
from musclebench.options.moment_arms import ACTIVE, PASSIVE, asked_experiment, parse_arguments
from musclebench.options.shared import check_options
from musclebench.pictures.in_display import draw_in_display
from musclebench.page.of_study import page_of
from musclebench.program.cli import Problem, run_command
from musclebench.program.optional_packages import left_out_without
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem, Run, read_all
from musclebench.tables.table_formats import Table, as_text, write_table


def runs_of(kind: str, sweep: Sweep) -> list[Run]:
    groups = [group.name for group in sweep.file.groups if group.name.startswith(kind)]
    return read_all(list(sweep.done(*groups).values()))


def runs_by_muscle(runs: list[Run]) -> dict[str, list[Run]]:
    """With the fibres of that muscle only. A scene of several gives the muscles that have no scene of their own."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        if not is_of_several(run):
            found.setdefault(run.muscle, []).append(run)
    own = set(found)
    for run in filter(is_of_several, runs):
        for muscle, fibres in run.fibres.groupby("muscle"):
            if muscle not in own:
                found.setdefault(str(muscle), []).append(replace(run, fibres=fibres))
    return dict(sorted(found.items()))


def is_of_several(run: Run) -> bool:
    return "muscle" in run.fibres and run.fibres["muscle"].nunique() > 1


def pictured(passive: list[Run], active: list[Run]) -> list[str]:
    """Of each muscle the run that turns farther, of either kind."""
    kinds = [runs_by_muscle(runs) for runs in (passive, active)]
    chosen = [max(kind[muscle], key=lambda run: run.fibres["angle_deg"].abs().max())
              for muscle in kinds[0] for kind in kinds if muscle in kind]
    return list(dict.fromkeys(run.folder.name for run in chosen))


def write_tables(courses: dict[str, pd.DataFrame], tense: dict[str, pd.DataFrame], published: dict[str, Published],
                 out_dir: Path) -> tuple[Table, list[Path]]:
    table = arm_table(courses, tense, published).with_sentence(caveats(out_dir))
    tables = out_dir / "tables"
    tables.mkdir(parents=True, exist_ok=True)
    return table, [*write_table(table, tables), *course_files(courses, tables), *course_files(tense, tables, "_active")]


def run_and_report(options) -> int:
    check_options(options, "moment-arms")
    folders, registry = folders_of(options, "moment-arms"), read_registry(options.musclebench)
    file = asked_experiment(options).with_groups(backends=(backend_of(options.backend, registry),))
    options.jobs, options.timeout = options.jobs or file.jobs, options.timeout or file.timeout_s
    published = read_published(folders.data_dir)
    sweep = sweep_of(file, options, registry, folders)
    problems = sweep.run(sweep.cases, limits_of(options))
    passive, active = runs_of(PASSIVE, sweep), runs_of(ACTIVE, sweep)
    courses = {muscle: course_of(some) for muscle, some in runs_by_muscle(passive).items()}
    tense = {muscle: course_of(some) for muscle, some in runs_by_muscle(active).items()}
    if not courses:
        return end("moment-arms", [], problems)
    table, files = write_tables(courses, tense, published, folders.out_dir)
    (folders.out_dir / "figures").mkdir(exist_ok=True)
    is_drawn = True
    try:
        with left_out_without("the figures"):
            files += draw_moment_arms(courses, tense, published, folders.out_dir / "figures" / "moment_arms")
            files += draw_in_display("fibres", folders.out_dir, pictured(passive, active))
    except Problem as problem:
        is_drawn = False
        problems.append(str(problem))
    print(f"\n{table.caption}\n\n{as_text(table)}")
    files += page_of("moment-arms", folders.out_dir, options)
    return end("moment-arms", files, problems, folders.out_dir if is_drawn else None)


def main(arguments=None) -> int:
    return run_command("moment-arms", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
