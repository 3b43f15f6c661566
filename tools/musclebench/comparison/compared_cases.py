"""Which cases of an experiment file are run interleaved: what tools/nightly measures and tools/compare compares."""

from dataclasses import replace
from pathlib import Path

from ..cases.case import Folders
from ..cases.scene import chosen_names
from ..experiments.expansion import Expansion, with_recordings
from ..experiments.experiment_file import ExperimentFile, experiment_path, read_experiment
from ..experiments.selection import Scenes, check_backend
from ..experiments.swept_case import SweptCase
from ..program.cli import Problem
from ..program.registry import Registry


def asked_experiment(options, registry: Registry) -> ExperimentFile:
    """As the command line wants it. `options`: those of add_case_options."""
    file = read_experiment(experiment_path(options.experiment))
    others = [group for group in file.groups if group.mode != "run"]
    if others:
        raise Problem(f"{file.path}: [[cases]] '{others[0].name}': mode '{others[0].mode}'; only runs are interleaved, so use mode run")
    if options.scene:
        file = file.on(tuple(chosen_names(options.scene, None, "synthetic", registry)))
    if options.frames:
        file = replace(file, groups=tuple(replace(group, frames=(options.frames,)) for group in file.groups))
    return replace(file, repetitions=options.repetitions or file.repetitions, timeout_s=options.timeout or file.timeout_s)


def first_cases(file: ExperimentFile, program: Path, registry: Registry, folders: Folders,
                backends: list[str] | None) -> list[SweptCase]:
    """Without repetitions. `backends`: None is all of the file's."""
    for backend in backends or []:
        check_backend(backend, registry)
    scenes = Scenes(program, registry, folders, "synthetic", file.frames_limit or None)
    cases = [case for case in Expansion(file, registry, scenes).firsts()
             if not case.is_too_long and (not backends or case.configuration.backend in backends)]
    if not cases:
        raise Problem(f"{file.path}: has no case of these scenes and backends; tools/experiment {file.path} --list-cases names them")
    return with_recordings(cases)
