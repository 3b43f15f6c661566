"""Published moment arms of the data folder, in the sign of this program: positive where a muscle grows longer in flexion."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ..program.cli import Problem

FOLDER = "moment_arms"
SAME_HIP = "modenese_kohout_2020.csv"
FINITE_ELEMENTS = "blemker_delp_2005.csv"
NEAR_DEG = 2.0  # slopes end half a step before the lengths that they are of
FLEXORS = ("iliacus", "psoas")  # whose published arms are positive in flexion
# File, columns (whose mean is taken) and sign of single curves.
MEASURED = {
    "gluteus_maximus": ("nemeth_ohlsen_1985.csv", ["gluteus_maximus_mm"], 1, "Nemeth and Ohlsen 1985"),
    "gluteus_medius": ("dostal_1986.csv", ["gluteus_medius_flexion_mm"], -1, "Dostal et al. 1986"),
    "psoas": ("arnold_2000.csv", [f"psoas_subject_{subject}_mm" for subject in (1, 2, 3)], -1, "Arnold et al. 2000, mean of three"),
}


@dataclass(frozen=True)
class Curve:
    """A figure over the angle; NaN beyond the angles that were published, but for NEAR_DEG."""

    angles_deg: np.ndarray
    values_mm: np.ndarray

    def at(self, angle_deg: float) -> float:
        first, last = self.angles_deg[0], self.angles_deg[-1]
        is_known = first - NEAR_DEG <= angle_deg <= last + NEAR_DEG
        return float(np.interp(angle_deg, self.angles_deg, self.values_mm)) if is_known else float("nan")


@dataclass(frozen=True)
class Published:
    """Of one muscle. Curves that nobody published are None."""

    same_hip: dict[str, Curve] | None = None  # min, p10, mean, p90, max over the fibres
    finite_elements: dict[str, Curve] | None = None  # lower, upper
    measured: Curve | None = None
    measured_by: str = ""


def read_published(data_dir: Path | None) -> dict[str, Published]:
    """By muscle; empty without data. Raises Problem for a file that is not what it should be."""
    if data_dir is None or not (data_dir / FOLDER).is_dir():
        return {}
    folder = data_dir / FOLDER
    same_hip = _read(folder / SAME_HIP, ["muscle", "hip_flexion_deg", "min_mm", "p10_mm", "mean_mm", "p90_mm", "max_mm"])
    finite = _read(folder / FINITE_ELEMENTS, ["muscle", "hip_flexion_deg", "bound", "moment_arm_mm"])
    muscles = dict.fromkeys([*same_hip["muscle"], *finite["muscle"]])
    return {muscle: Published(_same_hip(same_hip[same_hip["muscle"] == muscle]),
                              _bounds(finite[finite["muscle"] == muscle], -1 if muscle in FLEXORS else 1),
                              *_measured(folder, muscle)) for muscle in muscles}


def _read(path: Path, columns: list[str]) -> pd.DataFrame:
    try:
        rows = pd.read_csv(path)
    except (OSError, ValueError) as problem:
        raise Problem(f"{path}: can't be read ({problem}); restore it from the data set") from None
    missing = [column for column in columns if column not in rows.columns]
    if missing:
        raise Problem(f"{path}: lacks the columns {', '.join(missing)}; restore it from the data set")
    return rows


def _curve(angles, values) -> Curve:
    order = np.argsort(np.asarray(angles, dtype=float), kind="stable")
    return Curve(np.asarray(angles, dtype=float)[order], np.asarray(values, dtype=float)[order])


def _same_hip(rows: pd.DataFrame) -> dict[str, Curve] | None:
    if rows.empty:
        return None
    return {name: _curve(rows["hip_flexion_deg"], rows[f"{name}_mm"]) for name in ("min", "p10", "mean", "p90", "max")}


def _bounds(rows: pd.DataFrame, sign: int) -> dict[str, Curve] | None:
    if rows.empty:
        return None
    curves = [_curve(part["hip_flexion_deg"], sign * part["moment_arm_mm"]) for _, part in rows.groupby("bound")]
    lower, upper = sorted(curves, key=lambda curve: np.nanmean(curve.values_mm))
    return {"lower": lower, "upper": upper}


def _measured(folder: Path, muscle: str) -> tuple[Curve | None, str]:
    if muscle not in MEASURED:
        return None, ""
    name, columns, sign, source = MEASURED[muscle]
    rows = _read(folder / name, ["hip_flexion_deg", *columns])
    return _curve(rows["hip_flexion_deg"], sign * rows[columns].mean(axis=1)), source
