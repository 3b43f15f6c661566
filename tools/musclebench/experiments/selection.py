"""Which scenes and which configurations of the backends a group of cases names."""

import subprocess
from dataclasses import replace
from itertools import product

from ..cases.case import Folders
from ..cases.scene import Scene, asked, chosen_names, survey
from ..hard.cells import cases_of
from ..program.cli import Problem
from ..program.registry import Backend, Registry, plain_value
from .sweeps import Configuration, configurations, raced
from .experiment_file import ASKED, SCENE_SETS, CaseGroup, ExperimentFile


def usual_backend(registry: Registry) -> Backend:
    """An exact one, so that what is swept is all that differs; one with a clearance cache, since that is fast."""
    exact = [backend for backend in registry.backends if backend.is_exact]
    cached = [backend for backend in exact if backend.of_role("clearance_cache")]
    return (cached or exact or list(registry.backends))[0]


def check_backend(wanted: str, registry: Registry, option: str = "--backend") -> str:
    if not registry.has(wanted):
        raise Problem(f"{option} {wanted}: not built; there are: {', '.join(registry.names)}")
    return wanted


def backend_of(wanted: str | None, registry: Registry) -> str:
    """That of an option, else the usual one."""
    return check_backend(wanted, registry) if wanted else usual_backend(registry).name


def beside_references(wanted: list[str], registry: Registry) -> tuple[str, ...]:
    """These backends and those that tables compare with, in the program's order."""
    references = [registry.control, registry.unit_of_price and registry.unit_of_price[0], usual_backend(registry)]
    names = {check_backend(name, registry) for name in wanted} | {backend.name for backend in references if backend}
    return tuple(name for name in registry.names if name in names)


def backends_of(group: CaseGroup, experiment: ExperimentFile, registry: Registry) -> list[Backend]:
    if group.backends == "all":
        return list(registry.backends)
    if group.backends == "exact":
        return [usual_backend(registry)]
    if group.backends == "control":
        return [registry.control or registry.backends[0]]
    if group.backends in ("fast", "slow"):
        return [backend for backend in registry.backends
                if backend.is_slow == (group.backends == "slow") and not backend.is_external]
    if group.backends == "external":
        return [backend for backend in registry.backends if backend.is_external]
    wanted = [name for name in group.backends if registry.has(name) or not group.if_built]
    where = f"{experiment.path}: [[cases]] '{group.name}': backends"
    return [registry.backend(check_backend(name, registry, where)) for name in wanted]


def configurations_of(group: CaseGroup, experiment: ExperimentFile, registry: Registry) -> list[Configuration]:
    """Of each backend its defaults, or what its study.toml sweeps or races; times the group's parameters and threads.
    Kernels choose theirs themselves."""
    if group.mode == "kernels":
        return [Configuration("", threads=threads, named="kernels") for threads in group.threads]
    every = raced(registry) if group.configurations == "race" else configurations(registry)
    found = []
    for backend in backends_of(group, experiment, registry):
        own = [one for one in every if one.backend == backend.name]
        if group.configurations == "default":
            # Its guesses are those of the study's own default.
            plain = [replace(one, storage="") for one in own if not one.parameters and one.threads == 1]
            own = plain or [replace(own[0], parameters=(), storage="", threads=1, has_cache=backend.uses_cache({}))]
        elif group.configurations == "study_quick":
            own = [one for one in own if one.in_quick]
        elif group.configurations not in ("study", "race"):
            own = [_of_set(group, experiment, backend, own)]
        found += [one for one in own if _is_asked(one, group)]
    return [_with(one, chosen, threads) for one in found for chosen in _grid(group, experiment, registry.backend(one.backend))
            for threads in (group.threads if group.threads != (1,) else (one.threads,))]


def _of_set(group: CaseGroup, experiment: ExperimentFile, backend: Backend, swept: list[Configuration]) -> Configuration:
    """The configuration of the choices that the backend's study names so."""
    known = {one["text"]: one["parameters"] for one in backend.study.get("named", [])}
    if group.configurations not in known:
        raise Problem(f"{experiment.path}: [[cases]] '{group.name}': configurations: '{group.configurations}' is no set of choices "
                      f"of {backend.name}; there are: {', '.join(['default', 'study', 'study_quick', 'race', *known])}")
    wanted = {key: plain_value(value) for key, value in known[group.configurations].items()}
    found = [one for one in swept if {key: plain_value(value) for key, value in one.parameters} == wanted and one.threads == 1]
    if not found:
        raise Problem(f"{experiment.path}: [[cases]] '{group.name}': configurations: no series of {backend.name}'s study.toml has the "
                      f"choices of '{group.configurations}'; add one")
    return found[0]


def one_of(scenes: list[Scene], wanted: str | tuple[str, ...]) -> list[Scene]:
    """The largest, or the first of the wanted keys that there is, else the first; none of none."""
    if wanted == "largest":
        return [max(scenes, key=lambda scene: scene.nodes)] if scenes else []
    return [*(scene for key in wanted for scene in scenes if scene.key == key), *scenes][:1]


def _is_asked(one: Configuration, group: CaseGroup) -> bool:
    drives = one.drives_quick if group.configurations == "study_quick" else one.drives
    holds = {"replays": one.replays, "drives": drives, "probed": one.is_probed, "one_thread": one.threads == 1}
    return all(holds[word] for word in group.only)


def _grid(group: CaseGroup, experiment: ExperimentFile, backend: Backend) -> list[tuple]:
    known = {parameter.name for parameter in backend.parameters}
    for key, _ in group.parameters:
        if key not in known:
            raise Problem(f"{experiment.path}: [[cases]] '{group.name}': parameters: '{key}' is none of {backend.name}; "
                          f"there are: {', '.join(sorted(known)) or 'none'}")
    keys = [key for key, _ in group.parameters]
    return [tuple(zip(keys, values)) for values in product(*(values for _, values in group.parameters))]


def _with(one: Configuration, chosen: tuple, threads: int) -> Configuration:
    told = dict(one.parameters) | dict(chosen)
    return replace(one, parameters=tuple(told.items()), threads=threads)


def scenes_with_other_muscles(names: list[str], data_set: str, registry: Registry) -> list[str]:
    """Those of the data set in which a muscle moves that none of the named scenes has."""
    known = {muscle for scene in registry.scenes if scene.name in names for muscle in scene.muscles}
    return [scene.name for scene in registry.scenes
            if scene.name.startswith(f"{data_set}/") and not known.issuperset(scene.muscles)]


class Scenes:
    """Asks the program about each scene once."""

    def __init__(self, program, registry: Registry, folders: Folders, data_set: str, frames_limit: int | None = None):
        self._program, self._registry, self._folders = program, registry, folders
        self._data_set, self._frames_limit = data_set, frames_limit
        self._known: dict[tuple, list[Scene]] = {}

    def of(self, group: CaseGroup, experiment: ExperimentFile) -> list[Scene]:
        """Those of its own are as they are, but for a preset of its own: frames are limited of the experiment's only."""
        preset = group.preset or experiment.preset or None
        if group.scenes == ASKED:
            return []
        if group.scenes:
            return self._survey(self._names(group.scenes), group.preset or None, None, own_presets=True)
        names = experiment.scenes if isinstance(experiment.scenes, tuple) else (experiment.scenes,)
        return self._survey(self._names(names), preset, self._frames_limit, of_files=not group.file_presets)

    def limited(self, scene: Scene, frames: int) -> Scene:
        """The same with so many frames of its motion."""
        key = (scene, frames)
        if key not in self._known:
            self._known[key] = [asked(replace(scene, frames_limit=frames), self._program, self._registry, self._folders)]
        return self._known[key][0]

    def hard_cases(self, wanted: tuple[str, ...]) -> list[str]:
        """Of the program, in its order. Raises Problem where it has not one of the wanted."""
        words = [word for case in wanted for word in ("--case", case)]
        told = subprocess.run([str(self._program), "hard", "--list", *words], capture_output=True, text=True, check=False)
        if told.returncode != 0:
            lines = told.stderr.strip().splitlines() or [f"'hard --list' ended with exit code {told.returncode}"]
            raise Problem(lines[-1].removeprefix("musclebench: "))
        return list(cases_of(told.stdout)["case"])

    def _names(self, wanted: str | tuple[str, ...]) -> list[str]:
        """`one_muscle`: all of the data set that have one; `every_muscle`: those, and all with a muscle that no such scene
        has; PREFIX/*: all that begin so; {data} is the data set."""
        words = (wanted,) if isinstance(wanted, str) else wanted
        names: list[str] = []
        for word in words:
            if word in SCENE_SETS:
                names += chosen_names(None, None, self._data_set, self._registry)
                names += scenes_with_other_muscles(names, self._data_set, self._registry) if word == "every_muscle" else []
            elif word.endswith("/*"):
                names += [scene.name for scene in self._registry.scenes if scene.name.startswith(word[:-1])]
            else:
                names += chosen_names([word.replace("{data}", self._data_set)], None, self._data_set, self._registry)
        return list(dict.fromkeys(names))

    def _survey(self, names: list[str], preset: str | None, frames: int | None, **which: bool) -> list[Scene]:
        key = (tuple(names), preset, frames, tuple(which.items()))
        if key not in self._known:
            self._known[key] = survey(names, self._program, self._registry, self._folders, frames, preset, **which)
        return self._known[key]
