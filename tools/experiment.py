#!/usr/bin/python3
"""Runs an experiment: a file of scenes, backends, parameters, threads, repetitions and modes that are multiplied. Its name,
for one of bench/experiments, or the path of a file of your own.

One process a case, within limits of time and memory; a crash, a time-out or a lack of memory is a row with its reason. It goes
on where it was stopped: complete cases are skipped until their arguments, the program or the data change. Writes answers.csv,
which is the same on every machine and however the cases were split, times.csv, and frame_spread.csv: of each timed case median,
95 % interval, tail and variation of a frame. Times of options are in seconds, memory in GB.
"""

import sys
from pathlib import Path

from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, add_structures_option, check_options, end, folders_of, require_results, study_parser,
)
from musclebench.experiments.case_tables import write_tables
from musclebench.experiments.command import add_memory_option, add_shard_option, chosen, print_plan
from musclebench.experiments.experiment_file import FOLDER, experiment_path, read_experiment
from musclebench.experiments.merging import merge
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.program.cli import add_scene_options, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_text


def parse_arguments(arguments):
    parser = study_parser("experiment", __doc__)
    parser.add_argument("experiment", metavar="NAME_OR_FILE",
                        help=f"one of {', '.join(sorted(path.stem for path in FOLDER.glob('*.toml')))}, or a .toml file")
    what = parser.add_argument_group("what is run")
    add_scene_options(what, "default: those of the experiment")
    what.add_argument("--repetitions", type=int, metavar="N", help="of each case (default: the experiment's)")
    what.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole run, for a quick look")
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


def report(out_dir: Path, problems: list[str]) -> int:
    answers, spread, files = write_tables(out_dir)
    if len(spread.rows):
        print(f"\n{spread.caption}\n\n{as_text(spread)}")
    counts = ", ".join(f"{count} {status}" for status, count in answers["status"].value_counts().items())
    print(f"\n{len(answers)} cases: {counts}")
    return end("experiment", files, problems)


def run_and_report(options) -> int:
    check_options(options, "build release")
    file = read_experiment(experiment_path(options.experiment))
    folders = folders_of(options, file.name)
    if options.report_only:
        require_results(folders.out_dir)
        return report(folders.out_dir, [])
    if options.merge:
        return report(folders.out_dir, merge(options.merge, folders.out_dir))
    options.jobs, options.timeout = options.jobs or file.jobs, options.timeout or file.timeout_s
    sweep = sweep_of(file, options, read_registry(options.musclebench), folders)
    cases = chosen(sweep, options.shard, options.filter)
    if options.list_cases:
        print(*(case.name for case in cases), sep="\n")
        return 0
    limits = limits_of(options)
    if options.dry_run:
        print_plan(cases, sweep, len(limits.cores))
        return 0
    return report(folders.out_dir, sweep.run(cases, limits))


def main(arguments=None) -> int:
    return run_command("experiment", lambda: run_and_report(parse_arguments(arguments)),
                       "complete cases are kept, unfinished ones removed (--report-only shows them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
