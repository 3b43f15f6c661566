#!/usr/bin/python3
"""Moment arms of hip muscles in flexion, beside published ones.

Turns each muscle's joint from rest to both ends of its range (-10 and 90 degrees) with the `standard` preset and the effects
that the scene calls for, in exact contact, follows 100 fibres through the muscle, and writes their moment arms dL/d(angle)
with their band over the fibres, of the muscle as it is and of the activated one, both laid to rest before the joint turns
(bench/experiments/moment_arms.toml). With --data they stand beside those of the same hip (Modenese and Kohout 2020), of finite
elements (Blemker and Delp 2005) and measurements; of the synthetic hip nothing is published.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import sys
from dataclasses import replace
from pathlib import Path

from musclebench.cases.study_command import add_jobs_option, add_run_options, check_options, end, folders_of, study_parser
from musclebench.experiments.experiment_file import ExperimentFile, of_project, read_experiment
from musclebench.experiments.running import Sweep, limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.figures.moment_arms import draw_moment_arms
from musclebench.moment_arms.moment_report import arm_table, course_files, course_of
from musclebench.moment_arms.published import read_published
from musclebench.pictures.in_display import draw_in_display
from musclebench.program.cli import Problem, add_scene_options, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem, Run, read_all
from musclebench.tables.table_formats import as_text, write_table

EXPERIMENT = "moment_arms"
PASSIVE, ACTIVE = "passive_", "active_"  # how names of [[cases]] begin


def parse_arguments(arguments):
    parser = study_parser("moment-arms", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle, and those with muscles that no such scene has")
    parser.add_argument("--passive-only", action="store_true", help="run no active muscle")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--experiment", type=Path, metavar="FILE",
                        help=f"of other angles, fibres, activation: a copy of bench/experiments/{EXPERIMENT}.toml whose [[cases]] "
                             f"begin with {PASSIVE} and {ACTIVE}")
    add_run_options(parser, timeout=None, is_timed=False)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


def asked_experiment(options) -> ExperimentFile:
    file = read_experiment(options.experiment) if options.experiment else of_project(EXPERIMENT)
    for group in file.groups:
        if group.mode != "run" or not group.name.startswith((PASSIVE, ACTIVE)):
            raise Problem(f"{file.path}: [[cases]] '{group.name}': moment arms are of mode run, and names begin with {PASSIVE} or "
                          f"{ACTIVE}; rename it, or leave it out")
        if "--fibres" not in group.options:
            raise Problem(f"{file.path}: [[cases]] '{group.name}': follows no fibres; put \"--fibres\", \"100\" into its options")
    groups = tuple(group for group in file.groups if not options.passive_only or group.name.startswith(PASSIVE))
    if not any(group.name.startswith(PASSIVE) for group in groups):
        raise Problem(f"{file.path}: none of its [[cases]] begins with {PASSIVE}; active muscles are compared with those")
    return replace(file, groups=groups)


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
    table = arm_table(courses, tense, published)
    for name in ("tables", "figures"):
        (folders.out_dir / name).mkdir(parents=True, exist_ok=True)
    tables = folders.out_dir / "tables"
    files = [*write_table(table, tables), *course_files(courses, tables), *course_files(tense, tables, "_active"),
             *draw_moment_arms(courses, tense, published, folders.out_dir / "figures" / "moment_arms")]
    try:
        files += draw_in_display("fibres", folders.out_dir, pictured(passive, active))
    except Problem as problem:
        problems.append(str(problem))
    print(f"\n{table.caption}\n\n{as_text(table)}")
    return end("moment-arms", files, problems)


def main(arguments=None) -> int:
    return run_command("moment-arms", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
