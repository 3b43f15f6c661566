"""Makes the board: static pages that rank every backend by the error that one can live with. They need no server and no network.

BUNDLE is a zip of tools/bundle, the --out folder of tools/accuracy, or a published study. A folder stands for all zips and published
studies in it, such as reports/measured, also for its hard cases. Times of different bundles are never compared. What stands first
speaks for names, licences and questions, so name what you trust first.

Answers of one version are the same bits on every machine. So anyone can check what others claim: --recompute records each scene,
asks every setting again and judges it. A row with the same answers and errors to the same questions is then verified. If the same
version gives others here, it is refuted and can't win. Times, moment arms and forces stay claimed. With --recomputed, answers come
from results that are here already.

  tools/board reports/measured
  tools/board theirs.zip --recompute

Exit codes: 0 the board is written; 2 nothing was written, and one line says what is wrong; 3 it is written, and rows of a bundle
were refuted.
"""

import argparse
import shutil
from pathlib import Path

from ..page.bundle import BOARD, BUILT, SHAPES, SOURCES, script_file
from ..program.cli import OneLineParser, Problem, check_data, check_positive, check_program
from .shared import BuiltProgram, Needs, Tool, built_program

DEFAULT_OUT = Path("reports/out/board")


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = OneLineParser(prog="tools/board", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bundles", nargs="+", type=Path, metavar="BUNDLE", help="zip of tools/bundle, or folder of results")
    parser.add_argument("--recomputed", action="append", default=[], type=Path, metavar="RESULTS",
                        help="results of tools/accuracy with answers that were computed here; may be repeated")
    parser.add_argument("--recompute", nargs="*", type=Path, metavar="BUNDLE", help="compute the answers of these bundles here (default: of all)")
    parser.add_argument("--longest", type=float, default=120.0, metavar="SECONDS",
                        help="time limit of one setting; what takes longer stays claimed (default: 120 s)")
    parser.add_argument("--within", type=float, default=60.0, metavar="MINUTES",
                        help="time limit of all recomputing; what is left stays claimed (default: 60 min)")
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder, to recompute lhdl/* scenes")
    parser.add_argument("--musclebench", type=Path, default=built_program("release"), metavar="PROGRAM",
                        help="program that recomputes (default: the build of preset release)")
    parser.add_argument("--summary", type=Path, metavar="FILE", help="add tables of the recomputed bundles, else of all, to this Markdown file")
    parser.add_argument("--out", type=Path, default=DEFAULT_OUT, metavar="DIR", help=f"folder of the board (default: {DEFAULT_OUT})")
    return parser.parse_args(arguments)


def check(options: argparse.Namespace) -> None:
    for path in (*options.bundles, *options.recomputed, *(options.recompute or [])):
        if not path.exists():
            raise Problem(f"{path}: no such bundle or folder of results")
    check_data(options.data)
    check_positive("--longest", options.longest)
    check_positive("--within", options.within)
    if options.summary and not options.summary.absolute().parent.is_dir():
        raise Problem(f"--summary {options.summary}: its folder is not there")
    for path in options.recomputed:
        if not (path / "raw").is_dir():
            raise Problem(f"--recomputed {path}: holds no runs; only results of tools/accuracy that were made here verify a row")
    if options.recompute is not None and not isinstance(options.musclebench, BuiltProgram):
        check_program(options.musclebench, "tools/build")


def needs(options: argparse.Namespace) -> Needs:
    is_there = all(script_file(SOURCES, BUILT, entry).is_file() for entry in (BOARD, SHAPES)) or (shutil.which("npm") and shutil.which("node"))
    return Needs(options.musclebench.preset if options.recompute is not None and isinstance(options.musclebench, BuiltProgram) else "",
                 packages=() if is_there else ("nodejs", "npm"))


TOOL = Tool(parse_arguments, check, needs)
