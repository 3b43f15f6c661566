"""The cases of the paper's experiment: which scene with which backend, how long each may take, in which order."""

import math
import random
from dataclasses import dataclass

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene

# Seconds a vertex and seconds for building on a 2.5 GHz core: first guesses, which the progress bar corrects.
GUESSED_SECONDS = {"null": (7e-4, 0.5), "voxel": (8e-4, 1.0), "sdf": (8e-4, 15.0), "fcl": (6e-3, 3.0)}

BACKENDS = list(GUESSED_SECONDS)  # in the order of its tables and figures

MOMENTS = 20  # of a motion, for the page's view in space


@dataclass(frozen=True)
class PaperCase(SceneCase):
    scene: Scene
    backend: str

    @property
    def name(self) -> str:
        return f"{self.scene.key}-{self.backend}"

    @property
    def kind(self) -> str:
        return self.backend

    @property
    def guessed_seconds(self) -> float:
        a_vertex, building = GUESSED_SECONDS[self.backend]
        return a_vertex * self.scene.nodes + building

    def arguments(self, folders: Folders) -> list[str]:
        words = ["run", self.scene.name, "--backend", self.backend, *self.scene.preset_arguments(), "--threads", "1"]
        words.append("--no-pruning")  # table 1 is the memory of structures over whole bones
        words += ["--snapshots", ",".join(map(str, self.snapshot_frames))]
        return [*words, *self.scene.data_arguments(folders), *self.scene.frames_arguments()]

    def record(self) -> dict:
        return {"scene": self.scene.name, "preset": self.scene.preset, "backend": self.backend, "threads": 1}

    @property
    def snapshot_frames(self) -> list[int]:
        """Rest, half and full flexion, the end, and what shows the motion between them."""
        flexions = {self.scene.half_flexion_frame, self.scene.full_flexion_frame}
        frames = self.scene.frames
        between = {round(moment * frames / MOMENTS) for moment in range(MOMENTS)}
        return sorted(between | flexions | {frames})


def plan(scenes: list[Scene], seed: int = 1) -> list[PaperCase]:
    """Shuffled, so that no backend always runs first; then by magnitude of the time, so that no long case runs last."""
    cases = [PaperCase(scene, backend) for scene in scenes for backend in GUESSED_SECONDS]
    random.Random(seed).shuffle(cases)
    return sorted(cases, key=lambda case: -round(math.log10(case.guessed_seconds)))
