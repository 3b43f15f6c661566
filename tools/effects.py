#!/usr/bin/python3
"""What each effect costs a frame and what it changes, and what a wanted property costs.

Runs scenes with the `standard` preset: with their own effects, with all, with each of all left out and with each added to
their own; and the small scenes that show one effect each. Writes tables (costs, changes, a price list) and figures.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import argparse
import sys
from pathlib import Path

from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits, run_cases
from musclebench.cases.scene import chosen_names, survey
from musclebench.convergence.convergence_cases import usual_backend
from musclebench.effects.effect_cases import PRESET, EffectCase, ShownCase, plan, shown_names
from musclebench.effects.effect_report import write_report
from musclebench.program.cli import (
    OneLineParser, Problem, add_scene_options, check_data, check_positive, check_program, chosen_cores, data_set_of,
    out_name_of, run_command,
)
from musclebench.program.out_folder import claimed
from musclebench.program.registry import Registry, read_registry
from musclebench.results.disturbance import disturbed, note
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.results.status import MEASURED
from musclebench.tables.table_formats import as_text

PROJECT = Path(__file__).resolve().parent.parent
PROGRAM = PROJECT / "build" / "release" / "bench" / "musclebench"
QUICK_MUSCLE, QUICK_FRAMES = "adductor_brevis", 20


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/effects", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true",
                        help=f"a first picture: {QUICK_FRAMES} frames, no effect left out of all")
    add_scene_options(parser, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    parser.add_argument("--repetitions", type=int, default=1, metavar="N", help="of each case (default 1)")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole motion, for a quick look")
    parser.add_argument("--out", type=Path, metavar="DIR",
                        help="default: reports/out/effects[-quick]-synthetic, -lhdl or -SCENE")
    parser.add_argument("--jobs", type=int, metavar="N",
                        help="runs at a time, each on a core; 1 gives the quietest times (default: 2, or 1 on one core)")
    parser.add_argument("--timeout", type=float, default=3600.0, metavar="SECONDS", help="of one run (default 3600)")
    parser.add_argument("--force", action="store_true", help="run complete cases again")
    parser.add_argument("--musclebench", type=Path, default=PROGRAM, metavar="PROGRAM",
                        help="the program to measure (default: that of the preset release)")
    return parser.parse_args(arguments)


def check_input(options) -> None:
    check_program(options.musclebench, "tools/effects")
    check_data(options.data)
    for option in ("jobs", "frames_limit", "timeout", "repetitions"):
        check_positive(f"--{option.replace('_', '-')}", getattr(options, option))


class EffectStudy(Experiment):
    final_statuses = MEASURED | {"diverged"}  # without an effect to diverge is an answer


def backend_of(options, registry: Registry) -> str:
    if options.backend and not registry.has(options.backend):
        raise Problem(f"--backend {options.backend}: not built; there are: {', '.join(registry.names)}")
    return options.backend or usual_backend(registry).name


def planned(options, registry: Registry, folders: Folders) -> tuple[list[EffectCase], list[ShownCase]]:
    names = chosen_names(options.scene, options.muscle, data_set_of(options), registry,
                         QUICK_MUSCLE if options.quick else None)
    frames = options.frames_limit or (QUICK_FRAMES if options.quick else None)
    scenes, backend = survey(names, options.musclebench, registry, folders, frames, PRESET), backend_of(options, registry)
    shown = survey(shown_names(registry), options.musclebench, registry, Folders(folders.out_dir))
    return (plan(scenes, registry, backend, options.repetitions, options.quick),
            [ShownCase(scene, backend) for scene in shown])


def out_dir_of(options) -> Path:
    name = "-".join(["effects", *(["quick"] if options.quick else []), out_name_of(options)])
    return (options.out or PROJECT / "reports" / "out" / name).absolute()


def run_and_report(options) -> int:
    check_input(options)
    folders = Folders(out_dir_of(options), options.data and options.data.resolve())
    cases, shown = planned(options, read_registry(options.musclebench), folders)
    study = EffectStudy(options.musclebench, folders, options.force)
    todo = [case for case in (*cases, *shown) if study.wants(case)]
    if len(todo) < len(cases) + len(shown):
        print(f"{len(cases) + len(shown) - len(todo)} of {len(cases) + len(shown)} runs are complete already "
              "(--force runs them again)")
    with claimed(folders.out_dir, "raw"):
        statuses = run_cases(todo, study, Limits(chosen_cores(options.jobs), options.timeout))
    problems = [f"{case.name}: {status}, see {study.folder(case) / 'run.json'}" for case, status in statuses.items()
                if status not in study.final_statuses]
    done = {case: study.folder(case) for case in cases if study.is_complete(case)}
    tables, files = write_report(done, {case: study.folder(case) for case in shown if study.is_complete(case)},
                                 folders.out_dir)
    for table in tables:
        print(f"\n{table.caption}\n\n{as_text(table)}")
    busy = disturbed({case.name: read_run(folder).record for case, folder in done.items()})
    print("", *filter(None, [note(busy, len(done))]), "Written:", *(f"  {path}" for path in files), sep="\n")
    for problem in problems:
        print(f"effects: {problem}", file=sys.stderr)
    return 1 if problems else 0


def main(arguments=None) -> int:
    return run_command("effects", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
