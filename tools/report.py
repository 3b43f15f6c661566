#!/usr/bin/python3
"""Makes one HTML file of any folder of results, which needs no network: what was run and on what, tables, charts with the
rows behind them, and the runs in space.

RESULTS_DIR: what tools/paper, tools/accuracy, tools/effects, tools/hard or tools/nightly wrote (its --out), a history of
nights (history.sqlite), `musclebench hard --out`, or a folder of `musclebench run`, or several beside each other. Several make
one page; of no more than 10 MB where runs kept many shapes. Results that can't be read are left out, and the page says so.
"""

import argparse
import sys
from pathlib import Path

from musclebench.page.page_file import FILE_NAME, write_page
from musclebench.program.cli import OneLineParser, run_command
from musclebench.results.run_folder import ResultProblem


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/report", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULTS_DIR", help="a folder of results, or a history")
    parser.add_argument("--export", choices=["vtk"],
                        help="instead of a page, the runs that kept their shape as .pvd series for ParaView: muscle with depth and "
                             "attachment of each node, bones in their poses, in metres, times are frames; RESULTS_DIR may be one run's folder")
    parser.add_argument("--out", type=Path, metavar="PATH",
                        help=f"the page (default: {FILE_NAME} in the first folder), or the folder of the export (default: vtk in it)")
    return parser.parse_args(arguments)


def make(options) -> int:
    if options.export is None:
        write_page(options.results, options.out)
        return 0
    from musclebench.export.paraview import export_runs, runs_of  # VTK takes a second to load

    runs = [run for folder in options.results for run in runs_of(folder)]
    for path in export_runs(runs, options.out or options.results[0] / options.export):
        print(path)
    return 0


def main(arguments=None) -> int:
    return run_command("report", lambda: make(parse_arguments(arguments)), "the page is whole or not there", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
