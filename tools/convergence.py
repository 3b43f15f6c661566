#!/usr/bin/python3
"""How many substeps a muscle needs: the shape at full flexion against the number of substeps a frame.

Runs scenes with the `standard` preset for 5, 10, 20, ... substeps (the time of a frame stays the same), takes the run
with the most substeps as the reference, and writes the distance of each shape to it as a table.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import argparse
import sys

from musclebench.cases.study_command import add_jobs_option, add_run_options, check_options, end, folders_of, study_parser
from musclebench.convergence.convergence_report import write_report
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import backend_of
from musclebench.program.cli import add_scene_options, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_markdown


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("convergence", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle")
    usual = file.groups[0].substeps
    parser.add_argument("--substeps", type=_counts, default=usual, metavar="N,N,...",
                        help=f"numbers to compare (default: {','.join(map(str, usual))})")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole run, for a quick look")
    add_run_options(parser, timeout=file.timeout_s, is_timed=False)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


def _counts(text: str) -> tuple[int, ...]:
    words = text.split(",")
    if not all(word.isdecimal() and int(word) > 0 for word in words):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 5,10,20")
    return tuple(sorted({int(word) for word in words}))


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
    return end("convergence", files, problems)


def main(arguments=None) -> int:
    return run_command("convergence", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
