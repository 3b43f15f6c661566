"""Tests the tests: puts one fault after another into a copy of the sources, and reports faults that no test sees.

tools/mutants.toml lists the faults. For each fault the tool builds and runs the test programs that the fault can reach, nearest
first. For a Python file it runs the test modules that import the file. At most 2 faults may survive, each with a reason in the
list. You can stop a campaign and start it again: the verdicts are kept in the folder of --scratch.

  tools/mutants --check           only check the list: every fault applies exactly once (no build)
  tools/mutants                   all faults: some hours on two cores
  tools/mutants --only 'xpbd-*'   some faults, by name
  tools/mutants --shard 1/4       the first of four parts, each with its own scratch folder

Exit codes: 0 all well, 1 too many survivors, or a fault that does not apply or compile, 2 bad call, 130 interrupted.
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
    parser.add_argument("--check", action="store_true",
                        help="only check that every fault applies exactly once, and that every fault in the file of --seen is "
                             "listed (default file: the list's name with _seen.json)")
    parser.add_argument("--list", action="store_true", help="print the faults")
    parser.add_argument("--only", action="append", metavar="NAME",
                        help="run only faults of this name or pattern; may be repeated (default: all)")
    parser.add_argument("--shard", type=shard, metavar="I/N", help="run only the I-th of N parts of the list (default: all)")
    parser.add_argument("--programs", metavar="PATTERN", default="*",
                        help="run only these test programs, such as 'core/*' (default: all). A fault that they miss is no survivor "
                             "yet; a run without this option judges it again")
    parser.add_argument("--jobs", type=int, metavar="N", default=2,
                        help="compilers that run at the same time (default: %(default)s)")
    parser.add_argument("--seen", type=Path, metavar="FILE",
                        help="skip the faults in this file, which tests have seen before, and add the faults that tests see now. "
                             "So you can spread a campaign over machines and changes of the sources")
    parser.add_argument("--faults", type=Path, metavar="FILE", default=PROJECT / "tools" / "mutants.toml",
                        help="list of faults (default: tools/mutants.toml)")
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
