#!/usr/bin/python3
"""Measures what accuracy costs in time: every backend over its resolutions and choices, fed with the same positions
(replay) and driving the muscle (coupled; once more with fibres, for moment arms). Draws figures and price lists from what
it measured.

A study goes on where it was stopped: complete cases are skipped until their arguments, the program or the data change;
cases that failed, timed out or ran out of memory are tried again. Lengths are in mm, times in seconds.
"""

import argparse
import shlex
import sys
import time
from dataclasses import replace
from pathlib import Path

from musclebench.accuracy import report
from musclebench.cases.case import Folders
from musclebench.cases.scene import chosen_names, survey
from musclebench.cases.pool import Limits, run_cases
from musclebench.cases.progress import duration
from musclebench.cases.study_command import (
    add_jobs_option, add_run_options, check_options, end, folders_of, missing, problem_of, require_results, study_parser,
)
from musclebench.program.cli import Problem, add_scene_options, chosen_cores, data_set_of, run_command
from musclebench.program.disk import free_bytes
from musclebench.program.out_folder import claimed
from musclebench.program.registry import Registry, read_registry, save_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.study.study import RESULT_DIRS, AccuracyStudy
from musclebench.study.study_cases import ARMS_PRESET, LONGEST_SECONDS, ReplayCase
from musclebench.study.study_manifest import total_memory_bytes, write_manifest
from musclebench.study.study_plan import Request, StudyCase, is_too_long, plan
from musclebench.study.sweeps import configurations

QUICK_MUSCLE = "iliacus"
REPETITIONS = 3
PRICE_LIST = "price_list.txt"
SPARE_BYTES = 100e6
MEMORY_SHARE = 0.9


def parse_arguments(arguments):
    parser = study_parser("accuracy", __doc__)
    what = parser.add_argument_group("what is measured")
    what.add_argument("--quick", action="store_true",
                      help="a first picture in under 5 minutes: fewer configurations, frames and repetitions")
    add_scene_options(what, f"default: all of the data set that have one muscle; with --quick {QUICK_MUSCLE}")
    what.add_argument("--repetitions", type=int, metavar="N",
                      help=f"of each case; long ones are repeated less (default {REPETITIONS}; with --quick 1)")
    what.add_argument("--band-mm", type=float, default=10.0, metavar="MM",
                      help="errors are measured at nodes that are no farther from the surface (default 10 mm)")
    what.add_argument("--longest", type=float, default=LONGEST_SECONDS, metavar="SECONDS",
                      help="a case that is guessed to take longer is a row with its estimate (default 360 s)")
    what.add_argument("--frames-limit", type=int, metavar="N",
                      help="frames of the whole run (default: the preset's 314)")
    what.add_argument("--shard", type=_shard, default=(1, 1), metavar="I/N",
                      help="run only the I-th of N parts, on machines of one kind with one build; copy the folders "
                           "together, then --report-only (default 1/1)")
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=1200.0)
    add_jobs_option(how)
    how.add_argument("--memory-gb", type=float, metavar="GB",
                     help="of one case (default: its share of 90 %% of the machine's memory)")
    how.add_argument("--keep-structures", action="store_true",
                     help="keep the distance fields (about 0.7 GB), which otherwise go at the end")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", "--plan", action="store_true", help="print the cases with their guessed times")
    instead.add_argument("--report-only", action="store_true", help="draw what is there, run nothing")
    return parser.parse_args(arguments)


def _shard(text: str) -> tuple[int, int]:
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 2/3, the second of three parts")
    return int(number), int(count)


def request_of(options, registry: Registry, folders: Folders) -> Request:
    data_set = data_set_of(options)
    names = chosen_names(options.scene, options.muscle, data_set, registry, QUICK_MUSCLE if options.quick else None)
    scenes = survey(names, options.musclebench, registry, folders, options.frames_limit)
    arm_scenes = survey(names, options.musclebench, registry, folders, options.frames_limit, ARMS_PRESET, of_files=False)
    repetitions = options.repetitions or (1 if options.quick else REPETITIONS)
    return Request(tuple(scenes), data_set, repetitions, options.quick, options.frames_limit, options.band_mm,
                   options.shard, longest_seconds=options.longest, arm_scenes=tuple(arm_scenes))


def limits_of(options) -> Limits:
    cores = chosen_cores(options.jobs)
    share = MEMORY_SHARE * total_memory_bytes() / len(cores)
    return Limits(cores, options.timeout, int(options.memory_gb * 1e9 if options.memory_gb else share))


def print_plan(cases: list[StudyCase], study: AccuracyStudy, jobs: int) -> None:
    print("  seconds  stride  case")
    left = 0.0
    for case in cases:
        note = "not run, too long" if is_too_long(case) else "" if study.wants(case) else "complete"
        left += 0.0 if note else case.guessed_seconds
        stride = case.stride if isinstance(case, ReplayCase) else ""
        print(f"{case.guessed_seconds:9.1f}  {stride:>6}  {case.name}{f'  ({note})' if note else ''}")
    print(f"{len(cases)} cases; about {duration(left)} of work left, {duration(left / jobs)} with {jobs} at a time; "
          f"about {_bytes_left(cases, study) / 1e9:.1f} GB")


def _bytes_left(cases: list[StudyCase], study: AccuracyStudy) -> float:
    return sum(case.guessed_bytes for case in cases if study.wants(case))


def check_space(cases: list[StudyCase], study: AccuracyStudy) -> None:
    needed, free = _bytes_left(cases, study) + SPARE_BYTES, free_bytes(study.folders.out_dir)
    if needed > free:
        raise Problem(f"{study.folders.out_dir}: {needed / 1e9:.1f} GB are needed and {free / 1e9:.1f} GB are free; "
                      "make room, choose another --out or fewer muscles")


def run_study(request: Request, study: AccuracyStudy, registry: Registry, options) -> list[str]:
    """Runs what is not complete yet; a line for each case that has no result."""
    cases = plan(request, configurations(registry))
    todo = missing(cases, study)
    check_space(todo, study)
    with claimed(study.folders.out_dir, *RESULT_DIRS):
        save_registry(registry, study.folders.out_dir)
        everywhere = plan(replace(request, shard=(1, 1)), configurations(registry))
        write_manifest(study.folders.out_dir, request, everywhere, command_line())
        statuses = run_cases(todo, study, limits_of(options))
        marked = study.mark_nondeterministic(cases)
        failed = [case for case in cases if not study.is_complete(case) and not is_too_long(case)]
        if not failed and not options.keep_structures:
            study.remove_structures()
    ends = [(case, statuses.get(case, "failed")) for case in failed] + [(case, "nondeterministic") for case in marked]
    return [problem_of(case, status, study) for case, status in ends]


def command_line() -> list[str]:
    return [shlex.quote(word) for word in sys.argv]


def write_report(out_dir: Path) -> list[Path]:
    files = report.write_report(out_dir)
    for path in files:
        if path.name == PRICE_LIST:
            print(f"\n{path.read_text().rstrip()}")
    return files


def measure_and_report(options) -> int:
    check_options(options, "accuracy")
    folders, started = folders_of(options, "accuracy"), time.monotonic()
    if options.report_only:
        require_results(folders.out_dir)
        return end("accuracy", write_report(folders.out_dir), [])
    registry = read_registry(options.musclebench)
    request = request_of(options, registry, folders)
    study = AccuracyStudy(options.musclebench, folders, options.force)
    if options.dry_run:
        print_plan(plan(request, configurations(registry)), study, len(chosen_cores(options.jobs)))
        return 0
    problems = run_study(request, study, registry, options)
    measured = time.monotonic()
    files = write_report(folders.out_dir)
    print(f"\nMeasured in {duration(measured - started)}, drawn in {duration(time.monotonic() - measured)}.")
    return end("accuracy", files, problems)


def main(arguments=None) -> int:
    return run_command("accuracy", lambda: measure_and_report(parse_arguments(arguments)),
                       "complete cases are kept, unfinished ones removed (--report-only draws them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
