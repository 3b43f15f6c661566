"""Ratios of frame times with an interval that says how well the run determines them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

BLOCK_FRAMES = 10  # neighbouring frames are alike; single frames drawn at random would give too narrow an interval


@dataclass
class Ratio:
    value: float
    low: float  # 95 % interval
    high: float
    frames: int

    @staticmethod
    def unknown() -> "Ratio":
        return Ratio(float("nan"), float("nan"), float("nan"), 0)


def median_ratio(times: pd.Series, reference: pd.Series, draws: int = 2000, seed: int = 1) -> Ratio:
    """Median over the frames that both have (matched by index) of times / reference; moving-block bootstrap."""
    both = pd.concat([times, reference], axis=1, join="inner").dropna()
    both = both[both.iloc[:, 1] > 0]
    if both.empty:
        return Ratio.unknown()
    ratios = (both.iloc[:, 0] / both.iloc[:, 1]).to_numpy()
    medians = np.median(_block_draws(ratios, draws, seed), axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return Ratio(float(np.median(ratios)), float(low), float(high), len(ratios))


def _block_draws(values: np.ndarray, draws: int, seed: int) -> np.ndarray:
    length = min(BLOCK_FRAMES, len(values))
    blocks = -(-len(values) // length)
    starts = np.random.default_rng(seed).integers(0, len(values) - length + 1, size=(draws, blocks))
    places = (starts[:, :, None] + np.arange(length)).reshape(draws, -1)[:, : len(values)]
    return values[places]
