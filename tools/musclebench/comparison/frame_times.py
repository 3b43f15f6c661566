"""The time of a frame of each run of a case, as if nothing had interrupted any of its frames."""

import pandas as pd

from ..results.run_folder import Run
from .metrics import FEWEST_FRAMES, quiet_frames

COLUMNS = ("collision_ns", "frame_ns")


def frame_times(runs: list[Run], column: str) -> list[float | None]:
    """Frames of a motion differ, and each run was interrupted in others: a median over those that are left would be that of
    other frames in each run. So each quiet frame is compared with the same frame of all runs, and the run's median ratio
    is told for the mean frame. None where a run has too few quiet frames. Comparable are only runs that were given together."""
    quiet = [_quiet(run, column) for run in runs]
    usual = pd.concat(quiet, axis=1).median(axis=1) if quiet else pd.Series(dtype=float)
    usual = usual[usual > 0]
    return [float((times / usual).median() * usual.mean()) if len(times) >= FEWEST_FRAMES and len(usual) else None for times in quiet]


def _quiet(run: Run, column: str) -> pd.Series:
    frames = quiet_frames(run)
    return frames[column].dropna() if column in frames else pd.Series(dtype=float)
