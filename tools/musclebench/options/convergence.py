"""How many substeps a muscle needs: the shape at full flexion against the number of substeps a frame.

Runs scenes with the `standard` preset for 5, 10, 20, ... substeps (the time of a frame stays the same), takes the run
with the most substeps as the reference, and writes the distance of each shape to it as a table.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import argparse

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import Tool, add_frames_option, add_jobs_option, add_run_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("convergence", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle")
    usual = file.groups[0].substeps
    parser.add_argument("--substeps", type=_counts, default=usual, metavar="N,N,...",
                        help=f"numbers to compare (default: {','.join(map(str, usual))})")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    add_frames_option(parser)
    add_run_options(parser, timeout=file.timeout_s, is_timed=False)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


def _counts(text: str) -> tuple[int, ...]:
    words = text.split(",")
    if not all(word.isdecimal() and int(word) > 0 for word in words):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 5,10,20")
    return tuple(sorted({int(word) for word in words}))


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("convergence")))
