"""libFuzzer on every reader of files: meshes, scenes, motions, landmarks, recordings, structures of backends.

Feeds each reader with changed files, starting from the corpus in the sources and from what earlier runs have kept, under the
sanitizers of addresses and of undefined behaviour. A reader has to read or to refuse what it gets, in 10 s and 2 GB. Keeps in
OUT/READER the corpus as it grew (the smallest files that reach as much), a file for each finding, and libFuzzer's log.
Prints a line a reader. Exit code: 0 nothing was found; 1 there is a finding; 2 something is wrong with the call.

What is found belongs, as small as it can be, into the corpus of the sources: a test of every build replays that.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..program.cli import OneLineParser
from .shared import Needs, Tool

PRESET = "fuzz"
BUILD = PROJECT / "build" / PRESET


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reader", nargs="*", metavar="READER", help="only these (default: all; --list names them)")
    parser.add_argument("--seconds", type=float, default=600, metavar="N", help="of each reader (default: 600)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="readers at a time (default: 1)")
    parser.add_argument("--list", action="store_true", help="names the readers")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "fuzz",
                        help="default: reports/out/fuzz")
    parser.add_argument("--build", type=Path, metavar="DIR", default=BUILD,
                        help="build with the programs (default: that of the preset fuzz)")
    return parser.parse_args(arguments)


def needs(options) -> Needs:
    """Of another build nothing is made anew."""
    return Needs(PRESET, packages=("clang",)) if options.build == BUILD else Needs()


TOOL = Tool(parse_arguments, needs=needs)
