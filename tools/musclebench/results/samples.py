"""Medians, variation and tests of few samples, such as one a process; ratios of samples that were taken side by side."""

import numpy as np
import pandas as pd
from scipy import stats

from .statistics import Estimate, bootstrap_median, quotient

FEWEST_SAMPLES = 5  # fewer don't tell how well they determine their median
EXACT_SAMPLES = 50
TRIMMED = 0.2  # of the pairs, at either end


def median(samples: pd.Series) -> Estimate:
    """With a 95 % bootstrap interval; of few samples the interval is not known."""
    values = samples.dropna().to_numpy(dtype=float)
    if not len(values):
        return Estimate.unknown()
    return bootstrap_median(values[None, :], 1, FEWEST_SAMPLES)


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


def unpaired_ratio(above: pd.Series, below: pd.Series) -> Estimate:
    """Of the medians of independent samples."""
    return quotient(median(above), median(below))


def variation(samples: pd.Series) -> float:
    """Coefficient of variation: standard deviation over mean; unknown for fewer than two samples."""
    values = samples.dropna().to_numpy(dtype=float)
    return float(np.std(values, ddof=1) / np.mean(values)) if len(values) > 1 and np.mean(values) > 0 else float("nan")


def mann_whitney(above: pd.Series, below: pd.Series) -> float:
    """Two-sided p of Mann and Whitney's U test (1947): that the one tends to be larger than the other. Exact for up to
    EXACT_SAMPLES without ties, else by the normal approximation, corrected for ties. 1 where a side has no sample."""
    sides = [side.dropna().to_numpy(dtype=float) for side in (above, below)]
    together = np.concatenate(sides)
    if min(map(len, sides)) == 0 or np.ptp(together) == 0:
        return 1.0
    is_exact = len(np.unique(together)) == len(together) and max(map(len, sides)) <= EXACT_SAMPLES
    return float(stats.mannwhitneyu(*sides, alternative="two-sided", method="exact" if is_exact else "asymptotic").pvalue)


def trimmed_pairs(above: pd.Series, below: pd.Series) -> float:
    """Two-sided p of Yuen's test (1974) on the logarithms of the ratios of pairs that were taken side by side: Student's
    without the fifth at either end, whose spread is that of those ends drawn in. What drifts is in both of a pair, and a pair
    that something disturbed does not count. 1 for few pairs, and where a value is not positive."""
    ratios = np.sort(_paired(above, below).to_numpy(dtype=float))
    count, cut = len(ratios), int(TRIMMED * len(ratios))
    if count < FEWEST_SAMPLES or not (ratios[0] > 0 and np.isfinite(ratios[-1])):
        return 1.0
    logarithms = np.log(ratios)
    mean = logarithms[cut:count - cut].mean()
    drawn_in = np.clip(logarithms, logarithms[cut], logarithms[count - cut - 1])
    error = np.std(drawn_in, ddof=1) / ((1 - 2 * TRIMMED) * np.sqrt(count))
    if error == 0:
        return 1.0 if mean == 0 else 0.0
    return float(2 * stats.t.sf(abs(mean) / error, count - 2 * cut - 1))


def holm(chances: list[float]) -> list[float]:
    """Adjusted p of Holm's step-down procedure (1979): below a, the chance of any false alarm among all of them is at
    most a, however they depend on each other."""
    order, adjusted, largest = np.argsort(chances), [1.0] * len(chances), 0.0
    for rank, index in enumerate(order):
        largest = max(largest, min(1.0, (len(chances) - rank) * chances[index]))
        adjusted[index] = largest
    return adjusted
