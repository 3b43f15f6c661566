"""The cases of the accuracy study: a recording a muscle; replays, coupled runs and probes of each configuration."""

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene
from .sweeps import Configuration

# Seconds of the parts of a case: first guesses for the reference muscle, which the progress bar corrects.
LOADING_SECONDS = 1.0
LOOP_SECONDS_A_FRAME = 0.008
JUDGING_SECONDS_A_STEP = 0.008
JUDGING_SECONDS_A_FRAME = 0.02
START_NOISE = ("--loop", "start_noise_m=1e-12")
ARMS_PRESET = "standard"
FIBRES = 100  # of a muscle, that a judged coupled run follows
FIBRES_SECONDS = 2.0
PROBING_SECONDS = 3.0
BYTES_A_NODE_AND_STEP = 8
BYTES_A_JUDGED_RUN = 10e6
BYTES_A_RUN = 0.3e6
LONGEST_SECONDS = 360.0  # what would take longer is a row with its estimate


@dataclass(frozen=True)
class RecordCase(SceneCase):
    scene: Scene

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
        """Path of the recording, below the study's folder."""
        return f"{self.folder}/{self.file_name}"

    @property
    def file_name(self) -> str:
        return f"{self.scene.key}.recording"

    @property
    def guessed_seconds(self) -> float:
        return LOADING_SECONDS + self.scene.size * self.scene.steps * 0.02

    @property
    def guessed_bytes(self) -> float:
        return BYTES_A_NODE_AND_STEP * self.scene.nodes * self.scene.steps

    def arguments(self, folders: Folders) -> list[str]:
        return ["record", self.scene.name, *self.scene.preset_arguments(), "--threads", "1",
                *self.scene.data_arguments(folders), *self.scene.frames_arguments()]

    def output(self, folder: Path) -> list[str]:
        return ["--out", str(folder / self.file_name), "--progress"]

    def record(self) -> dict:
        return {"mode": "record", "scene": self.scene.name, "preset": self.scene.preset, "threads": 1, "repetition": 0}


@dataclass(frozen=True)
class MeasuredCase(SceneCase):
    """Of one configuration in one of the study's modes, with a row in its tables."""

    scene: Scene
    configuration: Configuration
    repetition: int = 0  # only the first is judged: the answers are the same in all
    longest_seconds: float = LONGEST_SECONDS

    @property
    @abstractmethod
    def mode(self) -> str: ...

    @property
    def name(self) -> str:
        return f"{self.scene.key}-{self.mode}-{self.configuration.label}-r{self.repetition}"

    @property
    def kind(self) -> str:
        return f"{self.mode} {self.configuration.backend}"

    @property
    def threads(self) -> int:
        return self.configuration.threads

    @property
    def is_judged(self) -> bool:
        return self.repetition == 0

    @property
    def needs(self) -> tuple[str, ...]:
        """The probe builds the structures, so that their building is timed once; the others load them."""
        return (ProbeCase(self.scene.probed, self.configuration).name,) if self.configuration.stores else ()

    @property
    def structures(self) -> str:
        """Folder of the structures of the configuration, below the study's."""
        return f"structures/{self.scene.probed.key}/{self.configuration.label}"

    @property
    def building_seconds(self) -> float:
        return 0.2 if self.configuration.stores else self.configuration.build_seconds

    @property
    def guessed_bytes(self) -> float:
        return BYTES_A_RUN

    def record(self) -> dict:
        configuration = self.configuration
        return {"mode": self.mode, "scene": self.scene.name, "preset": self.scene.preset,
                "backend": configuration.backend, "parameters": dict(configuration.parameters),
                "threads": configuration.threads, "repetition": self.repetition}

    def backend_arguments(self, folders: Folders) -> list[str]:
        words = ["--backend", self.configuration.backend]
        for key, value in self.configuration.parameters:
            words += ["--param", f"{key}={value}"]
        if self.configuration.stores:
            words += ["--param", f"{self.configuration.storage}={folders.out_dir / self.structures}"]
        return [*words, "--threads", str(self.configuration.threads)]

    def repetition_arguments(self) -> list[str]:
        return ["--repetition", str(self.repetition), *([] if self.is_judged else ["--no-referee"])]


@dataclass(frozen=True)
class ReplayCase(MeasuredCase):
    """All backends answer the same positions: those of the recording."""

    stride: int = 1
    band_mm: float = 10.0
    mode = "replay"

    @property
    def recording(self) -> RecordCase:
        return RecordCase(self.scene)

    @property
    def needs(self) -> tuple[str, ...]:
        return (self.recording.name, *super().needs)

    @property
    def guessed_seconds(self) -> float:
        return LOADING_SECONDS + self.building_seconds + self.guessed_step_seconds

    @property
    def guessed_step_seconds(self) -> float:
        """A judged replay goes through the steps twice, first undisturbed."""
        a_step = self.configuration.step_ms * 1e-3
        seconds = 2 * a_step + JUDGING_SECONDS_A_STEP if self.is_judged else a_step
        return self.scene.size * self.frames * self.scene.iterations * seconds

    @property
    def frames(self) -> int:
        """Every stride-th and the last."""
        return -(-self.scene.frames // self.stride)

    @property
    def steps(self) -> int:
        """Of a judged replay, which asks twice."""
        return self.scene.iterations * self.frames * (2 if self.is_judged else 1)

    def arguments(self, folders: Folders) -> list[str]:
        return ["replay", str(folders.out_dir / self.recording.file), *self.backend_arguments(folders),
                *self.scene.data_arguments(folders), "--stride", str(self.stride), "--band-mm", f"{self.band_mm:g}",
                "--bones-only",
                *self.repetition_arguments()]


@dataclass(frozen=True)
class CoupledCase(MeasuredCase):
    """The answers move the muscle."""

    mode = "coupled"

    @property
    def steps(self) -> int:
        return self.scene.steps

    @property
    def guessed_seconds(self) -> float:
        a_step = self.configuration.step_ms * 1e-3
        judging = JUDGING_SECONDS_A_FRAME if self.is_judged else 0.0
        moving = self.scene.frames * (LOOP_SECONDS_A_FRAME + judging) + self.scene.steps * a_step
        return LOADING_SECONDS + self.building_seconds + self.scene.size * moving

    @property
    def guessed_bytes(self) -> float:
        return BYTES_A_JUDGED_RUN if self.is_judged else BYTES_A_RUN

    @property
    def snapshot_frames(self) -> list[int]:
        """Rest, full flexion and the end."""
        return sorted({0, self.scene.full_flexion_frame, self.scene.frames})

    def arguments(self, folders: Folders) -> list[str]:
        words = ["run", self.scene.name, *self.backend_arguments(folders), *self.scene.preset_arguments()]
        words.append("--no-pruning")  # structures over whole bones, as replays and probes have
        words += [*self.scene.data_arguments(folders), *self.scene.frames_arguments(), *self.repetition_arguments()]
        return words + (["--snapshots", ",".join(map(str, self.snapshot_frames))] if self.is_judged else [])


@dataclass(frozen=True)
class FloorCase(CoupledCase):
    """The exact run once more, from a start that differs by rounding: what is as far apart can't be told apart."""

    mode = "floor"

    def arguments(self, folders: Folders) -> list[str]:
        return [*super().arguments(folders), *START_NOISE]


@dataclass(frozen=True)
class ArmsCase(CoupledCase):
    """Coupled, and fibres are followed. Of the program's own scenes with the preset ARMS_PRESET: with the paper's
    constants rounding alone moves a moment arm by 10 mm."""

    mode = "arms"
    is_judged = False

    @property
    def guessed_seconds(self) -> float:
        return super().guessed_seconds + FIBRES_SECONDS

    def arguments(self, folders: Folders) -> list[str]:
        return [*super().arguments(folders), "--fibres-if-possible", str(FIBRES)]


@dataclass(frozen=True)
class ArmsFloorCase(ArmsCase):
    """The exact one, from a start that differs by rounding."""

    mode = "arms_floor"

    def arguments(self, folders: Folders) -> list[str]:
        return [*super().arguments(folders), *START_NOISE]


@dataclass(frozen=True)
class ProbeCase(MeasuredCase):
    """Error at points about the bones; builds and stores the structures that the other cases load."""

    points: int = 100_000
    mode = "probe"

    @property
    def needs(self) -> tuple[str, ...]:
        return ()

    @property
    def guessed_seconds(self) -> float:
        return LOADING_SECONDS + self.configuration.build_seconds + PROBING_SECONDS

    @property
    def guessed_bytes(self) -> float:
        return BYTES_A_RUN + self.configuration.stored_bytes

    def arguments(self, folders: Folders) -> list[str]:
        return ["probe", self.scene.name, *self.backend_arguments(folders), *self.scene.data_arguments(folders),
                "--points", str(self.points), "--band-mm", f"{self.configuration.probe_band_mm:g}"]
