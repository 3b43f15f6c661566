"""The cases of the study of effects: a scene with a set of effects, and the small scenes that show one effect each."""

from dataclasses import dataclass

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene
from ..program.registry import Registry
from .effect_sets import EffectSet, effect_sets

PRESET = "standard"
FIBRES = 100  # of a muscle
SHOWN_SCENES = "effects/"  # what the names of the small scenes begin with
SECONDS_A_STEP = 0.004  # of the reference muscle with an effect or two more than the scene has; judging included


@dataclass(frozen=True)
class EffectCase(SceneCase):
    scene: Scene
    backend: str
    chosen: EffectSet
    repetition: int = 0

    @property
    def name(self) -> str:
        return f"{self.scene.key}-{self.chosen.name}-r{self.repetition}"

    @property
    def kind(self) -> str:
        return "effects"

    @property
    def guessed_seconds(self) -> float:
        share = len(self.chosen.effects) / max(1, len(self.scene.effects))
        return 2.0 + SECONDS_A_STEP * self.scene.size * self.scene.steps * share

    @property
    def snapshot_frames(self) -> list[int]:
        return sorted({self.scene.full_flexion_frame, self.scene.frames})

    def arguments(self, folders: Folders) -> list[str]:
        return ["run", self.scene.name, "--backend", self.backend, *self.scene.preset_arguments(), "--threads", "1",
                *self.chosen.options(self.scene.effects), "--repetition", str(self.repetition), "--self-intersections",
                "--snapshots", ",".join(map(str, self.snapshot_frames)), "--fibres-if-possible", str(FIBRES),
                *self.scene.data_arguments(folders), *self.scene.frames_arguments()]

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "preset": self.scene.preset, "backend": self.backend,
                "parameters": {}, "threads": 1, "repetition": self.repetition,
                "effects": {name: {} for name in self.chosen.effects}}


@dataclass(frozen=True)
class ShownCase(SceneCase):
    """A small scene as it is, kept at its beginning and its end."""

    scene: Scene
    backend: str

    @property
    def name(self) -> str:
        return f"shown-{self.scene.key}"

    @property
    def kind(self) -> str:
        return "shown"

    @property
    def guessed_seconds(self) -> float:
        return 2.0

    def arguments(self, folders: Folders) -> list[str]:
        return ["run", self.scene.name, "--backend", self.backend, "--threads", "1", "--snapshots",
                f"0,{self.scene.frames}"]

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "backend": self.backend, "parameters": {}, "threads": 1}


def plan(scenes: list[Scene], registry: Registry, backend: str, repetitions: int, quick: bool) -> list[EffectCase]:
    """Repetitions outside, so that what slows the machine for a while slows all sets alike."""
    return [EffectCase(scene, backend, chosen, repetition) for repetition in range(repetitions) for scene in scenes
            for chosen in effect_sets(scene.effects, registry.effects, quick)]


def shown_names(registry: Registry) -> list[str]:
    return [scene.name for scene in registry.scenes if scene.name.startswith(SHOWN_SCENES)]
