"""Which backend stays numerically stable in which hard case.

Runs each cell of `musclebench hard` (its --list tells what happens in each case, why it is hard and what its bar is) as a
process of its own, writes the matrix as CSV, Markdown and a picture, and draws a strip of each scene that the cases move: at
its start, in its worst frame, at its end. It goes on where it was stopped: complete cells are skipped until the program changes.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from .shared import Tool, add_jobs_option, add_page_option, add_run_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("hard", __doc__)
    parser.add_argument("--all", action="store_true", help="with the long sweeps: many minutes, hours with the real anatomy")
    parser.add_argument("--backend", action="append", metavar="NAME", help="only this one; may be repeated")
    parser.add_argument("--case", action="append", metavar="ID", help="only this one; may be repeated")
    parser.add_argument("--no-pictures", action="store_true", help="only the matrix")
    parser.add_argument("--breaks-are-results", action="store_true",
                        help="exit code 0 where cells break, too: the matrix is to be published as it is")
    add_run_options(parser, timeout=file.timeout_s, is_timed=False)
    add_jobs_option(parser)
    add_page_option(parser)
    parser.set_defaults(data=None, scene=None, muscle=None)
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("hard")))
