"""Measures what each effect (an optional part of the model) costs in a frame, and what it changes.

The tool runs scenes of the `standard` preset in these variants:
  - with the scene's own effects, and with each other effect added;
  - with all effects, and with each effect left out;
  - with the effects that `musclebench check` recommends, and a rest after the motion: does the muscle return?
  - in few large steps, with both rules of the tunnelling guard.
It also runs the small scenes that show one effect each. Tables of costs, changes, prices, returns and guards, the figures and
report.html go to --out.

  tools/effects --quick

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import EVERY_SCENE, Tool, add_frames_option, add_jobs_option, add_page_option, add_run_options, study_parser

QUICK_MUSCLE, QUICK_FRAMES = "adductor_brevis", 20


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("effects", __doc__)
    parser.add_argument("--quick", action="store_true",
                        help=f"a first picture: {QUICK_FRAMES} frames, and no runs that leave one effect out")
    add_scene_options(parser, f"{EVERY_SCENE}; with --quick {QUICK_MUSCLE}")
    parser.add_argument("--repetitions", type=int, default=1, metavar="N", help="repetitions of each case (default: 1)")
    parser.add_argument("--backend", metavar="NAME", help="backend of all runs (default: an exact backend)")
    add_frames_option(parser)
    add_run_options(parser, timeout=file.timeout_s)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("effects")))
