#!/usr/bin/python3
"""Packs a study for the board. Options: musclebench/options/bundle.py."""

import sys

from musclebench.board.bundle import Bundle
from musclebench.board.columns import COLUMNS
from musclebench.board.packing import pack
from musclebench.board.reading import read_bundle
from musclebench.options.bundle import check, parse_arguments
from musclebench.program.cli import run_command
from musclebench.results.run_folder import ResultProblem


def told(bundle: Bundle) -> str:
    rows, hashed = bundle.rows, (bundle.rows["contact_hash"] != "").sum()
    shapes = f"; shapes of {', '.join(bundle.shapes)}" if bundle.shapes else ""
    return (f"{len(rows)} settings of {rows['backend'].nunique()} backends on {', '.join(bundle.header['scenes'])}; {hashed} with a hash of their "
            f"answers{shapes}; {bundle.machine}; measured {bundle.header['measured']}, commit {bundle.header['commit']}")


def make(options) -> int:
    check(options)
    if options.columns:
        for column in COLUMNS:
            print(f"{column.name:24} {column.kind:7} {column.help}")
    elif options.check:
        print(f"{options.results}: {told(read_bundle(options.results))}")
    else:
        out, bundle = pack(options.results, options.out, dict(options.licence), dict(options.source), not options.no_shapes)
        print(f"{out}: {out.stat().st_size / 1e3:.0f} kB; {told(bundle)}")
    return 0


def main(arguments=None) -> int:
    return run_command("bundle", lambda: make(parse_arguments(arguments)), "nothing was written", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
