"""The cases of an experiment file without a program: its scenes are fake_registry's."""

from dataclasses import dataclass, replace
from pathlib import Path

import fake_registry
from musclebench.cases.scene import Scene
from musclebench.experiments.expansion import Expansion
from musclebench.experiments.experiment_file import ASKED, ExperimentFile, experiment_path, read_experiment
from musclebench.experiments.record_case import RecordCase
from musclebench.experiments.swept_case import SweptCase


@dataclass
class FakeScenes:
    """`scenes`: those of the experiment; a group's own are by their names."""

    scenes: tuple[Scene, ...]

    def of(self, group, experiment):
        preset = group.preset or experiment.preset or "paper"
        if group.scenes == ASKED:
            return []
        if not group.scenes:
            return [replace(scene, preset=preset) for scene in self.scenes]
        known = [entry.name for entry in fake_registry.registry().scenes]
        data_set = self.scenes[0].name.split("/")[0]
        wanted = tuple(one.replace("{data}", data_set).rstrip("*") for one in group.scenes)
        return [replace(fake_registry.scene(name), asks_preset=bool(group.preset)) for name in known if name.startswith(wanted)]

    def hard_cases(self, wanted):
        return list(wanted or ("rest", "pinch", "thin-plate"))

    def limited(self, scene, frames):
        return replace(fake_registry.scene(scene.name, frames), preset=scene.preset)


def expansion(experiment: str | Path | ExperimentFile, *scenes: Scene) -> Expansion:
    """`experiment`: a name, a file or what was read of one. `scenes`: by default the synthetic ones."""
    if not isinstance(experiment, ExperimentFile):
        experiment = read_experiment(experiment_path(str(experiment)))
    return Expansion(experiment, fake_registry.registry(), FakeScenes(scenes or fake_registry.scenes("synthetic")))


def swept(experiment, *scenes: Scene) -> list[SweptCase | RecordCase]:
    """All in the order in which they run."""
    whole = expansion(experiment, *scenes)
    return whole.cases(whole.firsts())


def one_of(experiment, scene: Scene, ending: str) -> SweptCase:
    """The one whose name ends so."""
    found, = [case for case in swept(experiment, scene) if case.name.endswith(ending)]
    return found
