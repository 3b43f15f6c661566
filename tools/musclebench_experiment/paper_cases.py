"""The cases of the paper's experiment: which scene with which backend, how long each may take, in which order."""

import math
import random
from dataclasses import dataclass

from .case import Case, Places

VERTICES = {"adductor_brevis": 502, "gluteus_maximus": 9878, "gluteus_medius": 5313, "iliacus": 6931}
# Seconds a vertex and seconds for building on a 2.5 GHz core: first guesses, which the progress bar corrects.
GUESSED_SECONDS = {"null": (7e-4, 0.5), "voxel": (8e-4, 1.0), "sdf": (8e-4, 15.0), "fcl": (6e-3, 3.0)}
PAPER_FRAMES = 314  # 157 of 0.573 degrees to full flexion, and back
PRESET = "paper"


@dataclass(frozen=True)
class PaperCase(Case):
    data_set: str  # synthetic or lhdl
    muscle: str
    backend: str
    frames_limit: int | None = None  # None: as many as the preset has

    @property
    def scene(self) -> str:
        return f"{self.data_set}/{self.muscle}"

    @property
    def name(self) -> str:
        return f"{self.muscle}-{self.backend}"

    @property
    def kind(self) -> str:
        return self.backend

    @property
    def guessed_seconds(self) -> float:
        a_vertex, building = GUESSED_SECONDS[self.backend]
        return a_vertex * VERTICES[self.muscle] + building

    def arguments(self, places: Places) -> list[str]:
        words = ["run", self.scene, "--backend", self.backend, "--preset", PRESET, "--threads", "1"]
        words += ["--snapshots", ",".join(map(str, self.snapshot_frames))]
        if places.data_dir is not None:
            words += ["--data", str(places.data_dir)]
        if self.frames_limit is not None:
            words += ["--frames", str(self.frames_limit)]
        return words

    def record(self) -> dict:
        return {"scene": self.scene, "preset": PRESET, "backend": self.backend, "threads": 1}

    @property
    def snapshot_frames(self) -> list[int]:
        """Rest, half and full flexion; any number of frames is the whole motion, there and back."""
        full = full_flexion_frame(self.frames_limit)
        return sorted({0, math.ceil(full / 2), full})


def full_flexion_frame(frames_limit: int | None) -> int:
    return (frames_limit or PAPER_FRAMES) // 2


def plan(data_set: str, frames_limit: int | None = None, seed: int = 1) -> list[PaperCase]:
    """Shuffled, so that no backend always runs first; then by magnitude of the time, so that no long case runs last."""
    cases = [PaperCase(data_set, muscle, backend, frames_limit) for muscle in VERTICES for backend in GUESSED_SECONDS]
    random.Random(seed).shuffle(cases)
    return sorted(cases, key=lambda case: -round(math.log10(case.guessed_seconds)))
