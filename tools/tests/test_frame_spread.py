"""How the frames of a case are spread, of made times."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from musclebench.experiments import case_tables
from musclebench.experiments.frame_spread import JUDGED, spread_table
from musclebench.results.run_folder import Run

STATE = {"allowed_cores": 1, "governor": "performance", "turbo": False, "smt": None}


def run(name: str, frame_ms, status: str = "ok", judged: bool = False, switches: int = 0) -> Run:
    """Its first frame warms up and takes a second."""
    times = 1e6 * np.array([1000, *frame_ms])
    frames = pd.DataFrame({"frame": range(1, len(times) + 1), "warm_up": [1] + [0] * len(frame_ms), "frame_ns": times,
                           "collision_ns": times / 4})
    record = {"status": status, "wall_ns": 1e9, "case": {"scene": "lhdl/iliacus", "judged": judged},
              "machine_state": STATE | {"involuntary_context_switches": switches}}
    return Run(Path(name), record, frames)


def test_median_tail_and_variation_are_those_of_the_timed_frames():
    table = spread_table({"a": [run("a-r0", np.arange(1, 101)), run("a-r1", np.arange(3, 103))]})
    (row,) = table.rows.to_dict("records")
    assert (row["case"], row["runs"], row["warm_up_frames"], row["disturbed"]) == ("a", 2, 1, 0)
    assert row["frame_ms"] == pytest.approx(51.5) and (row["p95_ms"], row["p99_ms"]) == (96, 100)  # the 190th and 198th of 1..100 and 3..102
    assert row["low_ms"] < 51.5 < row["high_ms"]
    assert row["variation_percent"] == pytest.approx(100 * np.std([50.5, 52.5], ddof=1) / 51.5)
    assert row["collision_ms"] == pytest.approx(51.5 / 4)
    assert (row["cores"], row["governor"], row["turbo"], row["smt"]) == (1, "performance", "off", "")


def test_one_run_varies_by_its_frames_only():
    (row,) = spread_table({"a": [run("a-r0", np.tile([1.0, 2.0], 40))]}).rows.to_dict("records")
    assert row["low_ms"] <= row["frame_ms"] <= row["high_ms"] and np.isnan(row["variation_percent"])


def test_what_was_disturbed_or_judged_is_told_and_what_failed_is_no_time():
    table = spread_table({"a": [run("a-r0", [1.0] * 9, switches=500), run("a-r1", [1.0] * 9)],
                          "b": [run("b-r0", [2.0] * 9, judged=True)],
                          "d": [run("d-r0", [4.0] * 9, judged=True), run("d-r1", [5.0] * 9)], "c": [run("c-r0", [3.0] * 9, status="diverged")]})
    assert list(table.rows["case"]) == ["a *", "b", "d"] and list(table.rows["disturbed"]) == [1, 0, 0]
    assert list(table.rows["frame_ms"]) == [1, 2, 5]
    assert "interrupted 500 times a second" in table.caption and JUDGED in table.caption


def test_a_replay_has_times_of_collision_only():
    replay = run("a-r0", [4.0] * 9)
    replay.frames = replay.frames.drop(columns="frame_ns")
    (row,) = spread_table({"a": [replay]}).rows.to_dict("records")
    assert row["collision_ms"] == 1 and np.isnan(row["frame_ms"]) and np.isnan(row["p99_ms"])


def test_repetitions_are_of_one_case():
    plan = [{"name": f"x-{backend}-r{number}", "group": "g", "mode": "run", "scene": "s", "preset": "p", "backend": backend,
             "parameters": {}, "axes": {}, "threads": 1, "repetition": number} for backend in ("bvh", "sdf") for number in (0, 1)]
    runs = {case["name"]: run(case["name"], [1.0] * 9) for case in plan} | {"x-sdf-r1": "missing"}
    found = case_tables._repetitions(plan, runs)
    assert {case: len(some) for case, some in found.items()} == {"x-bvh": 2, "x-sdf": 1}
