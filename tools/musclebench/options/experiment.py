"""Runs an experiment: a file that lists scenes, backends, parameters, threads, repetitions and modes. Every combination is a case.

Each case is one process with limits of time and memory. After a crash, a time-out or a lack of memory, its row gives the reason.

  tools/experiment nightly --list-cases
  tools/experiment my_sweep.toml --shard 2/3

Tables in --out:
  answers.csv         outcomes, the same on every machine and for every split into shards
  times.csv           times
  frame_spread.csv    for each timed case: median of a frame, 95 % interval, tail and variation

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed. Times are in seconds, memory in GB.
"""

from pathlib import Path

from ..experiments.experiment_file import FOLDER, experiment_path, read_experiment
from ..program.cli import Problem, add_scene_options
from .shared import (
    Tool, add_frames_option, add_jobs_option, add_memory_option, add_run_options, add_shard_option, add_structures_option,
    check_options, study_parser,
)


def parse_arguments(arguments):
    parser = study_parser("experiment", __doc__)
    parser.add_argument("experiment", metavar="NAME_OR_FILE",
                        help=f"one of {', '.join(sorted(path.stem for path in FOLDER.glob('*.toml')))}, or a .toml file")
    what = parser.add_argument_group("what is run")
    add_scene_options(what, "default: the scenes of the experiment")
    what.add_argument("--repetitions", type=int, metavar="N", help="repetitions of each case (default: the experiment's)")
    add_frames_option(what)
    what.add_argument("--filter", action="append", metavar="WORDS",
                      help="run only cases whose names contain WORDS; * and ? are wildcards; may be repeated")
    add_shard_option(what)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=None)
    add_jobs_option(how)
    add_structures_option(how)
    add_memory_option(how)
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--list-cases", action="store_true", help="print only the names of the cases, one on each line")
    instead.add_argument("--dry-run", action="store_true", help="print the cases with their estimated times, and which are complete")
    instead.add_argument("--report-only", action="store_true", help="write the tables of the results that exist, run nothing")
    instead.add_argument("--merge", nargs="+", type=Path, metavar="DIR",
                         help="collect the results of these shards in --out and write the tables")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_options(options)
    read_experiment(experiment_path(options.experiment))
    for folder in options.merge or []:
        if not folder.is_dir():
            raise Problem(f"{folder}: no such folder; --merge takes the --out folders of the shards")


TOOL = Tool(parse_arguments, check)
