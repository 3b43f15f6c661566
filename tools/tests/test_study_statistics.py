"""What few frames can't tell, and how the price list chooses among equals."""

import math

import numpy as np
import pandas as pd

from musclebench_report.accuracy import prices
from musclebench_report.statistics import pooled_median


def times(frames, stride=16):
    values = np.random.default_rng(3).lognormal(size=frames)
    return pd.Series(values, index=stride * np.arange(1, frames + 1))


def test_of_few_frames_the_interval_is_not_known():
    estimate = pooled_median([times(5)])
    assert estimate.value == times(5).median() and math.isnan(estimate.low) and math.isnan(estimate.high)


def test_of_twenty_frames_the_interval_has_a_width_and_holds_its_median():
    estimate = pooled_median([times(20)])
    assert estimate.low < estimate.value < estimate.high


def test_of_equally_fast_configurations_the_smallest_is_the_cheapest():
    def offer(name, low, time, high, megabytes):
        return {"configuration": name, "time_ms_low": low, "time_ms": time, "time_ms_high": high,
                "structure_mb": megabytes}

    fast, small, slow = offer("fast", 0.9, 1.0, 1.1, 240), offer("small", 1.0, 1.05, 1.2, 15), offer("slow", 2, 3, 4, 1)
    assert prices._cheapest([slow, fast, small]) == small
    unknown = fast | {"time_ms_low": math.nan, "time_ms_high": math.nan}
    assert prices._cheapest([unknown, slow]) == unknown
