"""Medians of few samples, and of ratios of samples that were taken side by side."""

import zlib

import numpy as np
import pandas as pd

from ..results.statistics import DRAWS, PERCENTILES, Estimate, percentile

FEWEST_SAMPLES = 5  # fewer don't tell how well they determine their median


def median(samples: pd.Series) -> Estimate:
    """With a 95 % bootstrap interval; of few samples the interval is not known."""
    values = samples.dropna().to_numpy(dtype=float)
    if not len(values):
        return Estimate.unknown()
    value = float(np.median(values))
    if len(values) < FEWEST_SAMPLES:
        return Estimate(value, float("nan"), float("nan"), len(values))
    random = np.random.default_rng(zlib.crc32(values.tobytes()))
    draws = np.median(random.choice(values, size=(DRAWS, len(values))), axis=1)
    low, high = percentile(draws, PERCENTILES)
    return Estimate(value, float(low), float(high), len(values), draws)


def ratio(above: pd.Series, below: pd.Series) -> Estimate:
    """Of samples with the same index: of the same process, interleaved there."""
    return median(_paired(above, below))


def exact(value: float | None) -> Estimate:
    """Of what does not vary: bytes and counts."""
    return Estimate.unknown() if value is None else Estimate(float(value), float(value), float(value), 1)


def power(times: dict[float, pd.Series]) -> Estimate:
    """Exponent p of times ~ size^p by least squares over the logarithms: for each sample index that all sizes have,
    then the median. Unknown for fewer than three sizes."""
    table = pd.DataFrame(times).dropna()
    if len(times) < 3 or table.empty:
        return Estimate.unknown()
    sizes = np.log(np.array(table.columns, dtype=float))
    slopes = np.polyfit(sizes, np.log(table.to_numpy()).T, 1)[0]
    return median(pd.Series(slopes))


def _paired(above: pd.Series, below: pd.Series) -> pd.Series:
    both = pd.concat([above, below], axis=1, join="inner").dropna()
    return both.iloc[:, 0] / both.iloc[:, 1]
