#!/usr/bin/python3
"""Makes one HTML file of any folder of results, which needs no network: what was run and on what, tables, charts with the
rows behind them, and the runs in space.

RESULTS_DIR: what tools/paper, tools/accuracy, tools/effects or tools/hard wrote (its --out), or `musclebench hard --out`.
Several folders make one page.
"""

import argparse
import sys
from pathlib import Path

from musclebench.page.page_file import FILE_NAME, write_page
from musclebench.program.cli import OneLineParser, run_command
from musclebench.results.run_folder import ResultProblem


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/report", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULTS_DIR", help="a folder of results")
    parser.add_argument("--out", type=Path, metavar="FILE", help=f"default: {FILE_NAME} in the first folder")
    return parser.parse_args(arguments)


def make_page(options) -> int:
    write_page(options.results, options.out)
    return 0


def main(arguments=None) -> int:
    return run_command("report", lambda: make_page(parse_arguments(arguments)), "the page is whole or not there", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
