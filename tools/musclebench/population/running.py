"""The members of a population as an experiment: which scenes and settings its cases have."""

import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..cases.case import Folders
from ..cases.scene import Scene, asked
from ..experiments.experiment_file import CaseGroup, ExperimentFile
from ..experiments.selection import check_backend
from ..program.cli import Problem
from ..program.registry import Registry, plain_value

MEMBERS = "members"


@dataclass
class MemberScenes:
    """The scenes of an experiment's cases: those of the members."""

    scenes: list[Scene]
    numbers: dict[str, int]  # {scene's name: member}
    refused: dict[int, str] = field(default_factory=dict)  # {member: why the program does not read it}

    def of(self, group: CaseGroup, experiment: ExperimentFile) -> list[Scene]:
        return self.scenes

    def limited(self, scene: Scene, frames: int) -> Scene:
        raise NotImplementedError("cases of a population have no frames of their own")

    def hard_cases(self, wanted: tuple[str, ...]) -> list[str]:
        return []


def survey_members(files: dict[int, Path], options: Any, registry: Registry, folders: Folders, say: Callable[[str], None]) -> MemberScenes:
    """Asks the program about each; one that it refuses is a row of the report."""
    found = MemberScenes([], {str(path): number for number, path in files.items()})

    def ask(item: tuple[int, Path]) -> Scene | str:
        below = str(item[1].relative_to(folders.out_dir))
        scene = Scene(str(item[1]), asks_preset=False, frames_limit=options.frames_limit, below=below)
        try:
            return asked(scene, options.musclebench, registry, folders)
        except (Problem, subprocess.TimeoutExpired) as problem:
            return str(problem)

    with ThreadPoolExecutor(options.jobs or 2) as pool:
        for place, (number, told) in enumerate(zip(files, pool.map(ask, files.items())), start=1):
            if isinstance(told, str):
                found.refused[number] = told
            else:
                found.scenes.append(told)
            if is_told(place, len(files)):
                say(f"{place} of {len(files)} members read")
    if not found.scenes:
        raise Problem(f"the program reads no member: {next(iter(found.refused.values()))}")
    return found


def is_told(place: int, of: int) -> bool:
    """Ten times on the way."""
    return place * 10 // of > (place - 1) * 10 // of


def with_settings(file: ExperimentFile, options: Any, registry: Registry) -> ExperimentFile:
    """The experiment with what the command line asks for. Without --setting the control is left out: it collides with nothing."""
    more: list[str] = []
    for option in ("effect", "loop", "wanted"):
        for word in getattr(options, option) or []:
            more += [f"--{option}", word]
    if options.setting:
        groups = [_group(word, number, registry) for number, word in enumerate(options.setting, start=1)]
    else:
        control = registry.control
        usual = file.groups[-1]
        fast = tuple(one.name for one in registry.backends if not (one.is_slow or one.is_external or one == control))
        groups = [replace(usual, backends=fast)]
    names = [(group.backends, group.parameters) for group in groups]
    if len(set(names)) < len(names):
        raise Problem("--setting: two are alike; leave one out")
    return replace(file, groups=tuple(replace(group, options=(*group.options, *more)) for group in groups))


def _group(word: str, number: int, registry: Registry) -> CaseGroup:
    name, _, told = word.partition(":")
    check_backend(name, registry, "--setting")
    known = {one.name for one in registry.backend(name).parameters}
    parameters = []
    for pair in told.split(",") if told else []:
        key, separator, value = pair.partition("=")
        if not separator or key not in known:
            raise Problem(f"--setting {word}: '{pair}' is not like key=value with a parameter of {name}; there are {', '.join(sorted(known)) or 'none'}")
        parameters.append((key, (plain_value(value),)))
    return CaseGroup(f"setting{number}", named="{scene}-{configuration}", backends=(name,), parameters=tuple(parameters))
