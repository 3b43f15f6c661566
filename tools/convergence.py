#!/usr/bin/python3
"""How many substeps a muscle needs: the shape at full flexion against the number of substeps a frame.

Runs scenes with the `standard` preset for 5, 10, 20, ... substeps (the time of a frame stays the same), takes the run
with the most substeps as the reference, and writes the distance of each shape to it as a table.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import argparse
import sys

from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits
from musclebench.cases.scene import chosen_names, survey
from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, check_options, end, folders_of, run_missing, study_parser,
)
from musclebench.convergence.convergence_cases import PRESET, ConvergenceCase, backend_of, plan
from musclebench.convergence.convergence_report import write_report
from musclebench.program.cli import add_scene_options, chosen_cores, data_set_of, run_command
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_markdown
from musclebench.results.status import MEASURED

SUBSTEPS = (5, 10, 20, 40, 80, 160)


def parse_arguments(arguments):
    parser = study_parser("convergence", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle")
    parser.add_argument("--substeps", type=_counts, default=list(SUBSTEPS), metavar="N,N,...",
                        help=f"numbers to compare (default: {','.join(map(str, SUBSTEPS))})")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole run, for a quick look")
    add_run_options(parser, timeout=3600.0)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


def _counts(text: str) -> list[int]:
    words = text.split(",")
    if not all(word.isdecimal() and int(word) > 0 for word in words):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 5,10,20")
    return sorted({int(word) for word in words})


class ConvergenceStudy(Experiment):
    final_statuses = MEASURED | {"diverged"}  # with few substeps to diverge is an answer


def planned(options, registry: Registry, folders: Folders) -> list[ConvergenceCase]:
    names = chosen_names(options.scene, options.muscle, data_set_of(options), registry)
    scenes = survey(names, options.musclebench, registry, folders, options.frames_limit, PRESET)
    return plan(scenes, backend_of(options.backend, registry), options.substeps)


def run_and_report(options) -> int:
    check_options(options, "convergence")
    folders = folders_of(options, "convergence")
    cases = planned(options, read_registry(options.musclebench), folders)
    study = ConvergenceStudy(options.musclebench, folders, options.force)
    problems = run_missing(cases, study, Limits(chosen_cores(options.jobs), options.timeout))
    done = [study.folder(case) for case in cases if study.is_complete(case)]
    table, files = write_report(done, folders.out_dir / "tables")
    print(as_markdown(table))
    return end("convergence", files, problems)


def main(arguments=None) -> int:
    return run_command("convergence", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
