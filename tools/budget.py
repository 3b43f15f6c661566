#!/usr/bin/python3
"""Refines each source of error of a scene alone and writes the budget. Options: musclebench/options/budget.py."""

import math
import sys
from dataclasses import replace

from musclebench.budget.budget_report import budgets_of, write_report
from musclebench.budget.choice import choices_of, hold, in_words, resolutions
from musclebench.budget.sources import Budget
from musclebench.cases.scene import Scene
from musclebench.cases.study_command import end, folders_of
from musclebench.experiments.experiment_file import CaseGroup, ExperimentFile, of_project
from musclebench.experiments.running import Sweep, limits_of, sweep_of
from musclebench.experiments.selection import check_backend
from musclebench.experiments.swept_case import SweptCase
from musclebench.figures import looks
from musclebench.options.budget import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import Problem, run_command
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem, Run, read_run
from musclebench.tables.table_formats import as_text


def asked(file: ExperimentFile, options, registry: Registry) -> ExperimentFile:
    """With factors that double up to --finest, and the backends of --backend."""
    groups = []
    for group in file.groups:
        changes: dict = {key: doubled(getattr(group, key), options.finest) for key in ("times_substeps", "times_iterations") if getattr(group, key)}
        if group.name == "muscle_mesh":  # beside the two finest runs of the time step
            changes["times_substeps"] = doubled((1.0,), options.finest)[-2:]
        if group.name == "collision" and options.backend:
            changes["backends"] = tuple(dict.fromkeys(check_backend(name, registry) for name in options.backend))
        groups.append(replace(group, **changes))
    if options.error_mm is not None:
        groups.append(resolutions(next(group for group in groups if group.name == "collision"), registry))
    return replace(file, groups=tuple(groups))


def doubled(factors: tuple[float, ...], finest: int) -> tuple[float, ...]:
    """Those below 2, and then 2, 4, ... as long as they are no more than `finest`."""
    more = [float(2**power) for power in range(1, finest.bit_length()) if 2**power <= finest]
    return (*(factor for factor in factors if factor < 2), *more)


def run_and_report(arguments) -> int:
    file = of_project("budget")
    options = parse_arguments(arguments, file)
    check_options(options, "budget")
    if options.finest < 2:
        raise Problem(f"--finest {options.finest}: nothing is refined; it must be 2 or more")
    if options.error_mm is not None and not 0 < options.error_mm < math.inf:
        raise Problem(f"--error-mm {options.error_mm:g}: must be above zero")
    folders, registry = folders_of(options, "budget"), read_registry(options.musclebench)
    looks.know(registry)
    file = asked(file, options, registry)
    sweep = sweep_of(file, options, registry, folders)
    problems = sweep.run(sweep.cases, limits_of(options))
    runs = read(sweep, file)
    if not runs:
        return end("budget", [], problems)
    budgets, chosen = budgets_of(runs), []
    if options.error_mm is not None:
        asked_now = dict.fromkeys(case.scene for case in sweep.cases if isinstance(case, SweptCase))
        found = {scene: choices_of(budget, {case: run for case, run in runs.items() if case.scene == scene}, registry)
                 for scene in asked_now if isinstance(budget := budgets.get(scene), Budget)}
        chosen = [f"{scene.key}: nothing can be chosen: no finer time step ended well." for scene, one in found.items() if one is None]
        choices = {scene: one for scene, one in found.items() if one is not None}
        extra: list[CaseGroup] = []
        ran: list[SweptCase] = []

        def run_all(wanted: dict[Scene, CaseGroup]) -> dict[Scene, Run]:
            extra.extend(group for group in dict.fromkeys(wanted.values()) if group not in extra)
            wider = replace(file, groups=(*file.groups, *extra))
            more = sweep_of(wider, options, registry, folders)
            mine = [case for case in more.cases if isinstance(case, SweptCase) and wanted.get(case.scene) == case.group]
            ran.extend(mine)
            problems.extend(replace(more, cases=[*sweep.cases, *ran]).run(mine, limits_of(options)))
            done = read(more, wider)
            runs.update({case: done[case] for case in mine if case in done})
            return {case.scene: done[case] for case in mine if case in done}

        pattern = next(group for group in file.groups if group.name == "collision")
        tried = hold(choices, options.error_mm, pattern, run_all)
        chosen += [in_words(choices[scene], options.error_mm, candidates) for scene, candidates in tried.items()]
        if options.frames_limit:
            chosen.append(f"All of a motion in {options.frames_limit} frames: the whole motion may want more substeps.")
    table, sentences, files = write_report(runs, budgets, chosen, folders.out_dir)
    print("\n" + "\n".join([as_text(table), "", *sentences]))
    return end("budget", files, problems, folders.out_dir)


def read(sweep: Sweep, file: ExperimentFile, *groups: str) -> dict[SweptCase, Run]:
    """The complete ones."""
    return {case: read_run(folder) for case, folder in sweep.done(*(groups or (group.name for group in file.groups))).items()}


def main(arguments=None) -> int:
    return run_command("budget", lambda: run_and_report(arguments),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
