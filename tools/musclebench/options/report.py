"""Makes one HTML page of folders of results. The page needs no network.

It shows what ran on which machine, tables, charts with the rows behind them, and the runs in 3D. It stays below 10 MB: it leaves
out some of the shapes if runs kept many. It names results that cannot be read.

RESULTS_DIR is one of these; several make one page:
  - the --out folder of tools/paper, tools/accuracy, tools/effects, tools/hard or tools/nightly;
  - a history of nights (history.sqlite);
  - the --out folder of `musclebench run` or `musclebench hard`, or a folder of such folders.

  tools/report reports/out/accuracy-synthetic
  tools/report --export vtk reports/out/runs

Charts and runs in 3D need libraries from npm, once. Without them the page is plain: tables, links to rows, and the pictures that
a study drew. A line and the page say why.

Exit codes: 0 the page was written, also a plain one; 2 nothing was written, and one line says why.
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
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULTS_DIR", help="folder of results, or history of nights")
    parser.add_argument("--export", choices=["vtk"],
                        help="write .pvd series for ParaView instead of a page, from runs that kept shapes: muscles with depth and attachment "
                             "of each node, and bones in their poses. Lengths are in metres, times are frames")
    parser.add_argument("--out", type=Path, metavar="PATH",
                        help=f"file of the page (default: {FILE_NAME} in the first folder), or folder of the export (default: vtk in the "
                             "first folder)")
    return parser.parse_args(arguments)


def check(options) -> None:
    for folder in options.results:
        if not folder.exists():
            raise Problem(f"{folder}: no such folder of results; name the --out of a tool")


def needs(options) -> Needs:
    """A page has libraries from npm in it, or is plain."""
    has_program = options.export or is_built() or (shutil.which("npm") and shutil.which("node"))
    return Needs(packages=() if has_program else ("nodejs", "npm"), can_go_without=True)


TOOL = Tool(parse_arguments, check, needs)
