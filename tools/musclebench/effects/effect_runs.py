"""What the runs of one set of effects on one scene say: its time, its effects' own times, its outcomes."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

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
        return self._median(["frame_ns"])

    @property
    def collision_ms(self) -> float:
        """Of detection in bones and response; effects without a column of their own are in it."""
        return self._median(COLLISION_STAGES).value

    def effect_ms(self, effect: str) -> float:
        """Of its own column; NaN where it has none."""
        column = f"{effect}_ns"
        return self._median([column]).value if all(column in run.frames for run in self.runs) else NAN

    def outcome(self, key: str) -> float:
        value = (self.runs[0].record.get("outcome") or {}).get(key)
        return NAN if value is None else float(value)

    @property
    def shape_m(self) -> np.ndarray | None:
        """Vertices at full flexion; None where the run ended before."""
        shots = sorted(self.runs[0].record.get("snapshots") or [], key=lambda shot: shot["frame"])
        return read_ply(self.runs[0].folder / shots[0]["file"]).vertices_m if shots else None

    def _median(self, columns: list[str]) -> Estimate:
        times: list[pd.Series] = [run.timed_frames[columns].sum(axis=1) for run in self.runs if len(run.frames)]
        return pooled_median(times).scaled(MS)


def rms_mm(shape_m: np.ndarray | None, other_m: np.ndarray | None) -> float:
    if shape_m is None or other_m is None or shape_m.shape != other_m.shape:
        return NAN
    return float(1e3 * np.sqrt(np.mean(np.sum((shape_m - other_m) ** 2, axis=1))))
