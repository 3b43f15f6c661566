"""Runs the paper's experiment: 4 muscles, the paper's 3 backends, and a control without collision.

Beside them run Discregrid's own evaluation (if it is built), FCL as its users advise, and an exact backend.

Tables, figures and report.html go to --out.

  tools/paper                                   the synthetic hip
  tools/paper --data lhdl --frames-limit 20     real muscles, a quick look

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

from ..program.cli import add_scene_options
from .shared import EVERY_SCENE, Tool, add_frames_option, add_jobs_option, add_page_option, add_run_options, study_parser


def parse_arguments(arguments):
    parser = study_parser("paper", __doc__)
    add_scene_options(parser, f"{EVERY_SCENE}, the paper's four")
    add_frames_option(parser)
    add_run_options(parser, timeout=1800.0)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


TOOL = Tool(parse_arguments)
