"""What every command that runs an experiment file does: reads it, makes its cases, runs what is missing."""

import math
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.pool import Limits, run_cases
from ..cases.scene import chosen_names
from ..cases.study_command import missing, problem_of
from ..program.cli import Problem, chosen_cores, data_set_of
from ..program.disk import free_bytes
from ..program.machine import total_memory_bytes
from ..program.out_folder import claimed_by_command
from ..program.registry import Registry, save_registry
from ..program.release_build import check_release
from .earlier import earlier_plan, refuse_other_settings, remove_other_settings, settings_of, with_earlier
from .expansion import Expansion
from .experiment_file import ExperimentFile
from .manifest import write_manifest
from .selection import Scenes
from .swept_case import SweptCase
from .swept_experiment import RESULT_DIRS, SweptExperiment

SPARE_BYTES = 100e6
MEMORY_SHARE = 0.9


@dataclass
class Sweep:
    """An experiment file as this command line wants it, on this program."""

    file: ExperimentFile
    cases: list[Case]  # of the whole experiment
    order: dict[SweptCase, int]  # of first repetitions, as the file lists them
    experiment: SweptExperiment
    registry: Registry
    any_build: bool = True  # else what is timed has to be of a Release build
    kept: list[SweptCase] = field(default_factory=list)  # complete ones of the same study, of scenes and repetitions not asked now
    force: bool = False  # a study of other settings is replaced

    def of(self, *groups: str) -> list[SweptCase]:
        """Cases of these [[cases]] in the order of the file's lists, round by round; with those that are kept."""
        chosen = [case for case in [*self.cases, *self.kept] if isinstance(case, SweptCase) and case.group.name in groups]
        return sorted(chosen, key=lambda case: (case.repetition, self.order[replace(case, repetition=0)]))

    def done(self, *groups: str) -> dict[SweptCase, Path]:
        """{case: folder} of the complete ones."""
        return {case: self.experiment.folder(case) for case in self.of(*groups) if self.experiment.is_complete(case)}

    def run(self, cases: list[Case], limits: Limits, keep_structures: bool = False) -> list[str]:
        """A line for each case that has no result. `cases`: those to run here, all or some."""
        out_dir = self.experiment.folders.out_dir
        if not self.force:
            refuse_other_settings(out_dir, self.file)
        todo = missing(cases, self.experiment)
        if not self.any_build and any(isinstance(case, SweptCase) and case.is_timed for case in todo):
            check_release(self.experiment.binary)
        check_space(todo, out_dir)
        with claimed_by_command(out_dir, *RESULT_DIRS):
            remove_other_settings(out_dir, self.file, RESULT_DIRS)
            save_registry(self.registry, out_dir)
            write_manifest(out_dir, self.file, [*self.cases, *self.kept], sys.argv, settings_of(self.file))
            statuses = run_cases(todo, self.experiment, limits)
            marked = self.experiment.mark_nondeterministic([case for case in cases if isinstance(case, SweptCase)])
            failed = [case for case in cases if not case.is_too_long and not self.experiment.is_complete(case)
                      and case not in marked]
            if not failed and not keep_structures:
                self.experiment.remove_structures()
        ends = [(case, statuses.get(case, "failed")) for case in failed] + [(case, "nondeterministic") for case in marked]
        return [problem_of(case, status, self.experiment) for case, status in ends]


def check_space(cases: list[Case], out_dir: Path) -> None:
    needed, free = sum(case.guessed_bytes for case in cases) + SPARE_BYTES, free_bytes(out_dir)
    if needed > free:
        raise Problem(f"{out_dir}: {needed / 1e9:.1f} GB are needed and {free / 1e9:.1f} GB are free; "
                      "make room, choose another --out or fewer muscles")


def sweep_of(file: ExperimentFile, options, registry: Registry, folders: Folders, quick_muscle: str | None = None,
             scenes: Scenes | None = None) -> Sweep:
    """`scenes`: those of the experiment, where they are known already. `options`: data, scene, muscle, musclebench, force;
    frames_limit, repetitions, micro, any_build where a command has them; one without any_build uses no times."""
    data_set = data_set_of(options)
    if options.scene or options.muscle or quick_muscle:
        file = file.on(tuple(chosen_names(options.scene, options.muscle, data_set, registry, quick_muscle)))
    if getattr(options, "repetitions", None):
        file = replace(file, repetitions=options.repetitions)
    file = replace(file, frames_limit=getattr(options, "frames_limit", None) or file.frames_limit)
    scenes = scenes or Scenes(options.musclebench, registry, folders, data_set, file.frames_limit or None)
    experiment = SweptExperiment(options.musclebench, folders, file.answers, options.force, getattr(options, "micro", None),
                                 getattr(options, "keep_cases", False))
    expansion = Expansion(file, registry, scenes)
    firsts = expansion.firsts()
    cases, kept = expansion.cases(firsts), []
    if wider := with_earlier(file, earlier_plan(folders.out_dir), registry):
        asked, expansion = firsts, Expansion(wider, registry, scenes)
        firsts = expansion.firsts()
        kept = kept_cases(expansion.cases(firsts), cases, experiment)
        places = {case.name: place for place, case in enumerate(firsts)}
        firsts = sorted(dict.fromkeys([*firsts, *asked]), key=lambda case: places.get(case.name, len(places)))
    order = {case: place for place, case in enumerate(firsts)}
    return Sweep(file, cases, order, experiment, registry, getattr(options, "any_build", True), kept, options.force)


def kept_cases(every: list[Case], cases: list[Case], experiment: SweptExperiment) -> list[SweptCase]:
    """The complete ones of a wider experiment that are none of `cases`."""
    names = {case.name for case in cases}
    return [case for case in every if isinstance(case, SweptCase) and case.name not in names and experiment.is_complete(case)]


def limits_of(options) -> Limits:
    """`options`: jobs, timeout; memory_gb where a command has it. A case gets no more than its share of the memory."""
    cores, memory_gb = chosen_cores(options.jobs), getattr(options, "memory_gb", None)
    if memory_gb == math.inf:
        return Limits(cores, options.timeout)
    share = MEMORY_SHARE * total_memory_bytes() / len(cores)
    return Limits(cores, options.timeout, int(memory_gb * 1e9 if memory_gb else share))
