#!/usr/bin/python3
"""What each effect costs a frame and what it changes, what a wanted property costs, and whether a muscle comes back.

Runs scenes with the `standard` preset: with their own effects, with all, with each of all left out and with each added to
their own; with the effects that they call for and a rest after the motion; in few large steps with either rule of the tunnelling guard;
and the small scenes that show one effect each. Writes tables (costs, changes, a price list, returns, guards) and figures.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import sys

from musclebench.cases.study_command import add_jobs_option, add_run_options, check_options, end, folders_of, study_parser
from musclebench.effects.effect_report import write_report
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.program.cli import add_scene_options, run_command
from musclebench.program.registry import read_registry
from musclebench.results.disturbance import disturbed, note
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.tables.table_formats import as_text

QUICK_MUSCLE, QUICK_FRAMES = "adductor_brevis", 20
QUICK_SETS = ("own", "all", "own+each")


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("effects", __doc__)
    parser.add_argument("--quick", action="store_true",
                        help=f"a first picture: {QUICK_FRAMES} frames, no effect left out of all")
    add_scene_options(parser, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    parser.add_argument("--repetitions", type=int, default=1, metavar="N", help="of each case (default 1)")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole run, for a quick look")
    add_run_options(parser, timeout=file.timeout_s)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


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
    tables, files = write_report(done, returned, guarded, drawn, folders.out_dir)
    for table in tables:
        print(f"\n{table.caption}\n\n{as_text(table)}")
    busy = disturbed({case.name: read_run(folder).record for case, folder in done.items()})
    if busy:
        print(f"\n{note(busy, len(done))}")
    return end("effects", files, problems)


def main(arguments=None) -> int:
    return run_command("effects", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
