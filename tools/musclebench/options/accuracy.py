"""Measures what accuracy costs in time: every backend over its resolutions and choices, fed with the same positions
(replay) and driving the muscle (coupled; once more with fibres, for moment arms). Draws figures and price lists from what
it measured.

A study goes on where it was stopped: complete cases are skipped until their arguments, the program or the data change;
cases that failed, timed out or ran out of memory are tried again. Lengths are in mm, times in seconds.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import (
    Tool, add_frames_option, add_jobs_option, add_memory_option, add_page_option, add_run_options, add_shard_option, add_structures_option,
    study_parser,
)

QUICK_MUSCLE = "iliacus"


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("accuracy", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first picture in under 5 minutes: fewer configurations, frames and repetitions")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"of each case; long ones are repeated less (default {file.repetitions}; with --quick 1)")
    what.add_argument("--band-mm", type=float, metavar="MM",
                      help="errors are measured at nodes that are no farther from the surface (default 10 mm)")
    what.add_argument("--longest", type=float, metavar="SECONDS",
                      help="a case that is guessed to take longer is a row with its estimate (default 360 s)")
    add_frames_option(what)
    add_shard_option(what)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s)
    add_jobs_option(how)
    add_page_option(how)
    add_structures_option(how)
    add_memory_option(how)
    how.add_argument("--keep-structures", action="store_true",
                     help="keep the distance fields (about 0.7 GB), which otherwise go at the end")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="draw what is there, run nothing")
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("accuracy")))
