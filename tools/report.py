#!/usr/bin/python3
"""Makes one HTML file of any folder of results, which needs no network: what was run and on what, tables, charts with the
rows behind them, and the runs in space.

RESULTS_DIR: what tools/paper wrote (its --out). Several folders make one page.
"""

import argparse
import sys
import time
from pathlib import Path

from musclebench.page.bundle import page_script
from musclebench.page.html import page_html
from musclebench.page.sections import sections_of
from musclebench.program.cli import OneLineParser, Problem, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.results.run_folder import ResultProblem

MEGABYTE = 1e6


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/report", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULTS_DIR", help="a folder of results")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: report.html in the first folder")
    return parser.parse_args(arguments)


def write_page(folders: list[Path], out: Path) -> Path:
    """Raises Problem where the page can't be made."""
    started = time.monotonic()
    for folder in folders:
        if not folder.is_dir():
            raise Problem(f"{folder}: no such folder of results")
    script = page_script()
    text = page_html(sections_of(folders), [folder.absolute() for folder in folders], script)
    write_whole(out, text)
    print(f"{out}: {len(text.encode()) / MEGABYTE:.1f} MB, made in {time.monotonic() - started:.0f} s")
    return out


def make_page(options) -> int:
    write_page(options.results, options.out or options.results[0] / "report.html")
    return 0


def main(arguments=None) -> int:
    return run_command("report", lambda: make_page(parse_arguments(arguments)), "the page is whole or not there", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
