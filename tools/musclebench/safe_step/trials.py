"""Runs of one scene with longer and shorter steps, and whether they stayed right."""

import json
import subprocess
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import pandas as pd

from ..program.cli import Problem

MOST_VOLUME_ERROR = 0.05
DIVERGED = 3  # exit code of the program
GUARD = "tunnelling_guard"


@dataclass(frozen=True)
class Setting:
    """What steps are tried with."""

    backend: str
    response: str
    guard: bool


@dataclass
class Trials:
    program: Path
    scene: str
    arguments: list[str]  # of every run: preset, data
    folder: Path
    control: str  # a backend that finds nothing
    done: dict[tuple, bool] = field(default_factory=dict)  # by setting, frames and time step

    def usual(self, setting: Setting, frames: int) -> tuple[float, float]:
        """The scene's own time step, s, and the largest turn of a bone in a frame, deg. Raises Problem where the scene
        can't be run so."""
        out = self._run(setting, frames, ["--no-referee"], may_diverge=False)
        angles = pd.read_csv(out / "frames.csv")["angle_deg"]
        turn_deg = float(angles.diff().abs().fillna(angles.abs()).max())
        return json.loads((out / "run.json").read_text())["case"]["loop"]["time_step_s"], turn_deg

    def is_right(self, setting: Setting, frames: int, time_step_s: float | None = None) -> bool:
        """No node on the wrong side of a bone, and the volume kept. `time_step_s`: None is the scene's."""
        key = (setting, frames, time_step_s)
        if key not in self.done:
            step = [] if time_step_s is None else ["--loop", f"time_step_s={time_step_s!r}"]
            out = self._run(setting, frames, step)
            self.done[key] = out is not None and stayed_right(json.loads((out / "run.json").read_text()))
        return self.done[key]

    def _run(self, setting: Setting, frames: int, more: list[str], may_diverge: bool = True) -> Path | None:
        """The folder of its results; nothing for a run that diverged."""
        out = self.folder / "run"
        guard = ["--effect", GUARD] if setting.guard else ["--no-effect", GUARD] if self.has_guard else []
        ended = self._call("--backend", setting.backend, "--response", setting.response, "--frames", str(frames), *guard,
                           *more, "--out", str(out))
        if ended.returncode == DIVERGED and may_diverge:
            return None
        if ended.returncode != 0:
            lines = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
            raise Problem(lines[-1].removeprefix("musclebench: "))
        return out

    @cached_property
    def has_guard(self) -> bool:
        """Of its own, by its scene or preset: only such a scene can go without."""
        return self._call("--backend", self.control, "--frames", "1", "--no-referee", "--no-effect", GUARD,
                          "--out", str(self.folder / "guard")).returncode == 0

    def _call(self, *arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([str(self.program), "run", self.scene, *self.arguments, *arguments, "--force"],
                              capture_output=True, text=True, check=False)


def stayed_right(record: dict) -> bool:
    outcome = record["outcome"]
    return outcome["tunnelled_nodes"] == 0 and (outcome["max_volume_error"] or 0.0) <= MOST_VOLUME_ERROR
