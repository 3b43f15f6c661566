"""Makes one HTML file of any folder of results, which needs no network: what was run and on what, tables, charts with the
rows behind them, and the runs in space.

RESULTS_DIR: what tools/paper, tools/accuracy, tools/effects, tools/hard or tools/nightly wrote (its --out), a history of
nights (history.sqlite), `musclebench hard --out`, or a folder of `musclebench run`, or several beside each other. Several make
one page; of no more than 10 MB where runs kept many shapes. Results that can't be read are left out, and the page says so.

Charts and runs in space are made with libraries from npm, once. Where these can't be had, the page is plain: tables, links to
rows, and the pictures that a study drew; it and a line say why.

Exit code: 0 the page was written, also a plain one; 2 nothing was, and one line says why.
"""

import argparse
import shutil
from pathlib import Path

from ..page import FILE_NAME
from ..page.bundle import is_built
from ..program.cli import OneLineParser, Problem
from .shared import Needs, Tool


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/report", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULTS_DIR", help="a folder of results, or a history")
    parser.add_argument("--export", choices=["vtk"],
                        help="instead of a page, the runs that kept their shape as .pvd series for ParaView: muscle with depth and "
                             "attachment of each node, bones in their poses, in metres, times are frames; RESULTS_DIR may be one run's folder")
    parser.add_argument("--out", type=Path, metavar="PATH",
                        help=f"the page (default: {FILE_NAME} in the first folder), or the folder of the export (default: vtk in it)")
    return parser.parse_args(arguments)


def check(options) -> None:
    for folder in options.results:
        if not folder.exists():
            raise Problem(f"{folder}: no such folder of results")


def needs(options) -> Needs:
    """A page has libraries from npm in it, or is plain."""
    has_program = options.export or is_built() or (shutil.which("npm") and shutil.which("node"))
    return Needs(packages=() if has_program else ("nodejs", "npm"), can_go_without=True)


TOOL = Tool(parse_arguments, check, needs)
