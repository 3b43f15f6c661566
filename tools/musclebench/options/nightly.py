"""Measures the program, adds the night to a history, and reports what changed: when, by how much, how sure, in which commits.

The experiment `nightly` runs all backends on a small scene and on a muscle of the synthetic hip. It uses one core and a random
order of repetitions. If the program changed since last night, last night's program runs interleaved with it.

The report is printed, and written to report.md in --out. It shows:
  - steps over the nights: times from 5 %, counters from 1 % (E-divisive, at a level of 0.1 % for all series of a night);
  - differences from last night's program;
  - changed answers: state hash, depth, missed contacts, and cells of the matrix of hard cases.

  tools/nightly --minutes 10
  tools/nightly --report-only

Exit codes: 0 nothing new, 1 something changed, 2 the night failed.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..program.cli import OneLineParser, Problem
from .shared import Tool, add_case_options, built_program, check_interleaved


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/nightly", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "nightly",
                        help="folder of the nights, and of otava/ and bencher.json for other tools (default: reports/out/nightly)")
    parser.add_argument("--history", type=Path, metavar="FILE", help="SQLite file of the history (default: history.sqlite in --out)")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM", default=built_program("release"),
                        help="program to measure (default: the build of preset release)")
    add_case_options(parser)
    parser.add_argument("--minutes", type=float, default=20.0, metavar="N",
                        help="time of the night, min: afterwards no repetition beyond the fifth begins (default: 20)")
    parser.add_argument("--hard-seconds", type=float, default=300.0, metavar="SECONDS",
                        help="share of the night for the matrix of hard cases, s; a longer matrix is left out (default: 300)")
    parser.add_argument("--no-hard", action="store_true", help="leave out the matrix of hard cases")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--append", type=Path, metavar="NIGHT", help="add the folder of a night that could not be added; run nothing")
    instead.add_argument("--report-only", action="store_true", help="report on the last night of the history; run nothing")
    instead.add_argument("--simulate", type=int, metavar="N",
                         help="draw N histories from recorded noise, a few seconds each. Count false alarms. Count the nights until a "
                              "slowdown of 10 %% in one case's collision is found, and how often the third night finds it")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_interleaved(options)
    if options.append and not options.append.is_dir():
        raise Problem(f"{options.append}: no such folder of a night; name a folder of nights/")


TOOL = Tool(parse_arguments, check)
