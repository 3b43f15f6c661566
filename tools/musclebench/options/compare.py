"""What changed from BEFORE to AFTER: two folders of results, or two git revisions, which are then built in scratch folders
and run with their repetitions interleaved on one core.

Of each case times (5 % count) and counters (1 %) are compared by their ratio with its 95 % interval and by Mann and
Whitney's U or Yuen's test of the pairs, at a level of 1 % for all together that vary; state hash, 99th percentile of the depth,
missed contacts and verdicts have to be the same. Prints Markdown. Exit code 0: no change, 1: something changed, 2: it can't be compared.
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
    parser.add_argument("after", metavar="AFTER", help="the same")
    parser.add_argument(WITHOUT_TIMES, action="store_true", help="compare no times: then builds need not be Release")
    parser.add_argument("--force", action="store_true", help="compare results of different hardware all the same")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "compare",
                        help="compare.md, and of revisions their builds and runs (default: reports/out/compare)")
    add_case_options(parser.add_argument_group("of revisions and programs"))
    return parser.parse_args(arguments)


def check(options) -> None:
    check_interleaved(options)
    are_folders = [Path(name).is_dir() for name in (options.before, options.after)]
    if any(are_folders) and not all(are_folders):
        raise Problem(f"{options.before} and {options.after}: one is a folder of results, the other is not; name two of a kind")
    for name in (options.before, options.after):
        if not Path(name).exists() and commit_of(name, PROJECT) is None:
            raise Problem(f"{name}: neither a folder of results nor a revision of {PROJECT} nor a program")


def needs(options) -> Needs:
    """Revisions are built."""
    return Needs(compiler=not all(Path(name).exists() for name in (options.before, options.after)))


TOOL = Tool(parse_arguments, check, needs)
