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
