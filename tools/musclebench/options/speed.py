"""Measures how fast the backends are, against each other and against the targets that the project has set: coupled runs
of four muscles, or of scenes of your own, and Google Benchmark kernels, one after the other on a quiet machine. Prints a
table of what was to be reached, what was measured, how well that is known, and whether the target is held.

A measurement goes on where it was stopped: complete cases are skipped until their arguments, a program or the data
change.
"""

from pathlib import Path

from ..experiments.experiment_file import ExperimentFile, of_project
from ..experiments.kernels import MICRO_PROGRAM
from ..program.cli import add_scene_options, check_program
from ..speed import quick
from .shared import Tool, add_run_options, check_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("speed", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first table in some minutes: one muscle, fewer frames, repetitions and sizes")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {quick.MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"rounds of all cases (default {file.repetitions}; with --quick {quick.REPETITIONS})")
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s, preset="bench")
    how.add_argument("--micro", type=Path, metavar="PROGRAM",
                     help=f"the kernels (default: micro/{MICRO_PROGRAM} beside the program)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="make the table of what is there, run nothing")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_options(options)
    if options.micro:
        check_program(options.micro, "tools/speed")


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("speed")), check)
