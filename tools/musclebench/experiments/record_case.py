"""The recording of a scene, whose positions replays ask every backend about."""

from dataclasses import dataclass

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene

LOADING_SECONDS = 1.0  # first guesses, which the progress bar corrects
SECONDS_A_STEP = 0.02  # of the reference muscle
BYTES_A_NODE_AND_STEP = 8


@dataclass(frozen=True)
class RecordCase(SceneCase):
    scene: Scene
    is_too_long = False

    @property
    def name(self) -> str:
        return self.scene.key

    @property
    def kind(self) -> str:
        return "record"

    @property
    def folder(self) -> str:
        return f"recordings/{self.name}"

    @property
    def file(self) -> str:
        """Path of the recording, below the experiment's folder."""
        return f"{self.folder}/{self.file_name}"

    @property
    def file_name(self) -> str:
        return f"{self.scene.key}.recording"

    @property
    def guessed_seconds(self) -> float:
        return LOADING_SECONDS + self.scene.size * self.scene.steps * SECONDS_A_STEP

    @property
    def guessed_bytes(self) -> float:
        return BYTES_A_NODE_AND_STEP * self.scene.nodes * self.scene.steps

    def arguments(self, folders: Folders) -> list[str]:
        return ["record", self.scene.name, *self.scene.preset_arguments(), "--threads", "1",
                *self.scene.data_arguments(folders), *self.scene.frames_arguments()]

    def output(self, folder) -> list[str]:
        return ["--out", str(folder / self.file_name), "--progress"]

    def record(self) -> dict:
        return {"mode": "record", "scene": self.scene.name, "preset": self.scene.preset, "threads": 1, "repetition": 0}
