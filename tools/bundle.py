#!/usr/bin/python3
"""Packs a study for the board. Options: musclebench/options/bundle.py."""

import sys
import tempfile
from pathlib import Path

from musclebench.board.bundle import Bundle, write_bundle
from musclebench.board.made import bundle_of
from musclebench.board.reading import read_bundle
from musclebench.options.bundle import check, parse_arguments
from musclebench.program.cli import run_command
from musclebench.results.run_folder import ResultProblem


def told(bundle: Bundle) -> str:
    rows, hashed = bundle.rows, (bundle.rows["contact_hash"] != "").sum()
    return (f"{len(rows)} settings of {rows['backend'].nunique()} backends on {', '.join(bundle.header['scenes'])}; {hashed} with a hash of their "
            f"answers; {bundle.machine}; measured {bundle.header['measured']}, commit {bundle.header['commit']}")


def make(options) -> int:
    check(options)
    if options.check:
        print(f"{options.results}: {told(read_bundle(options.results))}")
        return 0
    out = options.out or options.results.resolve().with_suffix(".zip")
    made = bundle_of(options.results, dict(options.licence), dict(options.source))
    with tempfile.TemporaryDirectory() as folder:
        write_bundle(made, Path(folder) / out.name)
        bundle = read_bundle(Path(folder) / out.name)  # as whoever gets it will
    write_bundle(made, out)
    print(f"{out}: {out.stat().st_size / 1e3:.0f} kB; {told(bundle)}")
    return 0


def main(arguments=None) -> int:
    return run_command("bundle", lambda: make(parse_arguments(arguments)), "nothing was written", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
