#!/usr/bin/python3
"""What each effect costs a frame and what it changes, what a wanted property costs, and whether a muscle comes back.

Runs scenes with the `standard` preset: with their own effects, with all, with each of all left out and with each added to
their own; with the effects that they call for and a rest after the motion; in few large steps with either rule of the tunnelling guard;
and the small scenes that show one effect each. Writes tables (costs, changes, a price list, returns, guards) and figures.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import sys

from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits
from musclebench.cases.scene import chosen_names, survey
from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, check_options, end, folders_of, run_missing, study_parser,
)
from musclebench.convergence.convergence_cases import backend_of
from musclebench.effects.effect_cases import PRESET, EffectCase, ShownCase, plan, shown_names
from musclebench.effects.effect_report import write_report
from musclebench.effects.guards import GuardCase, plan_guards
from musclebench.effects.returns import ReturnCase
from musclebench.program.cli import add_scene_options, chosen_cores, data_set_of, run_command
from musclebench.program.registry import Registry, read_registry
from musclebench.results.disturbance import disturbed, note
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.results.status import MEASURED
from musclebench.tables.table_formats import as_text

QUICK_MUSCLE, QUICK_FRAMES = "adductor_brevis", 20


def parse_arguments(arguments):
    parser = study_parser("effects", __doc__)
    parser.add_argument("--quick", action="store_true",
                        help=f"a first picture: {QUICK_FRAMES} frames, no effect left out of all")
    add_scene_options(parser, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    parser.add_argument("--repetitions", type=int, default=1, metavar="N", help="of each case (default 1)")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole run, for a quick look")
    add_run_options(parser, timeout=3600.0)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


class EffectStudy(Experiment):
    final_statuses = MEASURED | {"diverged"}  # without an effect to diverge is an answer


def planned(options, registry: Registry,
            folders: Folders) -> tuple[list[EffectCase], list[ReturnCase], list[GuardCase], list[ShownCase]]:
    names = chosen_names(options.scene, options.muscle, data_set_of(options), registry,
                         QUICK_MUSCLE if options.quick else None)
    frames = options.frames_limit or (QUICK_FRAMES if options.quick else None)
    scenes = survey(names, options.musclebench, registry, folders, frames, PRESET)
    backend = backend_of(options.backend, registry)
    shown = survey(shown_names(registry), options.musclebench, registry, Folders(folders.out_dir))
    return (plan(scenes, registry, backend, options.repetitions, options.quick),
            [ReturnCase(scene, backend) for scene in scenes], plan_guards(scenes, registry, backend),
            [ShownCase(scene, backend) for scene in shown])


def run_and_report(options) -> int:
    check_options(options, "effects")
    folders = folders_of(options, "effects")
    cases, returns, guards, shown = planned(options, read_registry(options.musclebench), folders)
    study = EffectStudy(options.musclebench, folders, options.force)
    problems = run_missing([*returns, *cases, *guards, *shown], study, Limits(chosen_cores(options.jobs), options.timeout))
    done, returned, guarded, drawn = ({case: study.folder(case) for case in some if study.is_complete(case)}
                                      for some in (cases, returns, guards, shown))
    tables, files = write_report(done, returned, guarded, drawn, folders.out_dir)
    for table in tables:
        print(f"\n{table.caption}\n\n{as_text(table)}")
    busy = disturbed({case.name: read_run(folder).record for case, folder in done.items()})
    if busy:
        print(f"\n{note(busy, len(done))}")
    return end("effects", files, problems)


def main(arguments=None) -> int:
    return run_command("effects", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
