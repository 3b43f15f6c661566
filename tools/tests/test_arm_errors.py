"""What a backend's accuracy is worth in fibre lengths and moment arms."""

import json
import math
from pathlib import Path

import pandas as pd
import pytest

from fake_study import SCENES, Truth, write_coupled
from musclebench.accuracy import cases, report
from musclebench.accuracy.aggregates import aggregates_of, of_mode
from musclebench.accuracy.arm_errors import arm_errors
from musclebench.results.arms import arm_differences
from musclebench.results.run_folder import Run
from musclebench.tables.arm_prices import arm_price_list, arm_table
from musclebench.tables.outcomes import outcomes_table, shape_distances

FLOOR_MM = 0.7
ARM_CASES = Path(__file__).resolve().parents[2] / "core/measure/tests/arm_error_cases.txt"


@pytest.fixture
def study(tmp_path):
    raw = tmp_path / "raw"
    for scene in SCENES:
        name = scene.split("/")[-1]
        write_coupled(raw / f"{name}-e", scene, "bvh", Truth(15, arm_off_mm=0))
        write_coupled(raw / f"{name}-s", scene, "sdf", Truth(0.3, arm_off_mm=1.5, parameters={"cells": 64}))
        write_coupled(raw / f"{name}-v", scene, "voxel", Truth(0.2, arm_off_mm=-4))
        write_coupled(raw / f"{name}-plain", scene, "sdf", Truth(0.1, parameters={"cells": 32}))
        write_coupled(raw / f"{name}-c", scene, "bvh", Truth(15))
        with_noise(write_coupled(raw / f"{name}-n", scene, "bvh", Truth(15)))
        with_noise(write_coupled(raw / f"{name}-f", scene, "bvh", Truth(15, arm_off_mm=FLOOR_MM)))
    return tmp_path


def with_noise(folder):
    record = json.loads((folder / "run.json").read_text())
    record["case"]["loop"] = {"start_noise_m": 1e-12}
    (folder / "run.json").write_text(json.dumps(record))


def measured(study):
    aggregates = aggregates_of(cases.read_cases(study))
    armed, floors = of_mode(aggregates, "arms"), of_mode(aggregates, "arms_floor")
    return armed, floors, arm_errors(armed, floors)


def by_name(errors, scene):
    return {chosen.name: error for (where, chosen), error in errors.items() if where == scene}


def test_errors_are_those_against_the_exact_run_where_the_joint_turns(study):
    _, floors, errors = measured(study)
    assert len(floors) == len(SCENES)
    found = by_name(errors, SCENES[0])
    assert found["bvh"]["arm_rms_mm"] == 0 and "sdf 32" not in found  # no fibres were followed
    assert found["sdf 64"]["arm_percent"] == pytest.approx(3)
    assert found["sdf 64"]["arm_rms_mm"] == found["sdf 64"]["arm_max_mm"] == pytest.approx(1.5)
    assert found["voxel 64"]["arm_rms_mm"] == pytest.approx(4)
    assert 0 < found["sdf 64"]["length_rms_mm"] < found["sdf 64"]["length_max_mm"] <= 1.5 * math.pi / 2 + 1e-9
    assert all(error["arm_floor_mm"] == pytest.approx(FLOOR_MM) for error in found.values())


def test_without_an_exact_run_nothing_is_known(study):
    for path in study.glob("raw/*-e/run.json"):
        path.write_text(json.dumps(json.loads(path.read_text()) | {"status": "diverged"}))
    assert measured(study)[2] == {}


def test_the_price_list_names_the_cheapest_that_holds(study):
    armed, _, errors = measured(study)
    rows = arm_price_list(armed, errors, set()).rows.set_index(["muscle", "target_mm"])
    for muscle in (SCENES[0].split("/")[-1], "all"):
        assert {target: rows.loc[(muscle, target), "configuration"] for target in ("5", "2", "1")} == {
            "5": "voxel 64", "2": "sdf 64", "1": "bvh"}
        assert "below what rounding does" in rows.loc[(muscle, "0.5"), "note"]
    faulty = {key for key in errors if key[1].backend == "voxel"}
    rows = arm_price_list(armed, errors, faulty).rows.set_index(["muscle", "target_mm"])
    assert rows.loc[("all", "5"), "configuration"] == "sdf 64"


@pytest.mark.long
def test_the_floor_of_shapes_has_a_row_and_everything_is_drawn(study):
    aggregates = aggregates_of(cases.read_cases(study))
    coupled, floors = of_mode(aggregates, "coupled"), of_mode(aggregates, "floor")
    rows = outcomes_table(coupled, shape_distances(coupled), floors).rows
    told = rows[rows["configuration"] == "bvh, start off by rounding"]
    assert len(told) == len(SCENES) and (told["full_rms_mm"] == 0).all()
    names = {path.name for path in report.write_report(study)}
    assert {"pareto_moment_arm.png", "arm_price_list.csv", "arm_price_list.txt", "arm_errors.csv"} <= names
    armed, _, errors = measured(study)
    rows = arm_table(armed, errors).rows.set_index(["muscle", "configuration"])
    assert rows.loc[(SCENES[0].split("/")[-1], "voxel 64"), "arm_rms_mm"] == pytest.approx(4)


def test_the_program_has_the_same_error_of_moment_arms():
    heading = ARM_CASES.read_text().splitlines()[1]
    rms_mm, max_mm, _ = (float(word) for word in heading.split()[1:])
    table = pd.read_csv(ARM_CASES, sep=" ", skiprows=3)

    def run(before: str) -> Run:
        fibres = pd.DataFrame({"muscle": "m", "frame": table["frame"], "angle_deg": table["angle_deg"],
                               "mean_length_m": table[f"{before}length_mm"] / 1e3,
                               "mean_moment_arm_m": table[f"{before}arm_mm"] / 1e3})
        return Run(Path(before), {}, pd.DataFrame(), fibres=fibres)

    found = arm_differences(run(""), run("exact_"))
    assert found["arm_rms_mm"] == pytest.approx(rms_mm, abs=1e-6) and found["arm_max_mm"] == pytest.approx(max_mm, abs=1e-6)
