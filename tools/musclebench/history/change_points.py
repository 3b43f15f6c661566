"""Where a series changes: E-divisive (Matteson and James, A Nonparametric Approach for Multiple Change Point Analysis of
Multivariate Data, J Am Stat Assoc 2014, arXiv 1306.4933) in one dimension with exponent 1.

A candidate splits a part of the series where the energy distance of what lies before and after it is largest. Whether it
is one is asked in one of two ways: by permutations, as in that paper; or by Student's t-test, as Fleming et al. do (Hunter:
Using Change Point Detection to Hunt for Performance Regressions, ICPE 2023, arXiv 2301.03034), which needs fewer values
after a change, and takes their spread for normal."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import stats

FEWEST = 2  # values on either side of a change: a single one is an outlier
PERMUTATIONS = 499
LEAST_SPREAD = 0.1  # standard deviation of values, at least so much of the smallest difference that counts
WEAK = 10.0  # candidates up to so many times the level are kept until all are found, and then judged again
Chance = Callable[[np.ndarray, int], float]  # p of a split of these values


@dataclass(frozen=True)
class ChangePoint:
    index: int  # of the first value after the change
    difference: float  # mean after it, up to the next, minus mean before it, from the last
    low: float  # 95 % interval, by Student's t
    high: float
    chance: float  # p: how often chance alone would make such a change somewhere in this part of the series


def change_points(values: np.ndarray, level: float = 0.01, smallest: float = 0.0,
                  chance: Chance | None = None) -> list[ChangePoint]:
    """In their order. `level`: the largest p; `smallest`: the smallest difference, either way. `chance`:
    Student's, unless told."""
    values, is_student = np.asarray(values, dtype=float), chance is None
    chance = chance or (lambda part, split: student_chance(part, split, LEAST_SPREAD * smallest))
    found = _candidates(values, 0, level * (WEAK if is_student else 1), chance, is_student)
    while found:
        points = [_point(values, before, at, after, chance) for before, at, after in _parts(found, len(values))]
        # The most doubtful goes first: the parts on both of its sides become one, which may make the others surer.
        doubtful = [point for point in points if point.chance > level or abs(point.difference) < smallest]
        if not doubtful:
            return points
        found.remove(max(doubtful, key=lambda point: point.chance).index)
    return []


def best_split(values: np.ndarray) -> tuple[int, int, float]:
    """(t, k, q): values[:t] and values[t:k] are farthest apart, by the statistic Q of the paper; q < 0: too few values.
    Where the series goes back after k, looking no farther shows the first change more clearly."""
    t, k, q = _statistics(values)
    best = int(np.argmax(q)) if len(q) else -1
    return (int(t[best]), int(k[best]), float(q[best])) if best >= 0 else (0, 0, -1.0)


def permutation_chance(permutations: int = PERMUTATIONS, seed: int = 1) -> Chance:
    """Share of the permutations of the values with a Q as large anywhere, the values as they are among them."""
    def chance(values: np.ndarray, split: int) -> float:
        random, (_, _, q) = np.random.default_rng(seed), best_split(values)
        if q < 0:
            return 1.0
        as_large = sum(best_split(random.permutation(values))[2] >= q for _ in range(permutations))
        return (1 + as_large) / (1 + permutations)
    return chance


def student_chance(values: np.ndarray, split: int, least_spread: float = 0.0) -> float:
    """Two-sided p of Student's test between both sides, times the number of places at which one could have split
    (Bonferroni), which keeps the level although the best place was chosen. `least_spread`: a smaller standard deviation is
    the luck of a few values that are alike."""
    before, after = values[:split], values[split:]
    degrees, places = len(values) - 2, max(1, len(values) - 2 * FEWEST + 1)
    spread = np.sqrt(max(_variance(before, after), least_spread**2) * (1 / len(before) + 1 / len(after)))
    difference = abs(before.mean() - after.mean())
    if spread == 0:
        return 0.0 if difference > 0 else 1.0
    return float(min(1.0, places * 2 * stats.t.sf(difference / spread, degrees)))


def _variance(before: np.ndarray, after: np.ndarray) -> float:
    """Of both sides about their means."""
    return (np.var(before) * len(before) + np.var(after) * len(after)) / max(1, len(before) + len(after) - 2)


def _candidates(values: np.ndarray, first: int, level: float, chance: Chance, is_student: bool) -> list[int]:
    split, end, q = best_split(values)
    if q <= 0 or chance(values[:end] if is_student else values, split) > level:
        return []
    return [*_candidates(values[:split], first, level, chance, is_student), first + split,
            *_candidates(values[split:], first + split, level, chance, is_student)]


def _parts(found: list[int], count: int) -> list[tuple[int, int, int]]:
    ends = [0, *found, count]
    return list(zip(ends, ends[1:], ends[2:]))


def _point(values: np.ndarray, first: int, at: int, end: int, chance: Chance) -> ChangePoint:
    before, after = values[first:at], values[at:end]
    difference, degrees = float(after.mean() - before.mean()), max(1, end - first - 2)
    half = stats.t.ppf(0.975, degrees) * np.sqrt(_variance(before, after) * (1 / len(before) + 1 / len(after)))
    return ChangePoint(at, difference, difference - half, difference + half, chance(values[first:end], at - first))


def _statistics(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of all splits t and ends k the statistic Q = m n / (m + n) E, with the energy distance E of m values before and n
    after: twice their mean distance, minus the mean distances inside of both."""
    count = len(values)
    t, k = _splits(count)
    sums = np.zeros((count + 1, count + 1))
    sums[1:, 1:] = np.abs(values[:, None] - values[None, :]).cumsum(axis=0).cumsum(axis=1)
    m, n = t, k - t
    first, between = sums[t, t], sums[t, k] - sums[t, t]
    second = sums[k, k] - sums[t, k] - sums[k, t] + sums[t, t]
    energy = 2 * between / (m * n) - first / (m * (m - 1)) - second / (n * (n - 1))
    return t, k, m * n / (m + n) * energy


@cache
def _splits(count: int) -> tuple[np.ndarray, np.ndarray]:
    """All splits t and ends k with enough values on either side."""
    t, k = (each.ravel() for each in np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij"))
    fits = (t >= FEWEST) & (k - t >= FEWEST)
    return t[fits], k[fits]
