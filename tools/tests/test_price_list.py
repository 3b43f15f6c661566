"""The price list and the factors of fcl: what is the cheapest, and what counts as right."""

import json
import math
import shutil

import pytest

from fake_study import REPLAYED, SCENES, Truth, replays_of, write_coupled, write_failure, write_muscles, write_own_run, write_replay
from musclebench.accuracy import front, report
from musclebench.accuracy.rows import build_seconds_of
from musclebench.tables import prices
from musclebench.tables.choices import best_right, choices_tables
from musclebench.tables.difficulties import difficulties_table


@pytest.fixture
def study(tmp_path):
    write_muscles(tmp_path, with_own_runs=True)
    return tmp_path


def price(replays, muscle, target):
    rows = prices.price_list(replays, build_seconds_of(replays)).rows
    return rows[(rows["muscle"] == muscle) & (rows["target_mm"] == target)].iloc[0]


def test_the_price_list_names_the_cheapest_that_holds(study):
    replays = replays_of(study)
    expected = {"1": "sdf 64", "0.3": "sdf 64", "0.1": "sdf 128", "0.03": "bvh", "0.01": "bvh"}
    for muscle in ("iliacus", "gluteus_medius", front.ALL_MUSCLES):
        assert {target: price(replays, muscle, target)["configuration"] for target in expected} == expected
    row = price(replays, "iliacus", "0.1")
    assert row["ratio"] == pytest.approx(2.0) and row["build_s"] == 90 and row["p99_offset_mm"] == pytest.approx(0.08)
    assert price(replays, front.ALL_MUSCLES, "0.01")["ratio"] == pytest.approx(75)


def test_a_configuration_that_fails_on_one_muscle_holds_not_for_all(study):
    path = study / "raw" / "gluteus_medius-sdf 128-r0" / "run.json"
    record = json.loads(path.read_text())
    record["surface_offset"]["p99_offset_m"] = 0.2e-3
    path.write_text(json.dumps(record))
    replays = replays_of(study)
    assert price(replays, "iliacus", "0.1")["configuration"] == "sdf 128"
    assert price(replays, front.ALL_MUSCLES, "0.1")["configuration"] == "bvh"


def test_a_price_holds_what_its_own_run_left(study):
    path = study / "raw" / "iliacus-sdf 128-coupled" / "run.json"
    record = json.loads(path.read_text())
    record["outcome"]["p99_contact_depth_m"] = 0.15e-3
    path.write_text(json.dumps(record))
    replays = replays_of(study)
    assert price(replays, "iliacus", "0.1")["configuration"] == "bvh"
    assert price(replays, "gluteus_medius", "0.1")["configuration"] == "sdf 128"


def test_what_never_ran_has_no_price(study):
    shutil.rmtree(study / "raw" / "iliacus-sdf 128-coupled")
    assert price(replays_of(study), "iliacus", "0.1")["configuration"] == "bvh"


def test_the_same_answers_are_driven_once(study):
    """Of the one with choices, whose OBB answers as its default and whose RSS does not."""
    for name in ("fcl OBB", "fcl RSS"):
        shutil.rmtree(study / "raw" / f"iliacus-{name}-coupled")
    replays = {one.configuration.name: one for one in replays_of(study) if one.muscle == "iliacus"}
    assert replays["fcl OBB"].coupled is replays["fcl default"].coupled is not None
    assert replays["fcl RSS"].coupled is None


def test_a_configuration_that_one_muscle_lacks_holds_not_for_all(study):
    write_failure(study / "raw" / "late", "replay", SCENES[1], "sdf", "timeout", Truth(parameters={"cells": 200}))
    fine = Truth(0.5, 0.005, parameters={"cells": 200})
    write_replay(study / "raw" / "fine", SCENES[0], "sdf", fine)
    write_own_run(study / "raw" / "fine-coupled", SCENES[0], "sdf", fine)
    replays = replays_of(study)
    assert price(replays, "iliacus", "0.01")["configuration"] == "sdf 200"
    assert price(replays, front.ALL_MUSCLES, "0.01")["configuration"] == "bvh"


def test_what_several_threads_gain_is_no_price(study):
    for scene in SCENES:
        write_replay(study / "raw" / f"{scene.split('/')[1]}-two", scene, "bvh", Truth(0.01, 0.0, threads=2))
    replays = replays_of(study)
    for muscle in ("iliacus", front.ALL_MUSCLES):
        assert price(replays, muscle, "0.01")["configuration"] == "bvh" and price(replays, muscle, "1")["configuration"] == "sdf 64"


@pytest.mark.long
def test_a_depth_that_none_holds_names_the_best_found(tmp_path):
    write_replay(tmp_path / "raw" / "a", SCENES[0], "voxel", REPLAYED["voxel"])
    write_own_run(tmp_path / "raw" / "b", SCENES[0], "voxel", REPLAYED["voxel"])
    row = price(replays_of(tmp_path), "iliacus", "0.3")
    assert row["configuration"] == "none" and "voxel 64 with 3 mm" in row["note"]
    report.write_report(tmp_path)
    assert "voxel 64 with 3 mm" in (tmp_path / "tables" / "price_list.txt").read_text()


def test_the_factors_of_fcl_and_its_wrong_answers(study):
    replays = replays_of(study)
    table, = choices_tables(replays)
    rows = table.rows
    rows = rows[rows["muscle"] == "iliacus"].set_index("choice")
    assert rows.index[0] == "default" and rows.loc["default", "factor"] == 1
    assert rows.loc["OBB", "factor"] == pytest.approx(0.5) and rows.loc["OBB", "ratio"] == pytest.approx(180)
    assert rows.loc["default", "verdict"] == "right" and rows.loc["default", "missed"] == 50
    assert rows.loc["RSS", "verdict"] == "wrong: 100 % missed"
    assert best_right(replays, SCENES[0], "fcl").configuration.name == "fcl OBB"
    assert "a factor of 2.00 is configuration" in table.caption


@pytest.mark.parametrize("missed, false, p99_mm, verdict", [
    (100, 0, 0.1, "right"), (101, 0, 0.1, "wrong: 1.0 % missed"), (0, 200, 0.0, "wrong: 2.0 % false"),
    (0, 0, 0.11, "wrong: 0.11 mm off"), (0, 0, 0.0, "right"),
])
def test_the_rule_of_right_and_wrong(tmp_path, missed, false, p99_mm, verdict):
    write_replay(tmp_path / "raw" / "a", SCENES[0], "fcl", Truth(missed=missed, false=false, p99_mm=p99_mm))
    assert replays_of(tmp_path)[0].verdict == verdict


def test_of_equally_fast_configurations_the_smallest_is_the_cheapest():
    def offer(name, low, time, high, megabytes):
        return {"configuration": name, "time_ms_low": low, "time_ms": time, "time_ms_high": high,
                "structure_mb": megabytes}

    fast, small, slow = offer("fast", 0.9, 1.0, 1.1, 240), offer("small", 1.0, 1.05, 1.2, 15), offer("slow", 2, 3, 4, 1)
    assert prices._cheapest([slow, fast, small]) == small
    unknown = fast | {"time_ms_low": math.nan, "time_ms_high": math.nan}
    assert prices._cheapest([unknown, slow]) == unknown


def test_what_misses_every_contact_holds_no_depth(tmp_path):
    # Its surface is 3 mm too deep: what it misses is only as deep as one substep moves a node.
    coarse, exact = Truth(0.1, 3.0, missed=9_999, parameters={"cells": 8}), Truth(9.0, 0.0)
    for backend, truth in (("sdf", coarse), ("bvh", exact)):
        write_replay(tmp_path / "raw" / backend, SCENES[0], backend, truth)
        write_own_run(tmp_path / "raw" / f"{backend}-own", SCENES[0], backend, truth)
    replays = replays_of(tmp_path)
    assert [price(replays, "iliacus", target)["configuration"] for target in ("1", "0.1")] == ["bvh", "bvh"]


def test_a_method_that_collides_surfaces_has_the_depth_that_its_own_motion_leaves(tmp_path):
    write_replay(tmp_path / "raw" / "a", SCENES[0], "fcl", Truth(is_asked=False))
    assert math.isnan(replays_of(tmp_path)[0].p99_offset_mm) and replays_of(tmp_path)[0].verdict == "not judged"
    write_coupled(tmp_path / "raw" / "b", SCENES[0], "fcl", Truth(remaining_mm=0.7))
    replay = replays_of(tmp_path)[0]
    assert replay.p99_offset_mm == replay.inward_mm == pytest.approx(0.7) and replay.verdict == "wrong: 0.7 mm off"


def test_difficulties_stand_apart(study):
    table = difficulties_table(replays_of(study))
    row = table.rows[(table.rows["muscle"] == "iliacus") & (table.rows["configuration"] == "sdf 128")].iloc[0]
    assert row["ridge_mm"] == pytest.approx(0.08) and row["flat_mm"] == pytest.approx(0.008)
    assert math.isnan(row["thin_mm"]) and row["open_sites"] == 0
