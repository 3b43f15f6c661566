"""Measures what accuracy costs in time: every backend (a method to detect collisions) at several resolutions and settings.

Replay feeds the same recorded positions to all backends. In a coupled run each backend drives the muscle. A second coupled
run follows fibres, for moment arms. The tables give the price of each error; figures and report.html go to --out, too.

  tools/accuracy --quick                        a first picture in some 6 minutes
  tools/accuracy --quick --backend mine         your own backend and the few that tables compare with: 3 minutes
  tools/accuracy --muscle iliacus --jobs 1      one muscle, quietest times

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed. Cases that failed, timed out or ran out of memory run again, too.
Lengths are in mm, times in seconds.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import (
    EVERY_SCENE, Tool, add_frames_option, add_jobs_option, add_memory_option, add_page_option, add_run_options, add_shard_option,
    add_structures_option, study_parser,
)

QUICK_MUSCLE = "iliacus"


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("accuracy", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first picture in some 6 minutes: fewer settings, frames and repetitions")
    add_scene_options(what, f"{EVERY_SCENE}; with --quick {QUICK_MUSCLE}")
    what.add_argument("--backend", action="append", metavar="NAME",
                      help="measure this backend, and only those that every table compares with: no collision, the unit of price and the fastest "
                           "exact one; may be repeated (default: all backends)")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"repetitions of each case, fewer for long cases (default: {file.repetitions}; with --quick 1)")
    what.add_argument("--band-mm", type=float, metavar="MM",
                      help="measure errors only at nodes no farther than this from the surface (default: 10 mm)")
    what.add_argument("--longest", type=float, metavar="SECONDS",
                      help="skip a case whose estimated time is longer; its row holds the estimate (default: 360 s)")
    add_frames_option(what)
    add_shard_option(what)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s)
    add_jobs_option(how)
    add_page_option(how)
    add_structures_option(how)
    add_memory_option(how)
    how.add_argument("--keep-structures", action="store_true",
                     help="keep the distance fields (about 0.7 GB), which are otherwise deleted at the end")
    how.add_argument("--bundle", action="store_true", help="also write a bundle for the board (tools/board), to OUT.zip")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their estimated times")
    instead.add_argument("--report-only", action="store_true", help="draw the results that exist, run nothing")
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("accuracy")))
