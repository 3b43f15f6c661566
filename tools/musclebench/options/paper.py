"""Runs the paper's experiment (4 muscles, 3 backends and a control without collision); makes its tables, figures and page."""

from ..program.cli import add_scene_options
from .shared import Tool, add_frames_option, add_jobs_option, add_page_option, add_run_options, study_parser


def parse_arguments(arguments):
    parser = study_parser("paper", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle, the paper's four")
    add_frames_option(parser)
    add_run_options(parser, timeout=1800.0)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


TOOL = Tool(parse_arguments)
