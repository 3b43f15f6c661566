"""Reports what changed from BEFORE to AFTER. Both are folders of results, git revisions or programs.

The tool builds revisions in scratch folders. It runs both with their repetitions interleaved on one core.

  tools/compare main my-branch
  tools/compare reports/out/old reports/out/new

A time counts as changed from 5 %, a counter from 1 %. The 95 % interval of the ratio and a significance test must agree. The test
is Mann and Whitney's U, or Yuen's test of pairs, at a level of 1 % over all cases that vary. State hash, 99th percentile of the
depth, missed contacts and verdicts must be the same.

The tool prints Markdown, and writes the same text to compare.md in --out.
Exit codes: 0 no change, 1 something changed, 2 the two cannot be compared.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..comparison.revisions import commit_of
from ..program.cli import OneLineParser, Problem
from .shared import Needs, Tool, add_case_options, check_interleaved

WITHOUT_TIMES = "--accuracy-only"


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/compare", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", metavar="BEFORE", help="a folder of results, a git revision, or a program")
    parser.add_argument("after", metavar="AFTER", help="a folder, revision or program to compare with BEFORE")
    parser.add_argument(WITHOUT_TIMES, action="store_true", help="compare no times; builds then need not be Release")
    parser.add_argument("--force", action="store_true", help="compare results even if the hardware differs")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "compare",
                        help="folder for compare.md, and for builds and runs of revisions (default: reports/out/compare)")
    add_case_options(parser.add_argument_group("for revisions and programs"))
    return parser.parse_args(arguments)


def check(options) -> None:
    check_interleaved(options)
    are_folders = [Path(name).is_dir() for name in (options.before, options.after)]
    if any(are_folders) and not all(are_folders):
        raise Problem(f"{options.before} and {options.after}: one is a folder of results, the other is not; name two folders or two revisions")
    for name in (options.before, options.after):
        if not Path(name).exists() and commit_of(name, PROJECT) is None:
            raise Problem(f"{name}: neither a folder of results nor a revision of {PROJECT} nor a program; check the name")


def needs(options) -> Needs:
    """Revisions are built."""
    return Needs(compiler=not all(Path(name).exists() for name in (options.before, options.after)))


TOOL = Tool(parse_arguments, check, needs)
