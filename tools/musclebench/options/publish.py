"""Runs all studies on one commit and one machine, and writes every measured table, picture and number of README and reports.

The studies are the paper's experiment, accuracy, speed, hard cases, the error budget, moment arms, and effects. When a study is
complete, its results go to reports/measured with commit, machine and date. Then the tool writes the pages again.

  tools/publish --quick            a rehearsal
  tools/publish --only speed
  tools/publish --write-only       after a change of the pages' code

You can stop the tool and start it again. Each study skips its complete cases.
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
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder: also measure lhdl/* scenes")
    parser.add_argument("--quick", action="store_true",
                        help="rehearse with few frames and cases; pages go to --out, not into the project")
    parser.add_argument("--only", action="append", choices=sorted(TABLES), metavar="STUDY",
                        help=f"run only this study, one of {', '.join(sorted(TABLES))}; may be repeated (default: all)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of results (default: reports/out/publish; with --quick publish-quick)")
    parser.add_argument("--musclebench", type=Path, default=built_program("bench"), metavar="PROGRAM",
                        help="program to measure (default: the build of preset bench)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", action="store_true", help="print the commands and the files that they would write")
    instead.add_argument("--write-only", action="store_true", help="write the pages from reports/measured, run nothing")
    return parser.parse_args(arguments)


def check_tree() -> None:
    """What is published has to be of a commit that others can get."""
    done = subprocess.run(["git", "-C", str(PROJECT), "status", "--porcelain", "--", ".", ":!reports", ":!README.md"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0 or done.stdout.strip():
        raise Problem("the working tree has changes that are not committed; commit them first, or rehearse with --quick")


def check(options) -> None:
    check_options(options)
    if not (options.quick or options.dry_run or options.write_only):
        check_tree()


def needs(options) -> Needs:
    """Its plan names commands, not cases."""
    return Needs() if options.dry_run else needs_of(options)


TOOL = Tool(parse_arguments, check, needs)
