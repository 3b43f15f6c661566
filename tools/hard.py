#!/usr/bin/python3
"""Which backend stays numerically stable in which hard case.

Runs `musclebench hard` (its --list tells what happens in each case, why it is hard and what its bar is), writes the matrix
as CSV, Markdown and a picture, and draws a strip of each scene that the cases move: at its start, in its worst frame, at its
end.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import pandas as pd

from musclebench.cases.study_command import PROJECT, end
from musclebench.figures.hard_cases import draw_matrix, draw_strips
from musclebench.hard.cells import cases_of, cells_of
from musclebench.hard.strips import run_scene
from musclebench.program.cli import OneLineParser, Problem, check_program, run_command
from musclebench.program.out_folder import claimed
from musclebench.program.registry import read_registry, save_registry
from musclebench.results.run_folder import ResultProblem

HELD, BROKEN = 0, 1


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/hard", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="with the long sweeps: many minutes")
    parser.add_argument("--backend", action="append", metavar="NAME", help="only this one; may be repeated")
    parser.add_argument("--case", action="append", metavar="ID", help="only this one; may be repeated")
    parser.add_argument("--no-pictures", action="store_true", help="only the matrix")
    parser.add_argument("--breaks-are-results", action="store_true",
                        help="exit code 0 where cells break, too: the matrix is to be published as it is")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "hard",
                        help="default: reports/out/hard")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM",
                        default=PROJECT / "build" / "release" / "bench" / "musclebench",
                        help="the program to try (default: that of the preset release)")
    return parser.parse_args(arguments)


def run_matrix(options) -> int:
    """The exit code of the program, whose progress and matrix the user sees."""
    command = [str(options.musclebench), "hard", "--out", str(options.out), *(["--all"] if options.all else [])]
    for option, values in (("--backend", options.backend), ("--case", options.case)):
        command += [word for value in values or [] for word in (option, value)]
    code = subprocess.run(command, check=False).returncode
    if code not in (HELD, BROKEN):
        raise Problem(f"{options.musclebench}: 'hard' ended with exit code {code}")
    return code


def write_tables(rows: pd.DataFrame, options) -> list[Path]:
    """What tools/publish takes over: a row a cell, a row a case."""
    words = [word for case in options.case or [] for word in ("--case", case)]
    listed = subprocess.run([str(options.musclebench), "hard", "--list", *words], capture_output=True, text=True, check=False)
    files = []
    for name, table in (("cells", cells_of(rows)), ("cases", cases_of(listed.stdout))):
        files.append(options.out / "tables" / f"{name}.csv")
        table.to_csv(files[-1], index=False)
    return files


def run_and_report(options) -> int:
    check_program(options.musclebench, "tools/hard")
    registry = read_registry(options.musclebench)
    with claimed(options.out.absolute(), "raw", "figures", "tables"):
        save_registry(registry, options.out)
        code = run_matrix(options)
        rows = pd.read_csv(options.out / "matrix.csv", keep_default_na=False)
        figures = options.out / "figures"
        files = [options.out / "matrix.csv", options.out / "matrix.md", *write_tables(rows, options),
                 *draw_matrix(rows, figures / "matrix")]
        problems = []
        if not options.no_pictures:
            runs = []
            for scene in dict.fromkeys(name for name in rows["scene"] if name):
                try:
                    runs.append(run_scene(options.musclebench, scene, registry, options.out / "raw" / Path(scene).name))
                except Problem as problem:
                    problems.append(str(problem))
            files += draw_strips(runs, figures / "scenes")
    return max(HELD if options.breaks_are_results else code, end("hard", files, problems))


def main(arguments=None) -> int:
    return run_command("hard", lambda: run_and_report(parse_arguments(arguments)), "the matrix is whole or not there",
                       ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
