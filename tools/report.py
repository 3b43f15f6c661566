#!/usr/bin/python3
"""Writes the page of results, or exports runs for ParaView. Options: musclebench/options/report.py."""

import sys

from musclebench.options.report import parse_arguments
from musclebench.page.page_file import write_page
from musclebench.program.cli import run_command
from musclebench.results.run_folder import ResultProblem


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
