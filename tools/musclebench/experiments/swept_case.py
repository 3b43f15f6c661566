"""One case of an experiment file: what the program is asked, and what that may cost."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene
from .sweeps import Configuration
from .experiment_file import CaseGroup
from .kernels import KERNELS_FILE, sampling
from .record_case import LOADING_SECONDS, RecordCase

# Seconds of the parts of a case: first guesses for the reference muscle, which the progress bar corrects.
LOOP_SECONDS_A_STEP = 0.003  # beside collision
JUDGING_SECONDS_A_STEP = 0.008
JUDGING_SECONDS_A_FRAME = 0.02
LOADING_STRUCTURES_SECONDS = 0.2
PROBING_SECONDS = 3.0
BYTES_A_JUDGED_RUN = 10e6
BYTES_A_RUN = 0.3e6

SHOWN_OF_A_MOTION = 20  # moments, for the page's view in space


@dataclass(frozen=True)
class AxisValue:
    """What a case has on one of the axes that its group is multiplied over."""

    axis: str
    value: str
    words: tuple[str, ...] = ()  # options of the program
    meaning: object = field(default=None, compare=False)  # of effects: the EffectSet


@dataclass(frozen=True)
class SweptCase(SceneCase):
    scene: Scene
    group: CaseGroup
    configuration: Configuration
    point: tuple[AxisValue, ...] = ()
    repetition: int = 0
    stride: int = 1  # of a replay
    builder: str = ""  # the case that builds and stores its structures, so that their building is timed once

    def at(self, axis: str) -> AxisValue:
        return next(one for one in self.point if one.axis == axis)

    @property
    def name(self) -> str:
        told = {one.axis: one.value for one in self.point}
        return self.group.named.format(scene=self.scene.key, group=self.group.name, backend=self.configuration.backend,
                                       configuration=self.configuration.label, repetition=self.repetition, **told)

    @property
    def kind(self) -> str:
        return f"{self.group.name} {self.configuration.backend}"

    @property
    def mode(self) -> str:
        """As run.json names it."""
        return {"run": "coupled"}.get(self.group.mode, self.group.mode)

    @property
    def threads(self) -> int:
        return self.configuration.threads

    @property
    def is_judged(self) -> bool:
        return self.group.judged == "always" or (self.group.judged == "first" and self.repetition == 0)

    @property
    def is_timed(self) -> bool:
        """Probes and hard cases are asked for their answers."""
        return self.mode in ("coupled", "replay", "kernels")

    @property
    def wants_machine(self) -> bool:
        """What the machine did meanwhile is read of all processes that have ended."""
        return self.mode == "kernels" or super().wants_machine

    @property
    def recording(self) -> RecordCase:
        """Which a replay reads."""
        return RecordCase(self.scene)

    def structures(self, folders: Folders) -> Path:
        """Folder of the structures of the configuration. In one that is shared they are told apart by their content."""
        own = folders.out_dir / "structures" / self.built_on.key / self.configuration.label
        return folders.structures_dir or own

    @property
    def built_on(self) -> Scene:
        """By the scene's bones, or by what of them its muscle can reach."""
        return self.scene if self.group.stores else self.scene.probed

    @property
    def needs(self) -> tuple[str, ...]:
        recording = (self.recording.name,) if self.group.mode == "replay" else ()
        return recording + ((self.builder,) if self.builder not in ("", self.name) else ())

    @property
    def shares(self) -> tuple[str, ...]:
        """Cases with the same stay on one machine: repetitions, and what loads the structures that another one built."""
        if self.builder:
            return self.built_on.key, self.configuration.label
        return self.group.name, self.scene.key, self.configuration.label, *(one.value for one in self.point)

    @property
    def rest_frames(self) -> int:
        return math.ceil(self.group.rest_s / self.scene.frame_time_s - 1e-9) if self.group.rest_s else 0

    @property
    def frames(self) -> int:
        """That are run or replayed: of a replay every stride-th and the last."""
        frames = self.scene.frames + self.rest_frames
        return -(-frames // self.stride) if self.group.mode == "replay" else frames

    @property
    def steps(self) -> int:
        asked = {one.axis: int(one.value) for one in self.point if one.axis in ("substeps", "iterations")}
        iterations = asked.get("iterations", self.scene.iterations // self.scene.substeps)
        return self.frames * asked.get("substeps", self.scene.substeps) * iterations

    @property
    def snapshot_frames(self) -> list[int]:
        frames = self.scene.frames
        moments = {"rest": {0}, "half": {self.scene.half_flexion_frame}, "full": {self.scene.full_flexion_frame},
                   "middle": {frames // 2}, "end": {frames}, "after_rest": {frames + self.rest_frames},
                   "motion": {round(shown * frames / SHOWN_OF_A_MOTION) for shown in range(SHOWN_OF_A_MOTION)}}
        # Once a case. A group that nobody judges keeps the shapes of its first repetition, too.
        keeps = self.is_judged or (self.group.judged == "never" and self.repetition == 0)
        return sorted(set().union(*(moments[moment] for moment in self.group.snapshots))) if keeps else []

    @property
    def guessed_seconds(self) -> float:
        loads = self.builder not in ("", self.name)
        building = LOADING_STRUCTURES_SECONDS if loads else self.configuration.build_seconds
        if self.group.mode == "kernels":
            return self.group.guessed_s
        if self.group.mode in ("probe", "hard"):
            return LOADING_SECONDS + building + (PROBING_SECONDS if self.group.mode == "probe" else 0.0)
        return LOADING_SECONDS + building + self.guessed_step_seconds

    @property
    def guessed_collision_seconds(self) -> float:
        """Of one step."""
        return 1e-3 * self.configuration.step_ms * self.scene.size * (self.scene.bone_size if self.configuration.is_slow else 1.0)

    @property
    def guessed_step_seconds(self) -> float:
        """A judged replay goes through the steps twice, first undisturbed."""
        a_step, size = self.guessed_collision_seconds, self.scene.size
        if self.group.mode == "replay":
            return self.steps * (2 * a_step + size * JUDGING_SECONDS_A_STEP if self.is_judged else a_step)
        judging = self.frames * JUDGING_SECONDS_A_FRAME if self.is_judged else 0.0
        return self.group.work * (self.steps * (a_step + size * LOOP_SECONDS_A_STEP) + size * judging)

    @property
    def is_too_long(self) -> bool:
        """True for a case that is shown as a row with its estimate and never run."""
        return self.group.mode != "probe" and 0 < self.group.longest_s < self.guessed_seconds

    @property
    def guessed_bytes(self) -> float:
        stored = self.configuration.stored_bytes if self.group.mode == "probe" else 0.0
        return stored + (BYTES_A_JUDGED_RUN if self.snapshot_frames else BYTES_A_RUN)

    def arguments(self, folders: Folders) -> list[str]:
        if self.group.mode == "kernels":
            return [*self._axis_words, *sampling(self.group), *self.group.options]
        if self.group.mode == "hard":
            return ["hard", *self._backend_words(folders)[:-2], "--jobs", "1", *self._axis_words, *self.group.options]
        words = [*self._asked(folders), *self._backend_words(folders), *self.scene.data_arguments(folders)]
        words += [*self._axis_words, *self.group.options]
        if self.group.mode == "probe":  # asks the same points each time, and is the judge itself
            return words
        return [*words, "--repetition", str(self.repetition), *([] if self.is_judged else ["--no-referee"])]

    def output(self, folder: Path) -> list[str]:
        if self.group.mode == "kernels":
            return [f"--benchmark_out={folder / KERNELS_FILE}", "--benchmark_out_format=json"]
        return super().output(folder)

    def record(self) -> dict:
        configuration = self.configuration
        of_kernels = {"group": self.group.name} if self.group.mode == "kernels" else {}
        return {"mode": self.mode, **of_kernels, "scene": self.scene.name, "preset": self.scene.preset,
                "backend": configuration.backend, "parameters": dict(configuration.parameters),
                "threads": configuration.threads, "repetition": self.repetition}

    @property
    def _axis_words(self) -> list[str]:
        return [word for one in self.point for word in one.words]

    def _asked(self, folders: Folders) -> list[str]:
        if self.group.mode == "replay":
            return ["replay", str(folders.out_dir / self.recording.file), "--stride", str(self.stride),
                    "--band-mm", f"{self.group.band_mm:g}"]
        if self.group.mode == "probe":
            return ["probe", self.scene.name, "--points", str(self.group.points),
                    "--band-mm", f"{self.configuration.probe_band_mm:g}"]
        words = ["run", self.scene.word(folders), *self.scene.preset_arguments(), *self._frames_words()]
        if self.snapshot_frames:
            words += ["--snapshots", ",".join(map(str, self.snapshot_frames))]
        return words

    def _frames_words(self) -> list[str]:
        if not self.group.rest_s:
            return self.scene.frames_arguments()
        return ["--frames", str(self.frames), "--loop", f"rest_frames={self.rest_frames}"]

    def _backend_words(self, folders: Folders) -> list[str]:
        configuration = self.configuration
        words = ["--backend", configuration.backend]
        for key, value in configuration.parameters:
            words += ["--param", f"{key}={value}"]
        if self.builder:
            words += ["--param", f"{configuration.storage}={self.structures(folders)}"]
        return [*words, "--threads", str(configuration.threads)]
