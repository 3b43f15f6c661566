"""Measures how fast the backends are, compared with each other and with the project's targets.

The tool runs four muscles, or your scenes, with each backend, and then Google Benchmark kernels. Use an idle machine. The table
gives each target, the measured value, its interval, and whether the target is held. It is printed, and written to --out.

  tools/speed --quick                  a first table in some minutes
  tools/speed --scene my_knee.toml

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

from pathlib import Path

from ..experiments.experiment_file import ExperimentFile, of_project
from ..experiments.kernels import MICRO_PROGRAM
from ..program.cli import add_scene_options, check_program
from ..speed import quick
from .shared import EVERY_SCENE, Tool, add_run_options, check_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("speed", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first table in some minutes: one muscle, fewer frames, repetitions and sizes")
    add_scene_options(what, f"{EVERY_SCENE}; with --quick {quick.MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"rounds over all cases (default: {file.repetitions}; with --quick {quick.REPETITIONS})")
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s, preset="bench")
    how.add_argument("--micro", type=Path, metavar="PROGRAM",
                     help=f"program of the kernels (default: micro/{MICRO_PROGRAM} next to the program to measure)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their estimated times")
    instead.add_argument("--report-only", action="store_true", help="make the table of the results that exist, run nothing")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_options(options)
    if options.micro:
        check_program(options.micro, "tools/speed")


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("speed")), check)
