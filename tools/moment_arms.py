#!/usr/bin/python3
"""Moment arms of hip muscles in flexion, beside published ones.

Turns each muscle's joint from rest to both ends of its range (-10 and 90 degrees) with the `standard` preset and the effects
that the scene calls for, in exact contact, follows 100 fibres through the muscle, and writes their moment arms dL/d(angle)
with their band over the fibres, of the muscle as it is and of the activated one, both laid to rest before the joint turns. With --data they stand beside those of the same
hip (Modenese and Kohout 2020), of finite elements (Blemker and Delp 2005) and measurements; of the synthetic hip nothing is
published.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import sys
from dataclasses import replace

from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits
from musclebench.cases.scene import chosen_names, survey
from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, check_options, end, folders_of, run_missing, study_parser,
)
from musclebench.experiments.selection import backend_of
from musclebench.figures.moment_arms import draw_moment_arms
from musclebench.moment_arms.moment_cases import DEGREES_A_FRAME, PRESET, MomentCase, plan
from musclebench.moment_arms.moment_report import arm_table, course_files, course_of
from musclebench.moment_arms.published import read_published
from musclebench.pictures.in_display import draw_in_display
from musclebench.program.cli import Problem, add_scene_options, chosen_cores, data_set_of, run_command
from musclebench.program.registry import Registry, read_registry, save_registry
from musclebench.results.run_folder import ResultProblem, Run, read_all
from musclebench.results.status import MEASURED
from musclebench.tables.table_formats import as_text, write_table


def parse_arguments(arguments):
    parser = study_parser("moment-arms", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle, and those with muscles that no such scene has")
    parser.add_argument("--fibres", type=int, default=100, metavar="N", help="of each muscle (default 100)")
    parser.add_argument("--degrees", type=float, default=DEGREES_A_FRAME, metavar="DEG",
                        help=f"that the joint turns in a frame (default {DEGREES_A_FRAME:g})")
    parser.add_argument("--activation", type=float, default=1.0, metavar="LEVEL",
                        help="of the active muscle, up to 1 (default 1)")
    parser.add_argument("--passive-only", action="store_true", help="run no active muscle")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    add_run_options(parser, timeout=3600.0, is_timed=False)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


class MomentArmStudy(Experiment):
    final_statuses = MEASURED


def planned(options, registry: Registry, folders: Folders) -> list[MomentCase]:
    data_set = data_set_of(options)
    names = chosen_names(options.scene, options.muscle, data_set, registry)
    if not options.scene and not options.muscle:
        names += scenes_with_other_muscles(names, data_set, registry)
    scenes = survey(names, options.musclebench, registry, folders, None, PRESET)
    return plan(scenes, backend_of(options.backend, registry), options.fibres, options.degrees,
                0.0 if options.passive_only else options.activation)


def scenes_with_other_muscles(names: list[str], data_set: str, registry: Registry) -> list[str]:
    """Those of the data set in which a muscle moves that none of the named scenes has."""
    known = {muscle for scene in registry.scenes if scene.name in names for muscle in scene.muscles}
    return [scene.name for scene in registry.scenes
            if scene.name.startswith(f"{data_set}/") and not known.issuperset(scene.muscles)]


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
    if options.activation > 1:
        raise Problem(f"--activation {options.activation:g}: has to be at most 1, that of a whole contraction")
    folders = folders_of(options, "moment-arms")
    registry = read_registry(options.musclebench)
    cases = planned(options, registry, folders)
    published = read_published(folders.data_dir)
    study = MomentArmStudy(options.musclebench, folders, options.force)
    problems = run_missing(cases, study, Limits(chosen_cores(options.jobs), options.timeout))
    passive, active = (read_all([study.folder(case) for case in cases if study.is_complete(case)
                                 and bool(case.activation) == wanted]) for wanted in (False, True))
    courses = {muscle: course_of(some) for muscle, some in runs_by_muscle(passive).items()}
    tense = {muscle: course_of(some) for muscle, some in runs_by_muscle(active).items()}
    if not courses:
        return end("moment-arms", [], problems)
    table = arm_table(courses, tense, published)
    for name in ("tables", "figures"):
        (folders.out_dir / name).mkdir(parents=True, exist_ok=True)
    save_registry(registry, folders.out_dir)
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
