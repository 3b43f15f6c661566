"""Packs a study of accuracy for the board, or checks a bundle that somebody sent.

RESULTS is the --out folder of tools/accuracy, or a published study (reports/measured/accuracy-synthetic). The bundle is one zip.
It has times with intervals, errors, and hashes of all answers to the last bit. It names the machine and its state, the build, and the
commit or release and the licence of each backend. Shapes of runs are in it where the study kept them: they carry the licence of their
scene. The same results make the same bytes.

  tools/accuracy --quick --out mine
  tools/bundle mine --source mine=https://example.org/mine@1a2b3c4 --licence mine=MIT
  tools/bundle --check mine.zip

Exit codes: 0 the bundle is written, or right; 2 nothing was written, and one line says what is wrong.
"""

import argparse
from pathlib import Path

from ..program.cli import OneLineParser, Problem
from .shared import Needs, Tool


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = OneLineParser(prog="tools/bundle", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path, nargs="?", metavar="RESULTS", help="folder of a study of accuracy; with --check a bundle")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--check", action="store_true", help="read a bundle and say what it holds; write nothing")
    instead.add_argument("--columns", action="store_true", help="say what the columns of a bundle mean")
    parser.add_argument("--out", type=Path, metavar="FILE", help="the bundle (default: RESULTS.zip, next to the folder)")
    parser.add_argument("--no-shapes", action="store_true", help="leave out the shapes of runs, and with them the bones and muscles of the scene")
    parser.add_argument("--licence", action="append", default=[], metavar="NAME=LICENCE", type=_named,
                        help="of a backend or a scene that does not tell its own; may be repeated")
    parser.add_argument("--source", action="append", default=[], metavar="NAME=URL@COMMIT", type=_named,
                        help="where a backend's code is, and which of its commits was measured; may be repeated")
    return parser.parse_args(arguments)


def _named(text: str) -> tuple[str, str]:
    name, _, value = text.partition("=")
    if not name.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"'{text}' is not like NAME=VALUE")
    return name.strip(), value.strip()


def check(options: argparse.Namespace) -> None:
    if options.results is None:
        if not options.columns:
            raise Problem("name a folder of results, or a bundle with --check; --help shows the options")
        return
    if (options.check or options.columns) and (options.out or options.licence or options.source or options.no_shapes):
        raise Problem("--check and --columns write nothing: leave out --out, --licence, --source and --no-shapes")
    if not options.results.exists():
        raise Problem(f"{options.results}: no such {'bundle' if options.check else 'folder; name the --out of tools/accuracy'}")
    if not options.check and not options.results.is_dir():
        raise Problem(f"{options.results}: is a file; name a folder of results, or add --check to read a bundle")
    if options.out is not None and options.out.suffix != ".zip":
        raise Problem(f"--out {options.out}: has to end in .zip")


TOOL = Tool(parse_arguments, check, lambda options: Needs())
