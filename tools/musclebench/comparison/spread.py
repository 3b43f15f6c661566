"""How the frames of a case are spread: over one process, and from process to process."""

from dataclasses import dataclass

import pandas as pd

from ..results import samples as statistics
from ..results.disturbance import disturbance
from ..results.statistics import Estimate, frame_tail
from .metrics import quiet_frames
from .result_set import Sample


@dataclass(frozen=True)
class Spread:
    """Of times in ns; warm-up frames are left out."""

    case: str
    runs: int
    warm_up_frames: int  # of each run
    median: Estimate  # over the runs, of the medians of their frames that nothing interrupted
    p95: float  # of all frames
    p99: float
    variation: float  # of the medians of the runs
    interrupted: float  # share of the frames
    disturbed: int  # runs
    settings: dict  # of the machine: core, nice, governor, turbo, smt


def spread_of(case: str, samples: list[Sample], metric: str = "frame_ns") -> Spread | None:
    timed = [sample for sample in samples if metric in sample.values]
    if not timed:
        return None
    by_run = [sample.run.timed_frames[metric] for sample in timed]
    frames = sum(int(times.notna().sum()) for times in by_run)
    quiet = sum(len(quiet_frames(sample.run)) for sample in timed)
    medians = pd.Series([sample.values[metric] for sample in timed])
    p95, p99 = frame_tail(by_run)
    first = timed[0]
    return Spread(case, len(timed), first.run.warm_up_count, statistics.median(medians), p95, p99, statistics.variation(medians),
                  1 - quiet / max(1, frames), sum(bool(disturbance(sample.run.record)) for sample in timed),
                  first.measured.get("settings", {}))
