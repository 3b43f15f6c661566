"""Finds out how many substeps a muscle needs in a frame.

The tool runs scenes of the `standard` preset with 5, 10, 20, ... substeps; the time of a frame stays the same. The run with the
most substeps is the reference. A table in --out gives the distance of each shape at full flexion to the reference.

  tools/convergence --muscle iliacus --substeps 5,10,20,40

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

import argparse

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import EVERY_SCENE, Tool, add_frames_option, add_jobs_option, add_run_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("convergence", __doc__)
    add_scene_options(parser, EVERY_SCENE)
    usual = file.groups[0].substeps
    parser.add_argument("--substeps", type=_counts, default=usual, metavar="N,N,...",
                        help=f"numbers of substeps to compare (default: {','.join(map(str, usual))})")
    parser.add_argument("--backend", metavar="NAME", help="backend of all runs (default: an exact backend)")
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
