"""Runs an experiment: a file of scenes, backends, parameters, threads, repetitions and modes that are multiplied. Its name,
for one of bench/experiments, or the path of a file of your own.

One process a case, within limits of time and memory; a crash, a time-out or a lack of memory is a row with its reason. It goes
on where it was stopped: complete cases are skipped until their arguments, the program or the data change. Writes answers.csv,
which is the same on every machine and however the cases were split, times.csv, and frame_spread.csv: of each timed case median,
95 % interval, tail and variation of a frame. Times of options are in seconds, memory in GB.
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
    add_scene_options(what, "default: those of the experiment")
    what.add_argument("--repetitions", type=int, metavar="N", help="of each case (default: the experiment's)")
    add_frames_option(what)
    what.add_argument("--filter", action="append", metavar="WORDS",
                      help="only cases with this in their names; * and ? stand for what they do in file names; may be repeated")
    add_shard_option(what)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=None)
    add_jobs_option(how)
    add_structures_option(how)
    add_memory_option(how)
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--list-cases", action="store_true", help="print the names of the cases, one a line, and no more")
    instead.add_argument("--dry-run", action="store_true", help="print the cases with their guessed times and what is complete")
    instead.add_argument("--report-only", action="store_true", help="make the tables of what is there, run nothing")
    instead.add_argument("--merge", nargs="+", type=Path, metavar="DIR",
                         help="put the results of these parts into --out and make the tables")
    return parser.parse_args(arguments)


def check(options) -> None:
    check_options(options)
    read_experiment(experiment_path(options.experiment))
    for folder in options.merge or []:
        if not folder.is_dir():
            raise Problem(f"{folder}: no such folder; --merge takes the parts' --out")


TOOL = Tool(parse_arguments, check)
