"""How far the fibre lengths and moment arms of two runs are apart."""

import numpy as np
import pandas as pd

from .run_folder import Run

SLOWEST_SHARE = 0.25
RULE = (
    "Lengths and moment arms (dL / d(angle)) are those of the mean over the muscle's fibres, in the frames in which the "
    f"joint turns at least {SLOWEST_SHARE:g} times as fast as at its fastest: where it turns back a slope over the angle "
    "tells little."
)
COMPARED = {"length": "mean_length_m", "arm": "mean_moment_arm_m"}


def arm_differences(run: Run, reference: Run) -> dict[str, float]:
    """{length_rms_mm, length_max_mm, arm_rms_mm, arm_max_mm, arm_percent} over the frames of all muscles; empty where one of
    the runs followed no fibres or the joint did not turn. Percent of the reference's arm, RMS both."""
    if run.fibres.empty or reference.fibres.empty:
        return {}
    both = _course(run).join(_course(reference), rsuffix="_reference", how="inner").dropna()
    turning = both[_is_turning(both["angle_deg"])]
    if turning.empty:
        return {}
    found: dict[str, float] = {}
    for name, column in COMPARED.items():
        off_mm = 1e3 * (turning[column] - turning[f"{column}_reference"])
        found |= {f"{name}_rms_mm": float(np.sqrt(np.mean(off_mm**2))), f"{name}_max_mm": float(off_mm.abs().max())}
    usual_mm = 1e3 * float(np.sqrt(np.mean(turning[f"{COMPARED['arm']}_reference"] ** 2)))
    return found | {"arm_percent": 100 * found["arm_rms_mm"] / usual_mm if usual_mm > 0 else float("nan")}


def _course(run: Run) -> pd.DataFrame:
    return run.fibres.set_index(["muscle", "frame"])[["angle_deg", *COMPARED.values()]]


def _is_turning(angles_deg: pd.Series) -> pd.Series:
    """Of each muscle's frames; the first has no step before it."""
    steps = angles_deg.groupby(level="muscle").diff().abs()
    return steps >= SLOWEST_SHARE * steps.max()
