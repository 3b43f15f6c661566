"""What each effect costs a frame and what it changes, what a wanted property costs, and whether a muscle comes back.

Runs scenes with the `standard` preset: with their own effects, with all, with each of all left out and with each added to
their own; with the effects that they call for and a rest after the motion; in few large steps with either rule of the tunnelling guard;
and the small scenes that show one effect each. Writes tables (costs, changes, a price list, returns, guards) and figures.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import Tool, add_frames_option, add_jobs_option, add_page_option, add_run_options, study_parser

QUICK_MUSCLE, QUICK_FRAMES = "adductor_brevis", 20


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("effects", __doc__)
    parser.add_argument("--quick", action="store_true",
                        help=f"a first picture: {QUICK_FRAMES} frames, no effect left out of all")
    add_scene_options(parser, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    parser.add_argument("--repetitions", type=int, default=1, metavar="N", help="of each case (default 1)")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    add_frames_option(parser)
    add_run_options(parser, timeout=file.timeout_s)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("effects")))
