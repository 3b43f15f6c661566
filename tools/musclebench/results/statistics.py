"""Medians and ratios of frame times with an interval that says how well the runs determine them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

# Of the motion: neighbouring frames are alike, and single frames drawn at random would give too narrow an interval.
BLOCK_FRAMES = 10
FEWEST_FRAMES = 6  # fewer don't tell how well they determine their median
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


def pooled_median(repetitions: list[pd.Series], draws: int = DRAWS) -> Estimate:
    """Median over the frames (index) that all repetitions have, of all repetitions together. The bootstrap draws
    repetitions, and in each of them blocks of neighbouring frames (circular blocks, Politis and Romano 1992), so that
    its interval holds what differs from process to process as well as from frame to frame. Of few frames the interval
    is not known."""
    if not repetitions:
        return Estimate.unknown()
    table = pd.concat(repetitions, axis=1, join="inner").dropna().sort_index()
    if not table.size:
        return Estimate.unknown()
    return bootstrap_median(table.to_numpy(dtype=float).T, _block_length(table.index), FEWEST_FRAMES, draws)


def paired_ratio(times: dict[int, pd.Series], reference: dict[int, pd.Series], draws: int = DRAWS) -> Estimate:
    """Median of times / reference, both {repetition: values by frame}: matched by frame, and by repetition where the
    reference has it (interleaved repetitions saw the same state of the machine), else by its median."""
    if not times or not reference:
        return Estimate.unknown()
    usual = pd.concat(reference.values(), axis=1).median(axis=1)
    ratios = [_ratio(values, reference.get(repetition, usual)) for repetition, values in times.items()]
    return pooled_median(ratios, draws)


def median_ratio(times: pd.Series, reference: pd.Series, draws: int = DRAWS) -> Estimate:
    """Median over the frames that both have (matched by index) of times / reference; bootstrap of blocks."""
    return pooled_median([_ratio(times, reference)], draws)


def total(parts: list[Estimate]) -> Estimate:
    """Sum of independent estimates."""
    return _combined(sum(part.value for part in parts), sum((part.draws for part in parts), np.zeros(1)), parts)


def quotient(above: Estimate, below: Estimate) -> Estimate:
    """Of independent estimates."""
    if not below.value > 0 or np.any(below.draws <= 0):
        return Estimate.unknown()
    return _combined(above.value / below.value, above.draws / below.draws, [above, below])


def percentile(values: Any, percents: Any) -> Any:
    """By the nearest rank, as the program takes them: always one of the values."""
    return np.percentile(values, percents, method="inverted_cdf")


def frame_tail(by_run: list[pd.Series]) -> tuple[float, float]:
    """95th and 99th percentile of a frame's time, over all frames of all runs."""
    p95, p99 = percentile(pd.concat(by_run).dropna(), (95, 99))
    return float(p95), float(p99)


def _combined(value: float, draws: np.ndarray, parts: list[Estimate]) -> Estimate:
    if np.isnan(value) or not np.size(draws):
        return Estimate.unknown()
    low, high = percentile(draws, PERCENTILES)
    return Estimate(value, float(low), float(high), min(part.frames for part in parts), draws)


def _ratio(times: pd.Series, reference: pd.Series) -> pd.Series:
    both = pd.concat([times, reference], axis=1, join="inner").dropna()
    both = both[both.iloc[:, 1] > 0]
    return both.iloc[:, 0] / both.iloc[:, 1]


def _block_length(frames: pd.Index) -> int:
    """In values, which may be some of the motion's frames only."""
    spacing = np.median(np.diff(frames)) if len(frames) > 1 else 1.0
    return int(max(1, round(BLOCK_FRAMES / max(1.0, spacing))))


def bootstrap_median(values: np.ndarray, length: int, fewest: int, draws: int = DRAWS) -> Estimate:
    """`values` has one row a repetition; blocks of `length` of a row are drawn, at most a third of it. Of fewer than `fewest`
    in a row the interval is not known. Of one repetition it is to the last bit that of core/measure/block_bootstrap.hpp."""
    repetitions, frames = values.shape
    value = float(np.median(values))
    if frames < fewest:
        return Estimate(value, float("nan"), float("nan"), frames, np.full(draws, np.nan))
    length = max(1, min(length, frames // 3))
    blocks = -(-frames // length)
    # The values seed the draws: estimates of different values are drawn independently, and each always in the same way.
    seed = np.bitwise_xor.reduce(_stream(np.ascontiguousarray(values).view(np.uint64).ravel(), values.size))
    random = _stream(seed, repetitions * draws * (blocks + 1))
    starts, chosen = np.split(random, [repetitions * draws * blocks])
    starts = (starts % np.uint64(frames)).astype(np.int64).reshape(repetitions, draws, blocks)
    chosen = (chosen % np.uint64(repetitions)).astype(np.int64).reshape(repetitions, draws, 1)
    drawn = np.concatenate([_drawn(values, *part, length) for part in zip(starts, chosen)], axis=1)
    medians = np.median(drawn, axis=1)
    low, high = percentile(medians, PERCENTILES)
    return Estimate(value, float(low), float(high), frames, medians)


def _drawn(values: np.ndarray, starts: np.ndarray, chosen: np.ndarray, length: int) -> np.ndarray:
    """One repetition a row, and of it blocks of frames; the first frame follows on the last."""
    frames = values.shape[1]
    indices = ((starts[:, :, None] + np.arange(length)) % frames).reshape(len(starts), -1)[:, :frames]
    return values[chosen, indices]


def _stream(seed: np.ndarray, count: int) -> np.ndarray:
    """SplitMix64 (Steele, Lea and Flood 2014), the first numbers of a stream; of a seed each, its own."""
    bits = seed + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return bits ^ (bits >> np.uint64(31))
