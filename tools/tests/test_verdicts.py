"""When two sets of samples count as changed, by the three conditions each alone."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from musclebench.comparison.metrics import values_of
from musclebench.comparison.result_set import ResultSet, Sample
from musclebench.comparison.verdicts import LEVEL, compare
from musclebench.results.run_folder import Run
from musclebench.results.samples import mann_whitney

RUNS = 8


def drawn(cases: dict[str, np.ndarray], metric: str = "frame_ns", invocation: str = "one", digest: str = "") -> ResultSet:
    found = ResultSet("a set")
    for case, values in cases.items():
        found.cases[case] = [
            Sample(Run(Path(f"{case}-r{number}"), {"status": "ok", "case": {}}, pd.DataFrame()),
                   {"invocation": invocation, "binary_sha256": digest}, number, {metric: value})
            for number, value in enumerate(values)]
    return found


def noise(seed: int, spread: float) -> np.ndarray:
    return 1e6 * np.exp(np.random.default_rng(seed).normal(0, spread, RUNS))


def verdict(factor: float, spread: float, metric: str = "frame_ns", **more) -> str:
    (row,) = compare(drawn({"a": noise(1, spread)}, metric, **more), drawn({"a": factor * noise(2, spread)}, metric, **more)).rows
    return row.verdict


@pytest.mark.parametrize(("factor", "metric", "expected"), [
    (1.03, "frame_ns", "same"), (1.07, "frame_ns", "slower"), (1 / 1.07, "frame_ns", "faster"),
    (1.005, "instructions", "same"), (1.02, "instructions", "more"), (1 / 1.02, "process_instructions", "fewer"),
])
def test_what_is_smaller_than_counts_is_no_change(factor, metric, expected):
    assert verdict(factor, 0.0005, metric) == expected


def test_what_noise_could_have_made_is_unclear():
    assert verdict(1.06, 0.07) in ("unclear", "not trusted")
    assert verdict(1.3, 0.3) == "not trusted"


def test_a_ratio_whose_interval_holds_one_is_no_change():
    """Little more than half of the runs take 7 % longer, the others as long as before: the U test is sure, and the median is not."""
    random, runs = np.random.default_rng(2), 40
    before = 1e6 * np.exp(random.normal(0, 0.005, runs))
    after = before * np.where(np.arange(runs) < 22, 1.07, np.exp(random.normal(-0.002, 0.003, runs)))
    (row,) = compare(drawn({"a": before}), drawn({"a": after})).rows
    assert row.chance < LEVEL and row.ratio.value > 1.05 and row.ratio.low <= 1 < row.ratio.high
    assert row.verdict == "unclear"


def test_pairs_show_what_the_drift_of_the_machine_hides():
    """It becomes twice as slow meanwhile; of runs that were not interleaved nobody knows which met it when."""
    drift = np.linspace(1, 2, RUNS)
    before, after = {"a": drift * noise(1, 0.01)}, {"a": 1.1 * drift * noise(2, 0.01)}
    (row,) = compare(drawn(before), drawn(after)).rows
    assert row.verdict == "slower" and row.chance < LEVEL
    (alone,) = compare(drawn(before), drawn(after, invocation="another")).rows
    assert not alone.is_change and alone.chance > LEVEL


@pytest.mark.long
def test_of_many_cases_none_alarms_by_chance():
    """Each alone would, now and then."""
    single, together = 0, 0
    for family in range(7):
        sides = [{str(case): noise(1000 * family + 2 * case + side, 0.06) for case in range(30)} for side in (0, 1)]
        single += any(mann_whitney(pd.Series(sides[0][case]), pd.Series(sides[1][case])) < LEVEL for case in sides[0])
        together += bool(compare(*map(drawn, sides)).changes)
    assert single >= 1 and together == 0


def test_the_same_program_does_not_change_however_its_times_do():
    assert verdict(1.5, 0.001, digest="abc") == "not trusted" and verdict(1.5, 0.001) == "slower"


def test_a_case_that_is_gone_is_a_change_and_a_new_one_is_none():
    one, both = drawn({"a": noise(1, 0.001)}), drawn({"a": noise(1, 0.001), "b": noise(2, 0.001)})
    assert [(row.case, row.verdict) for row in compare(both, one).changes] == [("b", "gone")]
    assert compare(one, both).changes == []


def test_cpu_time_is_that_of_the_loop_and_a_judged_run_has_no_time():
    record = {"status": "ok", "frames": 10, "build_ns": 10**6, "case": {"judged": False},
              "cpu_ns": {"before_first_frame": 5 * 10**6, "after_last_frame": 6 * 10**6}}
    told = values_of(Run(Path("a"), record, pd.DataFrame()))
    assert (told["cpu_ns"], told["build_ns"]) == (10**5, 10**6)
    judged = values_of(Run(Path("a"), record | {"case": {"judged": True}}, pd.DataFrame()))
    assert judged["status"] == "ok" and not {"cpu_ns", "build_ns"} & judged.keys()


def test_answers_that_differ_between_repetitions_are_a_change_of_one_program_too():
    before, after = drawn({"a": noise(1, 0.001)}, digest="abc"), drawn({"a": noise(1, 0.001)}, digest="abc")
    for number, sample in enumerate(after.cases["a"]):
        sample.values["state_hash"] = str(number % 2)
    for sample in before.cases["a"]:
        sample.values["state_hash"] = "0"
    (row,) = compare(before, after).changes
    assert (row.metric.name, row.after) == ("state_hash", "0 or 1")
