"""Makes random scenes, runs each, and counts what passes through what in every frame.

Muscles are flung at up to 100 m/s, swept along by bones that turn by up to 30 degrees a frame, or shut in a room. Nothing
intersects at the start. The count shares no code with the program: it looks at the shapes that a run keeps. A body that
passes wholly between two frames is seen only if it leaves a room.

  tools/stress
  tools/stress --scenes 1000 --seed 7
  tools/stress --seed 7 --only 413       one scene again; its folder stays
  tools/stress --effect tunnelling_guard

A finding is a triangle that passes, a muscle that leaves its room, or a run that diverges, crashes, is refused or takes longer
than 300 s. A muscle that a fast bone flings out of the scene is none. Nor is what comes between two bones that come together:
there the program says that it cannot hold what it promises, and nothing counts from then on. The folder of a finding stays in
--out, with its scene file and its run. scenes.csv has a row a scene. You can stop the tool; what was tried stays there.
Exit codes: 0 nothing found, 1 a finding, 2 bad call.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..program.cli import OneLineParser
from .shared import Needs, Tool, built_program, needs_of

GUARANTEE = "no_passage"


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = OneLineParser(prog="tools/stress", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100, metavar="N", help="how many (default: 100)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="other scenes for another one (default: 1)")
    parser.add_argument("--only", type=int, metavar="N", help="only the scene of this number, from 1 on; its folder stays (default: all)")
    effect = parser.add_mutually_exclusive_group()
    effect.add_argument("--effect", action="append", metavar="NAME",
                        help=f"effect that every scene has; may be repeated (default: {GUARANTEE})")
    effect.add_argument("--no-effect", action="store_true", help="only the effects that scenes choose at random")
    parser.add_argument("--backend", metavar="NAME", help="collision backend (default: an exact one)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="scenes that run at the same time (default: 2)")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "stress",
                        help="folder of results (default: reports/out/stress)")
    parser.add_argument("--musclebench", type=Path, metavar="PROGRAM", default=built_program("release"),
                        help="program to try (default: the build of preset release)")
    return parser.parse_args(arguments)


def needs(options: argparse.Namespace) -> Needs:
    return needs_of(options)


TOOL = Tool(parse_arguments, needs=needs)
