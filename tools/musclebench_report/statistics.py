"""Medians and ratios of frame times with an interval that says how well the runs determine them."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

BLOCK_FRAMES = 10  # neighbouring frames are alike; single frames drawn at random would give too narrow an interval
DRAWS = 2000
PERCENTILES = [2.5, 97.5]


@dataclass
class Estimate:
    value: float
    low: float  # 95 % interval
    high: float
    frames: int
    draws: np.ndarray = field(default_factory=lambda: np.empty(0), repr=False)  # the bootstrap's values

    @staticmethod
    def unknown() -> "Estimate":
        return Estimate(float("nan"), float("nan"), float("nan"), 0)

    def scaled(self, factor: float) -> "Estimate":
        return Estimate(factor * self.value, factor * self.low, factor * self.high, self.frames, factor * self.draws)


def pooled_median(repetitions: list[pd.Series], draws: int = DRAWS, seed: int = 1) -> Estimate:
    """Median over the frames (index) that all repetitions have, of all repetitions together. The bootstrap draws
    repetitions, and in each of them blocks of neighbouring frames (Künsch 1989), so that its interval holds what
    differs from process to process as well as from frame to frame."""
    if not repetitions:
        return Estimate.unknown()
    values = pd.concat(repetitions, axis=1, join="inner").dropna().to_numpy().T
    return _bootstrap_median(values, draws, seed) if values.size else Estimate.unknown()


def paired_ratio(times: dict[int, pd.Series], reference: dict[int, pd.Series], draws: int = DRAWS) -> Estimate:
    """Median of times / reference, both {repetition: values by frame}: matched by frame, and by repetition where the
    reference has it (interleaved repetitions saw the same state of the machine), else by its median."""
    if not times or not reference:
        return Estimate.unknown()
    usual = pd.concat(reference.values(), axis=1).median(axis=1)
    ratios = [_ratio(values, reference.get(repetition, usual)) for repetition, values in times.items()]
    return pooled_median(ratios, draws)


def median_ratio(times: pd.Series, reference: pd.Series, draws: int = DRAWS, seed: int = 1) -> Estimate:
    """Median over the frames that both have (matched by index) of times / reference; moving-block bootstrap."""
    return pooled_median([_ratio(times, reference)], draws, seed)


def total(parts: list[Estimate]) -> Estimate:
    """Sum of independent estimates."""
    return _combined(sum(part.value for part in parts), sum(part.draws for part in parts), parts)


def quotient(above: Estimate, below: Estimate) -> Estimate:
    """Of independent estimates."""
    if not below.value > 0 or not np.all(below.draws > 0):
        return Estimate.unknown()
    return _combined(above.value / below.value, above.draws / below.draws, [above, below])


def _combined(value: float, draws: np.ndarray, parts: list[Estimate]) -> Estimate:
    if np.isnan(value) or not np.size(draws):
        return Estimate.unknown()
    low, high = np.percentile(draws, PERCENTILES)
    return Estimate(value, float(low), float(high), min(part.frames for part in parts), draws)


def _ratio(times: pd.Series, reference: pd.Series) -> pd.Series:
    both = pd.concat([times, reference], axis=1, join="inner").dropna()
    both = both[both.iloc[:, 1] > 0]
    return both.iloc[:, 0] / both.iloc[:, 1]


def _bootstrap_median(values: np.ndarray, draws: int, seed: int) -> Estimate:
    """`values` has one row a repetition."""
    random = np.random.default_rng(seed)
    parts = [_block_draws(values, draws, random) for _ in values]
    medians = np.median(np.concatenate(parts, axis=1), axis=1)
    low, high = np.percentile(medians, PERCENTILES)
    return Estimate(float(np.median(values)), float(low), float(high), values.shape[1], medians)


def _block_draws(values: np.ndarray, draws: int, random: np.random.Generator) -> np.ndarray:
    """One repetition drawn a row, and of it blocks of frames."""
    repetitions, frames = values.shape
    length = min(BLOCK_FRAMES, frames)
    blocks = -(-frames // length)
    starts = random.integers(0, frames - length + 1, size=(draws, blocks))
    places = (starts[:, :, None] + np.arange(length)).reshape(draws, -1)[:, :frames]
    chosen = random.integers(0, repetitions, size=(draws, 1)) if repetitions > 1 else np.zeros((draws, 1), dtype=int)
    return values[chosen, places]
