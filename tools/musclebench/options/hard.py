"""Shows which backend stays numerically stable in which hard case.

The tool runs each cell (a case with a backend) of `musclebench hard` as a separate process. `musclebench hard --list` explains
the cases. The matrix goes to --out as CSV, Markdown and a picture. A strip of pictures shows each scene: its start, its worst
frame and its end.

  tools/hard --backend sdf --case pinch

You can stop the tool and start it again. It skips complete cells until the program changes.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from .shared import Tool, add_jobs_option, add_page_option, add_run_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("hard", __doc__)
    parser.add_argument("--all", action="store_true", help="also run the long sweeps: many minutes, hours with real anatomy")
    parser.add_argument("--backend", action="append", metavar="NAME", help="run only this backend; may be repeated (default: all)")
    parser.add_argument("--case", action="append", metavar="ID", help="run only this case; may be repeated (default: all)")
    parser.add_argument("--no-pictures", action="store_true", help="write only the matrix")
    parser.add_argument("--breaks-are-results", action="store_true",
                        help="exit with code 0 even if cells break, to publish the matrix as it is")
    add_run_options(parser, timeout=file.timeout_s, is_timed=False)
    add_jobs_option(parser)
    add_page_option(parser)
    parser.set_defaults(data=None, scene=None, muscle=None)
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("hard")))
