#!/usr/bin/python3
"""Runs the accuracy study and writes what it shows. Options: musclebench/options/accuracy.py."""

import sys
import time
from dataclasses import replace
from pathlib import Path

from musclebench.accuracy import report
from musclebench.board.packing import pack
from musclebench.cases.progress import duration
from musclebench.cases.study_command import end, folders_of, require_results
from musclebench.experiments.command import chosen, print_plan
from musclebench.experiments.experiment_file import CaseGroup, ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.experiments.selection import beside_references
from musclebench.options.accuracy import QUICK_MUSCLE, parse_arguments
from musclebench.options.shared import check_options
from musclebench.page.of_study import page_of
from musclebench.pictures.in_display import draw_in_display
from musclebench.program.cli import Problem, run_command
from musclebench.program.optional_packages import left_out_without
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem

QUICK_REPLAY_SECONDS = 2.0
QUICK_FORCES_SECONDS = 30.0  # of a case: what takes longer is a row with its estimate
PRICE_LIST = "price_list.txt"


def asked(file: ExperimentFile, options, registry: Registry) -> ExperimentFile:
    """The experiment as the options want it."""
    if options.band_mm:
        file = file.with_groups(band_mm=options.band_mm)
    if options.longest:
        file = file.with_groups(longest_s=options.longest)
    if options.backend:
        names = beside_references(options.backend, registry)
        file = replace(file, groups=tuple(replace(group, backends=names) if group.backends == "all" else group for group in file.groups))
    if options.quick:
        file = replace(file, repetitions=1, groups=tuple(_quick(group) for group in file.groups))
    return file


def _quick(group: CaseGroup) -> CaseGroup:
    if group.name == "forces":
        return replace(group, configurations="default", longest_s=QUICK_FORCES_SECONDS)
    configurations = "study_quick" if group.configurations == "study" else group.configurations
    return replace(group, configurations=configurations, replay_s=QUICK_REPLAY_SECONDS)


def write_report(out_dir: Path) -> list[Path]:
    files = list(report.write_report(out_dir))
    for path in files:
        if path.name == PRICE_LIST:
            print(f"\n{path.read_text().rstrip()}")
    return files


def bundle_files(options, out_dir: Path, problems: list[str]) -> list[Path]:
    """For the board, where it is asked for. Without one the study stays; why joins the problems."""
    try:
        return [pack(out_dir)[0]] if options.bundle else []
    except (Problem, ResultProblem) as problem:
        problems.append(f"no bundle: {problem}; then tools/bundle {out_dir}")
        return []


def finish(options, out_dir: Path, problems: list[str], measured: tuple[float, float] | None = None) -> int:
    """`measured`: how long that took, and when it ended, in seconds."""
    files, is_drawn = write_report(out_dir), True
    try:
        with left_out_without("the pictures in space"):
            files += draw_in_display("bone_pressure", out_dir, [])
    except Problem as problem:
        is_drawn = False  # those of before stay
        problems.append(str(problem))
    files += [*page_of("accuracy", out_dir, options), *bundle_files(options, out_dir, problems)]
    if measured:
        print(f"\nMeasured in {duration(measured[0])}, drawn in {duration(time.monotonic() - measured[1])}.")
    return end("accuracy", files, problems, out_dir if is_drawn else None)


def measure_and_report(arguments) -> int:
    file = of_project("accuracy")
    options = parse_arguments(arguments, file)
    check_options(options, "accuracy")
    folders, started = folders_of(options, "accuracy"), time.monotonic()
    if options.report_only:
        require_results(folders.out_dir)
        problems: list[str] = []
        return finish(options, folders.out_dir, problems)
    registry = read_registry(options.musclebench)
    sweep = sweep_of(asked(file, options, registry), options, registry, folders, QUICK_MUSCLE if options.quick else None)
    cases, limits = chosen(sweep, options.shard), limits_of(options)
    if options.dry_run:
        print_plan(cases, sweep, len(limits.cores))
        return 0
    problems = sweep.run(cases, limits, options.keep_structures)
    measured = time.monotonic()
    return finish(options, folders.out_dir, problems, (measured - started, measured))


def main(arguments=None) -> int:
    return run_command("accuracy", lambda: measure_and_report(arguments),
                       "complete cases are kept, unfinished ones removed (--report-only draws them)", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
