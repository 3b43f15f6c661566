"""Change points of synthetic series: known steps are found, drift and outliers are not taken for steps more often than
the level says."""

import numpy as np
import pytest

from musclebench.history.change_points import (
    FEWEST, best_split, change_points, permutation_chance, student_chance,
)

WAYS = {"student": None, "permutations": permutation_chance(199)}


def noise(seed: int, count: int, spread: float = 0.01) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, spread, count)


def energy_q(values, t: int, k: int) -> float:
    """The statistic as the paper writes it, pair by pair."""
    x, y = values[:t], values[t:k]
    m, n = len(x), len(y)
    between = sum(abs(a - b) for a in x for b in y) * 2 / (m * n)
    inside = [sum(abs(part[i] - part[j]) for i in range(len(part)) for j in range(i)) / (len(part) * (len(part) - 1) / 2)
              for part in (x, y)]
    return m * n / (m + n) * (between - sum(inside))


def test_the_statistic_is_that_of_the_paper():
    values = noise(3, 9, 1.0)
    splits = {(t, k): energy_q(values, t, k) for k in range(10) for t in range(FEWEST, k - FEWEST + 1)}
    t, k, q = best_split(values)
    assert q == pytest.approx(max(splits.values())) and splits[t, k] == pytest.approx(q)


@pytest.mark.parametrize("way", WAYS)
def test_known_steps_are_found_where_they_are(way):
    values = noise(1, 60) + np.repeat([0.0, 0.1, 0.04], 20)
    points = change_points(values, 0.01, chance=WAYS[way])
    assert [point.index for point in points] == [20, 40]
    assert [point.difference for point in points] == pytest.approx([0.1, -0.06], abs=0.01)
    assert all(point.low < true < point.high for point, true in zip(points, (0.1, -0.06)))


def test_a_step_and_the_way_back_are_two_points():
    values = noise(2, 30)
    values[12:18] += 0.1
    assert [point.index for point in change_points(values)] == [12, 18]


def test_three_values_after_a_step_suffice():
    found = sum(bool(change_points(np.append(noise(seed, 14, 0.02), noise(1000 + seed, 3, 0.02) + 0.1), 0.001))
                for seed in range(50))
    assert found >= 45


@pytest.mark.parametrize(("way", "trials"), [("student", 400), ("permutations", 100)])
def test_noise_alarms_no_more_often_than_the_level(way, trials):
    alarms = sum(bool(change_points(noise(seed, 30), 0.01, chance=WAYS[way])) for seed in range(trials))
    assert alarms <= 0.03 * trials


def test_heavy_tails_alarm_rarely():
    alarms = sum(bool(change_points(0.01 * np.random.default_rng(seed).standard_t(3, 30), 0.01, smallest=0.05))
                 for seed in range(300))
    assert alarms <= 3


def test_an_outlier_is_no_step():
    values = noise(5, 30)
    values[[10, 29]] += 0.5
    assert change_points(values) == []


def test_a_drift_below_the_smallest_difference_is_no_step():
    values = noise(6, 40) + np.linspace(0, 0.04, 40)
    assert change_points(values, smallest=0.05) == []
    assert change_points(values)  # but it is seen where every difference counts


def test_a_few_values_that_are_alike_by_luck_are_no_evidence():
    values = np.array([0.0, 1e-6, 0.06, 0.06 + 1e-6])
    assert student_chance(values, 2) < 1e-6 and change_points(values, 1e-4)
    assert not change_points(values, 1e-4, smallest=0.05)


def test_what_does_not_vary_changes_surely():
    (point,) = change_points(np.repeat([1.0, 2.0], [5, 2]))
    assert (point.index, point.difference, point.chance) == (5, 1.0, 0.0)
    assert change_points(np.ones(7)) == [] and change_points(np.array([1.0, 2.0])) == []
