"""What the runs of one set of effects on one scene say: its time, its effects' own times, its outcomes."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..results.disturbance import waits
from ..results.ply import read_ply
from ..results.run_folder import COLLISION_STAGES, Run
from ..results.statistics import Estimate, pooled_median
from ..results.status import MEASURED
from .effect_sets import EffectSet

MS = 1e-6  # of a nanosecond
NAN = float("nan")


@dataclass
class MeasuredSet:
    """Its repetitions; all have the same outcomes."""

    scene: str
    muscle: str
    chosen: EffectSet
    runs: list[Run]

    @property
    def status(self) -> str:
        return next((run.status for run in self.runs if run.status not in MEASURED), self.runs[0].status)

    @property
    def is_measured(self) -> bool:
        return self.status in MEASURED

    @property
    def frame_ms(self) -> Estimate:
        """Median with its interval, for comparisons."""
        return pooled_median([run.timed_frames["frame_ns"] for run in self.runs if len(run.frames)]).scaled(MS)

    # Means: they add up, and hold what an effect does in some frames only.

    @property
    def mean_frame_ms(self) -> float:
        return self._mean(["frame_ns"])

    @property
    def collision_ms(self) -> float:
        """Of detection in bones and response; effects without a column of their own are in it."""
        return self._mean(COLLISION_STAGES)

    def effect_ms(self, effect: str) -> float:
        """Of its own column; NaN where it has none."""
        column = f"{effect}_ns"
        return self._mean([column]) if all(column in run.frames for run in self.runs) else NAN

    def outcome(self, key: str) -> float:
        value = (self.runs[0].record.get("outcome") or {}).get(key)
        return NAN if value is None else float(value)

    @property
    def shape_m(self) -> np.ndarray | None:
        """Vertices at full flexion; None where the run ended before."""
        shots = sorted(self.runs[0].record.get("snapshots") or [], key=lambda shot: shot["frame"])
        return read_ply(self.runs[0].folder / shots[0]["file"]).vertices_m if shots else None

    def _mean(self, columns: list[str]) -> float:
        """Over the frames of all repetitions in which the process did not wait for the processor."""
        frames = [run.timed_frames for run in self.runs if len(run.frames)]
        times = [one[~waits(one["frame_ns"])][columns].sum(axis=1) for one in frames]
        return MS * float(pd.concat(times).mean()) if times else NAN


def rms_mm(shape_m: np.ndarray | None, other_m: np.ndarray | None) -> float:
    if shape_m is None or other_m is None or shape_m.shape != other_m.shape:
        return NAN
    return float(1e3 * np.sqrt(np.mean(np.sum((shape_m - other_m) ** 2, axis=1))))
