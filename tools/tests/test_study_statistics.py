"""Medians with their intervals, of few frames and of several repetitions, and what is made of them."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from musclebench.results.statistics import Estimate, paired_ratio, percentile, pooled_median, quotient, total

BOOTSTRAP_CASES = Path(__file__).resolve().parents[2] / "core/measure/tests/block_bootstrap_cases.txt"


def times(frames, stride=16):
    values = np.random.default_rng(3).lognormal(size=frames)
    return pd.Series(values, index=stride * np.arange(1, frames + 1))


def test_of_few_frames_the_interval_is_not_known():
    estimate = pooled_median([times(5)])
    assert estimate.value == times(5).median() and math.isnan(estimate.low) and math.isnan(estimate.high)


def test_of_twenty_frames_the_interval_has_a_width_and_holds_its_median():
    estimate = pooled_median([times(20)])
    assert estimate.low < estimate.value < estimate.high


def test_repetitions_that_differ_widen_the_interval():
    frames = range(200)
    alike = pooled_median([pd.Series(10.0, index=frames)] * 3)
    apart = pooled_median([pd.Series(value, index=frames) for value in (9.0, 10.0, 12.0)])
    assert (alike.low, alike.value, alike.high) == (10, 10, 10)
    assert apart.value == 10 and apart.low <= 9.0 and apart.high >= 12.0


def test_ratios_are_matched_by_frame_and_repetition():
    slow_second = {0: pd.Series([1.0, 2.0, 3.0]), 1: pd.Series([10.0, 20.0, 30.0])}
    three_times = {number: 3 * values for number, values in slow_second.items()}
    assert paired_ratio(three_times, slow_second).value == pytest.approx(3.0)
    some_frames = {0: pd.Series([4.0], index=[2])}
    assert paired_ratio(some_frames, {0: slow_second[0]}).value == pytest.approx(4 / 3)
    assert math.isnan(paired_ratio({}, slow_second).value)


def test_sums_and_quotients_carry_their_intervals():
    draws = np.linspace(1, 3, 1001)
    one = Estimate(2.0, 1.05, 2.95, 5, draws)
    assert total([one, one]).value == 4 and total([one, one]).high == pytest.approx(5.9, abs=0.01)
    assert quotient(one, Estimate(2.0, 2, 2, 5, np.full(1001, 2.0))).value == 1
    assert math.isnan(quotient(one, Estimate.unknown()).value)


def bootstrap_cases() -> list[tuple[str, pd.Series, list[float]]]:
    """(name, values by frame, median with its interval) of what C++ and Python have to agree on."""
    found = []
    for part in BOOTSTRAP_CASES.read_text().split("case ")[1:]:
        name, *lines = part.strip().splitlines()
        told = {words[0]: [float(word) for word in words[1:]] for line in lines if (words := line.split())}
        found.append((name, pd.Series(told["values"], index=[int(frame) for frame in told["frames"]]), told["median_low_high"]))
    return found


@pytest.mark.parametrize("name, values, expected", bootstrap_cases(), ids=[case[0] for case in bootstrap_cases()])
def test_the_program_has_the_same_medians_and_intervals(name, values, expected):
    found = pooled_median([values])
    assert [found.value, found.low, found.high] == pytest.approx(expected, rel=0, abs=0, nan_ok=True)


def test_neighbours_that_are_alike_count_as_one():
    """Ten frames that are alike tell as little as one: an interval over single frames would be a third as wide."""
    every_tenth = np.random.default_rng(4).normal(100, 10, 60)
    alike = pooled_median([pd.Series(np.repeat(every_tenth, 10), index=range(600))])
    alone = pooled_median([pd.Series(every_tenth, index=10 * np.arange(60))])
    assert alike.value == alone.value
    assert alike.high - alike.low == pytest.approx(alone.high - alone.low, rel=0.35)


def test_a_percentile_has_the_rank_that_it_has_in_the_program():
    """That of percentile_test.cpp."""
    for count in range(1, 2001):
        ascending = np.arange(count)
        assert percentile(ascending, [99, 50]).tolist() == [(99 * count + 99) // 100 - 1, (count + 1) // 2 - 1]
    assert percentile(np.arange(7), [0, 100]).tolist() == [0, 6]


def test_each_repetition_is_compared_with_its_own_reference():
    """The machine was ten times as slow each time: three times as long is three times as long."""
    reference = {number: pd.Series(10.0**number, index=range(20)) for number in range(3)}
    ratio = paired_ratio({number: 3 * values for number, values in reference.items()}, reference)
    assert (ratio.low, ratio.value, ratio.high) == pytest.approx((3, 3, 3))


def test_only_frames_that_all_repetitions_have_count():
    early, late = pd.Series(1.0, index=range(16)), pd.Series([1.0] * 8 + [100.0] * 40, index=range(8, 56))
    found = pooled_median([early, late])
    assert (found.frames, found.value, found.high) == (8, 1.0, 1.0)
