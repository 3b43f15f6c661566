#!/usr/bin/python3
"""Measures what accuracy costs in time: every backend over its resolutions and choices, fed with the same positions
(replay) and driving the muscle (coupled; once more with fibres, for moment arms). Draws figures and price lists from what
it measured.

A study goes on where it was stopped: complete cases are skipped until their arguments, the program or the data change;
cases that failed, timed out or ran out of memory are tried again. Lengths are in mm, times in seconds.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

from musclebench.accuracy import report
from musclebench.cases.progress import duration
from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, add_structures_option, check_options, end, folders_of, require_results, study_parser,
)
from musclebench.experiments.command import add_memory_option, add_shard_option, chosen, print_plan
from musclebench.experiments.experiment_file import CaseGroup, ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.program.cli import add_scene_options, run_command
from musclebench.program.registry import read_registry
from musclebench.results.run_folder import ResultProblem

QUICK_MUSCLE, QUICK_REPLAY_SECONDS = "iliacus", 2.0
PRICE_LIST = "price_list.txt"


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("accuracy", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first picture in under 5 minutes: fewer configurations, frames and repetitions")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"of each case; long ones are repeated less (default {file.repetitions}; with --quick 1)")
    what.add_argument("--band-mm", type=float, metavar="MM",
                      help="errors are measured at nodes that are no farther from the surface (default 10 mm)")
    what.add_argument("--longest", type=float, metavar="SECONDS",
                      help="a case that is guessed to take longer is a row with its estimate (default 360 s)")
    what.add_argument("--frames-limit", type=int, metavar="N",
                      help="frames of the whole run (default: the preset's 314)")
    add_shard_option(what)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=file.timeout_s)
    add_jobs_option(how)
    add_structures_option(how)
    add_memory_option(how)
    how.add_argument("--keep-structures", action="store_true",
                     help="keep the distance fields (about 0.7 GB), which otherwise go at the end")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="draw what is there, run nothing")
    return parser.parse_args(arguments)


def asked(file: ExperimentFile, options) -> ExperimentFile:
    """The experiment as the options want it."""
    if options.band_mm:
        file = file.with_groups(band_mm=options.band_mm)
    if options.longest:
        file = file.with_groups(longest_s=options.longest)
    if options.quick:
        file = replace(file, repetitions=1, groups=tuple(_quick(group) for group in file.groups))
    return file


def _quick(group: CaseGroup) -> CaseGroup:
    configurations = "study_quick" if group.configurations == "study" else group.configurations
    return replace(group, configurations=configurations, replay_s=QUICK_REPLAY_SECONDS)


def write_report(out_dir: Path) -> list[Path]:
    files = report.write_report(out_dir)
    for path in files:
        if path.name == PRICE_LIST:
            print(f"\n{path.read_text().rstrip()}")
    return files


def measure_and_report(arguments) -> int:
    file = of_project("accuracy")
    options = parse_arguments(arguments, file)
    check_options(options, "accuracy")
    folders, started = folders_of(options, "accuracy"), time.monotonic()
    if options.report_only:
        require_results(folders.out_dir)
        return end("accuracy", write_report(folders.out_dir), [])
    registry = read_registry(options.musclebench)
    sweep = sweep_of(asked(file, options), options, registry, folders, QUICK_MUSCLE if options.quick else None)
    cases, limits = chosen(sweep, options.shard), limits_of(options)
    if options.dry_run:
        print_plan(cases, sweep, len(limits.cores))
        return 0
    problems = sweep.run(cases, limits, options.keep_structures)
    measured = time.monotonic()
    files = write_report(folders.out_dir)
    print(f"\nMeasured in {duration(measured - started)}, drawn in {duration(time.monotonic() - measured)}.")
    return end("accuracy", files, problems)


def main(arguments=None) -> int:
    return run_command("accuracy", lambda: measure_and_report(arguments),
                       "complete cases are kept, unfinished ones removed (--report-only draws them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
