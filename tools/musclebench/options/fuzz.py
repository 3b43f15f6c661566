"""Feeds damaged files to every reader of files with libFuzzer: meshes, scenes, motions, landmarks, recordings, structures.

Sanitizers watch addresses and undefined behaviour. Fuzzing starts from the corpus in the sources and from files of earlier runs.
A reader must read or refuse each file within 10 s and 2 GB. The tool prints a line for each reader.

  tools/fuzz --list
  tools/fuzz ply --seconds 60

Results go to OUT/READER: the grown corpus (the smallest files with the same coverage), a file for each finding, and the log.
Shrink each finding and add it to the corpus of the sources. A test of every build replays that corpus.
Exit codes: 0 nothing found, 1 a finding, 2 bad call.
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
    parser.add_argument("reader", nargs="*", metavar="READER", help="readers to feed (default: all; --list prints their names)")
    parser.add_argument("--seconds", type=float, default=600, metavar="N", help="time for each reader, s (default: 600)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="readers that run at the same time (default: 1)")
    parser.add_argument("--list", action="store_true", help="print the names of the readers")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "fuzz",
                        help="folder of results (default: reports/out/fuzz)")
    parser.add_argument("--build", type=Path, metavar="DIR", default=BUILD,
                        help="build folder with the fuzz programs (default: the build of preset fuzz)")
    return parser.parse_args(arguments)


def needs(options) -> Needs:
    """Of another build nothing is made anew."""
    return Needs(PRESET, packages=("clang",)) if options.build == BUILD else Needs()


TOOL = Tool(parse_arguments, needs=needs)
