#!/usr/bin/python3
"""Draws the schematic diagrams of the pages. They show no measured data."""

import argparse
import sys
from pathlib import Path

from musclebench.diagrams.all_diagrams import draw
from musclebench.program.cli import run_command
from musclebench.program.optional_packages import require

FOLDER = Path(__file__).resolve().parent.parent / "reports" / "pictures"


def draw_and_tell() -> int:
    parser = argparse.ArgumentParser(prog="tools/draw_diagrams.py", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, metavar="FOLDER", default=FOLDER,
                        help="folder of the pictures (default: reports/pictures)")
    folder = parser.parse_args().folder
    require("matplotlib")
    for written in draw(folder):
        print(written)
    return 0


if __name__ == "__main__":
    sys.exit(run_command("draw_diagrams", draw_and_tell, "some diagrams may be missing"))
