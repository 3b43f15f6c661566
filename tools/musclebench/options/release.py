"""Makes a version: writes its number into every file that has it, names the unreleased part of CHANGELOG.md, commits, and tags
the commit with the release notes.

  tools/release 0.2.0 --dry-run   what it would change, and the notes
  tools/release 0.2.0

Run .ci/run first. The tool pushes nothing; its last line is the command that does. The number follows semver.org: the second
part grows where a scene, a command or a column of results changes its meaning, the third where only defects were mended.

Exit codes: 0 done, 2 refused.
"""

import argparse
import re

from ..program.cli import OneLineParser, Problem
from .shared import Needs, Tool


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/release", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version", metavar="VERSION", help="number of the version: three whole numbers with dots, above the last one")
    parser.add_argument("--dry-run", action="store_true", help="change nothing; print the changes and the release notes")
    return parser.parse_args(arguments)


def check(options) -> None:
    if not re.fullmatch(r"(0|[1-9]\d*)(\.(0|[1-9]\d*)){2}", options.version):
        raise Problem(f"VERSION {options.version}: is not three whole numbers with dots, such as 0.2.0")


TOOL = Tool(parse_arguments, check, lambda _: Needs())
