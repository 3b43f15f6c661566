"""Tests of few samples: p-values of published tables, and the rate of false alarms."""

import math

import numpy as np
import pandas as pd
import pytest

from musclebench.results import samples


def series(*values) -> pd.Series:
    return pd.Series(values, dtype=float)


def test_u_is_exact_where_nothing_is_tied():
    # Of 20 orders of three and three, two are as extreme.
    assert samples.mann_whitney(series(1, 2, 3), series(4, 5, 6)) == pytest.approx(2 / 20)


def test_pairs_show_what_drift_and_a_disturbed_pair_hide():
    random = np.random.default_rng(5)
    below = pd.Series(np.linspace(1, 2, 10) * np.exp(random.normal(0, 0.01, 10)))
    above = 1.1 * below * np.exp(random.normal(0, 0.01, 10))
    above[3] *= 3
    assert samples.trimmed_pairs(above, below) < 1e-4 and samples.mann_whitney(above, below) > 0.1
    assert samples.trimmed_pairs(below, above) == pytest.approx(samples.trimmed_pairs(above, below))
    assert samples.trimmed_pairs(above[:4], below[:4]) == 1.0 and samples.trimmed_pairs(above - 1.5, below) == 1.0
    assert samples.trimmed_pairs(below, below) == 1.0


def test_yuens_test_has_its_level():
    """Of pairs with heavy tails that do not differ."""
    random = np.random.default_rng(6)
    chances = [samples.trimmed_pairs(pd.Series(np.exp(0.05 * random.standard_t(3, 12))), pd.Series(np.exp(0.05 * random.standard_t(3, 12))))
               for _ in range(1000)]
    assert 0.02 < np.mean(np.array(chances) < 0.05) < 0.06 and np.mean(np.array(chances) < 0.001) <= 0.002


def test_what_does_not_differ_can_not_alarm():
    assert samples.mann_whitney(series(1, 1, 1), series(1, 1)) == 1.0
    assert samples.mann_whitney(series(), series(1, 2)) == 1.0


def test_holm_holds_the_chance_of_any_alarm():
    assert samples.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert samples.holm([]) == []
    random = np.random.default_rng(1)
    families = [[samples.mann_whitney(pd.Series(random.normal(size=8)), pd.Series(random.normal(size=8)))
                 for _ in range(5)] for _ in range(200)]
    assert sum(min(samples.holm(family)) < 0.05 for family in families) <= 20
    assert sum(min(family) < 0.05 for family in families) > 20


def test_variation_is_relative():
    assert samples.variation(series(9, 10, 11)) == pytest.approx(0.1)
    assert math.isnan(samples.variation(series(1)))


def test_a_ratio_of_independent_samples_has_an_interval():
    random = np.random.default_rng(2)
    above, below = (pd.Series(random.normal(mean, 0.1, 30)) for mean in (2.0, 1.0))
    ratio = samples.unpaired_ratio(above, below)
    assert ratio.low < 2.0 < ratio.high and ratio.high - ratio.low < 0.4
