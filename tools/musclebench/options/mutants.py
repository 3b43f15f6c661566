"""Do the tests see? Puts the faults of tools/mutants.toml into a copy of the sources, one at a time, builds and runs
the test programs that the change reaches, nearest first (of a Python file the test modules that import it), and says which
faults none of them sees. At most 2 may survive, each with a reason in the list. Verdicts are kept: an interrupted campaign
goes on where it was.

  tools/mutants --check           does every fault still apply, once, and is every seen one listed? (no build)
  tools/mutants                   all faults, in C++ and in Python: some hours on two cores; once a week, not in CI
  tools/mutants --only 'xpbd-*'   some, by name
  tools/mutants --shard 1/4       the first of four parts, each with a scratch folder of its own

Exit code: 0 as it should be; 1 a survivor without a reason, more than 2 survivors, or a fault that does not apply or
compile; 2 something is wrong with the call; 130 interrupted.
"""

import argparse
from pathlib import Path

from ..cases.study_command import PROJECT
from ..mutants.faults import chosen, read_faults, read_seen
from ..program.cli import OneLineParser, Problem
from .shared import Needs, Tool, check_options, shard


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/mutants", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only see whether every fault applies, once, and every seen one is listed "
                        "(--seen, else the list's name with _seen.json)")
    parser.add_argument("--list", action="store_true", help="print the faults")
    parser.add_argument("--only", action="append", metavar="NAME",
                        help="faults of this name or pattern; may be repeated")
    parser.add_argument("--shard", type=shard, metavar="I/N", help="the I-th of N parts of the list")
    parser.add_argument("--programs", metavar="PATTERN", default="*",
                        help="ask only these test programs, such as 'core/*': quicker, but what they miss is no "
                        "survivor yet and is judged again without this option")
    parser.add_argument("--jobs", type=int, metavar="N", default=2, help="compilers at a time (default: %(default)s)")
    parser.add_argument("--seen", type=Path, metavar="FILE",
                        help="take the faults in this file as seen, and add those that are seen now: a campaign may "
                        "then be spread over machines, and over changes of the sources")
    parser.add_argument("--faults", type=Path, metavar="FILE", default=PROJECT / "tools" / "mutants.toml",
                        help="the list (default: tools/mutants.toml)")
    parser.add_argument("--scratch", type=Path, metavar="DIR", help="folder of the copy, the build and the verdicts "
                        "(default: build/mutants, with the shard's number)")
    return parser.parse_args(arguments)


def check(options) -> None:
    """The names among them: a campaign first builds for a quarter of an hour."""
    check_options(options)
    if options.scratch and options.scratch.exists() and not options.scratch.is_dir():
        raise Problem(f"--scratch {options.scratch}: is a file; name a folder")
    if options.seen and (options.seen.is_dir() or not options.seen.absolute().parent.is_dir()):
        raise Problem(f"--seen {options.seen}: no file can be there; name one in a folder that is there")
    if options.seen:
        read_seen(options.seen)
    chosen(read_faults(options.faults), options.only, options.shard)


def needs(options) -> Needs:
    """A campaign builds the sources by itself."""
    return Needs() if options.check or options.list else Needs(compiler=True)


TOOL = Tool(parse_arguments, check, needs)
