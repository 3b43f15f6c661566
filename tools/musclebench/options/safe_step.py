"""Finds the largest safe step of a scene: no node ends on the wrong side of a bone, and the volume stays within 5 %.

The tool tries each backend and response, with and without the tunnelling guard. It finds the largest rotation in a frame at the
scene's time step, and the largest time step at the scene's rotation. It bisects until the step is known to a tenth.

  tools/safe-step synthetic/iliacus --backend sdf

The results, safe_step.json and a table, go to --out. `musclebench check` and `musclebench advise` read safe_step.json with the
option --safe-step.
"""

import argparse
from pathlib import Path

from ..program.cli import OneLineParser
from .shared import Tool, built_program


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/safe-step", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a scene that `musclebench list` prints, or your .toml file")
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder; lhdl/* scenes need it")
    parser.add_argument("--preset", metavar="NAME", help="preset of loop and effects: paper or standard (default: the scene's)")
    parser.add_argument("--backend", action="append", metavar="NAME",
                        help="try only this backend; may be repeated (default: all except the control and slow backends)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of results (default: reports/out/safe-step-SCENE)")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM", default=built_program("release"),
                        help="program to try (default: the build of preset release)")
    return parser.parse_args(arguments)


TOOL = Tool(parse_arguments)
