"""The accuracy study's report says what follows from known runs, however incomplete the study is."""

import json

import numpy as np
import pandas as pd
import pytest

import fake_study
from fake_study import (
    REPLAYED, SCENES, Truth, replays_of, write_coupled, write_failure, write_plan, write_probe, write_replay,
)
from musclebench.accuracy import cases, report
from musclebench.accuracy.aggregates import aggregates_of, of_mode
from musclebench.accuracy.rows import accuracy_rows, build_seconds_of, study_rows
from musclebench.figures.stages import chosen_aggregates, stage_rows
from musclebench.results import run_folder
from musclebench.tables import table_formats


@pytest.mark.long
def test_what_failed_or_is_missing_is_a_row_and_not_in_a_figure(study):
    write_failure(study / "raw" / "late", "coupled", SCENES[0], "brute_force", "timeout")
    write_failure(study / "raw" / "refused", "replay", SCENES[0], "fcl", "unsupported", Truth(
        parameters={"bounding_volume": "KDOP24"}))
    (study / "raw" / "broken").mkdir()
    (study / "raw" / "broken" / "run.json").write_text("{")
    plan = {"mode": "replay", "scene": SCENES[0], "backend": "voxel", "parameters": {"cells": 48}, "threads": 1,
            "repetition": 0}
    write_plan(study, [{"name": "not-yet", **plan}, {"name": "broken", **plan, "repetition": 1}])
    made = report.write_report(study)
    table = pd.read_csv(study / "accuracy.csv").set_index("case")
    assert table.loc["late", "status"] == "timeout" and table.loc["refused", "status"] == "unsupported"
    assert table.loc["not-yet", "status"] == "missing" and table.loc["broken", "status"] == "failed"
    assert np.isnan(table.loc["late", "median_collision_ns"])
    drawn = pd.read_csv(study / "figures" / "pareto_replay.csv")
    assert not {"voxel 48", "fcl KDOP24"} & set(drawn["configuration"])
    caption = (study / "figures" / "pareto_replay.md").read_text()
    assert "voxel 48 (missing)" in caption and "fcl KDOP24 (unsupported)" in caption
    for name in ("price_list", "coupled_outcomes"):
        told = (study / "tables" / f"{name}.md").read_text()
        assert "Whose code? " in told and "sdf: this project, after Discregrid's method" in told
    assert all(path.is_file() for path in made)


@pytest.mark.parametrize("folders", [[], ["raw"]])
def test_an_empty_study_gives_empty_tables_and_no_figure(tmp_path, folders):
    for folder in folders:
        (tmp_path / folder).mkdir()
    made = report.write_report(tmp_path)
    assert not [path for path in made if path.suffix == ".png"]


def test_a_broken_folder_that_no_plan_names_stops_with_its_location(tmp_path):
    (tmp_path / "raw" / "x").mkdir(parents=True)
    fake_study.note_registry(tmp_path)
    (tmp_path / "raw" / "x" / "run.json").write_text("{")
    with pytest.raises(run_folder.ResultProblem, match="x/run.json"):
        report.write_report(tmp_path)


def test_a_broken_plan_is_named(tmp_path):
    (tmp_path / "experiment.json").write_text("[]")
    with pytest.raises(run_folder.ResultProblem, match="experiment.json"):
        cases.read_cases(tmp_path)


def test_repetitions_with_different_answers_are_shown_as_such(study):
    path = study / "raw" / "iliacus-bvh-r1" / "run.json"
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"contact_hash": "another"}))
    aggregate = next(e for e in replays_of(study) if e.backend == "bvh" and e.scene == SCENES[0])
    assert aggregate.status == "nondeterministic" and not aggregate.is_shown


def test_frames_that_warm_up_are_in_no_median(study):
    path = study / "raw" / "iliacus-bvh-r0" / "frames.csv"
    frames = pd.read_csv(path)
    frames["detect_ns"] = 1000 + frames["frame"]
    frames["warm_up"] = (frames["frame"] <= frames["frame"].iloc[4]).astype(int)
    frames.to_csv(path, index=False)
    row = accuracy_rows(cases.read_cases(study)).set_index("case").loc["iliacus-bvh-r0"]
    assert row["median_detect_ns"] == frames["detect_ns"][5:].median() != frames["detect_ns"].median()


def test_of_repetitions_the_worst_figure_counts(study):
    for number, error_m in ((0, 1e-3), (1, 2e-3)):
        path = study / "raw" / f"iliacus-bvh-r{number}" / "run.json"
        record = json.loads(path.read_text())
        record["accuracy"] = (record.get("accuracy") or {}) | {"p99_depth_error_m": error_m}
        path.write_text(json.dumps(record))
    (found,) = [one for one in replays_of(study) if one.backend == "bvh" and one.scene == SCENES[0]]
    assert found.number("accuracy", "p99_depth_error_m") == 2e-3


def test_rows_have_medians_and_the_judged_repetitions_errors(study):
    found = cases.read_cases(study)
    table = accuracy_rows(found)
    assert len(table) == 2 * len(SCENES) * len(REPLAYED)
    aggregates = aggregates_of(found)
    row = study_rows(aggregates, build_seconds_of(aggregates)).set_index(["scene", "configuration"]).loc[
        (SCENES[0], "sdf 64")]
    assert row["collision_ms"] == pytest.approx(0.3) and row["times_unit"] == pytest.approx(1.5)
    assert row["p99_depth_error_m"] == pytest.approx(0.25e-3) and row["ok_repetitions"] == 2
    assert row["detect_ms"] == pytest.approx(0.24) and row["build_s"] == 12


def test_a_field_that_was_loaded_has_the_build_time_of_the_case_that_built_it(tmp_path):
    truth = Truth(build_s=12, parameters={"cells": 64})
    write_probe(tmp_path / "raw" / "p", SCENES[0], "sdf", truth)
    loaded = Truth(build_s=0.1, structures="loaded", parameters={"cells": 64})
    write_replay(tmp_path / "raw" / "r", SCENES[0], "sdf", loaded)
    for name in "pr":  # the same bones in both
        path = tmp_path / "raw" / name / "run.json"
        record = json.loads(path.read_text())
        noted = {"kept_build_ns": 99_000_000_000} if name == "r" else {}  # another machine's, maybe
        path.write_text(json.dumps(record | noted | {"bones": [{"name": "femur", "mesh_sha256": "same"}]}))
    aggregates = aggregates_of(cases.read_cases(tmp_path))
    rows = study_rows(aggregates, build_seconds_of(aggregates))
    assert rows.set_index("mode").loc["replay", "build_s"] == 12


def test_a_field_that_all_loaded_has_the_build_time_that_is_noted_beside_it(tmp_path):
    write_probe(tmp_path / "raw" / "p", SCENES[0], "sdf", Truth(build_s=0.1, structures="loaded", parameters={"cells": 64}))
    path = tmp_path / "raw" / "p" / "run.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"kept_build_ns": 12_000_000_000}))
    aggregates = aggregates_of(cases.read_cases(tmp_path))
    assert study_rows(aggregates, build_seconds_of(aggregates)).build_s.tolist() == [12]


def test_shares_of_a_frame_add_up_and_the_best_fcl_is_chosen(study):
    for number, name in enumerate(("voxel", "fcl", "fcl OBB", "fcl RSS")):
        write_coupled(study / "raw" / f"c{number}", SCENES[0], name.split()[0], REPLAYED[name])
    aggregates = aggregates_of(cases.read_cases(study))
    replays, coupled = of_mode(aggregates, "replay"), of_mode(aggregates, "coupled")
    names = [aggregate.configuration.name for aggregate in chosen_aggregates(coupled, replays, SCENES[0])]
    assert names == ["voxel 64", "fcl default", "fcl OBB"]
    rows = stage_rows(coupled, replays).set_index(["configuration", "stage"])
    assert rows.loc[("fcl OBB", "detect_ns"), "ms"] == pytest.approx(0.8 * 36)
    assert rows.groupby("configuration")["share"].sum().tolist() == pytest.approx([1, 1, 1])
    assert not {"frame_ns", "recording_ns", "judging_ns"} & set(rows.index.get_level_values("stage"))


@pytest.mark.long
def test_tables_fit_a_terminal(study):
    for table in report.write_report(study).tables:
        assert max(map(len, table_formats.as_text(table).splitlines())) <= 110
