"""The largest step at which a run stays right: no node on the wrong side of a bone, and the volume within 5 %.

Of each backend and response, with the tunnelling guard and without: the largest rotation a frame, at the scene's time step,
and the largest time step, at the scene's rotation a frame; both by bisection, to a tenth. `musclebench check` and `advise`
take safe_step.json with --safe-step.
"""

import argparse
from pathlib import Path

from ..program.cli import OneLineParser
from .shared import Tool, built_program


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/safe-step", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a .toml file of your own or a scene that 'musclebench list' names")
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder, for lhdl/* scenes")
    parser.add_argument("--preset", metavar="NAME", help="loop and effects (default: the scene's)")
    parser.add_argument("--backend", action="append", metavar="NAME",
                        help="only this one; may be repeated (default: all but the control and those too slow for it)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: reports/out/safe-step-SCENE")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM", default=built_program("release"),
                        help="the program to try (default: that of the preset release)")
    return parser.parse_args(arguments)


TOOL = Tool(parse_arguments)
