"""Measures the program, adds a night to the history, and reports what changed: when, by how much, how sure, with the
commits between.

The experiment nightly, all backends on a small scene and on a muscle of the synthetic hip, runs on one core, its repetitions
in random order; where the program is another one than in the last night, that one runs beside it. Reported are steps of times
(5 %) and counters (1 %) over the nights (E-divisive, at a level of 0.1 % for all series of a night), what differs from the
last night's program, and answers that are not the same: state hash, depth, missed contacts, cells of the matrix of hard
cases.

Exit code 0: nothing new, 1: something changed, 2: it could not be done.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..program.cli import OneLineParser, Problem
from .shared import Tool, add_case_options, built_program, check_interleaved


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/nightly", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "nightly",
                        help="nights, and what other tools read: otava/, bencher.json (default: reports/out/nightly)")
    parser.add_argument("--history", type=Path, metavar="FILE", help="SQLite (default: history.sqlite in --out)")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM", default=built_program("release"),
                        help="the program to measure (default: that of the preset release)")
    add_case_options(parser)
    parser.add_argument("--minutes", type=float, default=20.0, metavar="N",
                        help="for the night: after that no repetition beyond the fifth begins (default 20 min)")
    parser.add_argument("--hard-seconds", type=float, default=300.0, metavar="SECONDS",
                        help="of them for the matrix of hard cases, which is left out when it takes longer (default 300 s)")
    parser.add_argument("--no-hard", action="store_true", help="without that matrix")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--append", type=Path, metavar="NIGHT", help="add a night's folder that could not be added; run nothing")
    instead.add_argument("--report-only", action="store_true", help="report on the last night of the history; run nothing")
    instead.add_argument("--simulate", type=int, metavar="N",
                         help="of N histories drawn from recorded noise: how many alarm without a change, and after how many "
                              "nights a slowdown of 10 %% of one case's collision is found; and of N third nights how many find it "
                              "(seconds each)")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_interleaved(options)
    if options.append and not options.append.is_dir():
        raise Problem(f"{options.append}: no such folder of a night")


TOOL = Tool(parse_arguments, check)
