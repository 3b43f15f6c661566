"""Runs the paper's experiment, the accuracy study, the speed targets, the hard cases, the convergence of the substeps and
the study of effects on one commit and one machine, and writes every table, picture and quoted number of README and reports
from what they measured.

It goes on where it was stopped: complete cases are skipped by each study. A study that is complete is taken over into
reports/measured at once, with commit, machine and date; then the pages are written anew.
"""

import argparse
import subprocess
from pathlib import Path

from ..cases.study_command import PROJECT
from ..program.cli import OneLineParser, Problem
from ..publish.published_tables import TABLES
from .shared import Needs, Tool, built_program, check_options, needs_of


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/publish", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder: measure lhdl/* scenes, too")
    parser.add_argument("--quick", action="store_true",
                        help="a rehearsal: few frames and cases; pages go to the folder of the results, not into the "
                             "project")
    parser.add_argument("--only", action="append", choices=sorted(TABLES), metavar="STUDY",
                        help=f"one of {', '.join(sorted(TABLES))}; may be repeated (default: all)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: reports/out/publish[-quick]")
    parser.add_argument("--musclebench", type=Path, default=built_program("bench"), metavar="PROGRAM",
                        help="the program to measure (default: that of the preset bench)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", action="store_true", help="print the commands and what they would write")
    instead.add_argument("--write-only", action="store_true", help="write the pages from reports/measured, run nothing")
    return parser.parse_args(arguments)


def check_tree() -> None:
    """What is published has to be of a commit that others can get."""
    done = subprocess.run(["git", "-C", str(PROJECT), "status", "--porcelain", "--", ".", ":!reports", ":!README.md"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0 or done.stdout.strip():
        raise Problem("the working tree has changes that no commit holds; commit them first, or rehearse with --quick")


def check(options) -> None:
    check_options(options)
    if not (options.quick or options.dry_run or options.write_only):
        check_tree()


def needs(options) -> Needs:
    """Its plan names commands, not cases."""
    return Needs() if options.dry_run else needs_of(options)


TOOL = Tool(parse_arguments, check, needs)
