"""Run folders are read as they are; unknown stays unknown; what can't be read says where."""

import json

import numpy as np
import pandas as pd
import pytest

import fake_runs
from musclebench.paper import published
from musclebench.results import ply, run_folder


def test_a_table_counts_what_the_program_warned_of(tmp_path):
    folder = fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "sdf", frames=4)
    assert run_folder.runs_table([run_folder.read_run(folder)]).iloc[0]["warnings"] is None  # of before
    record = json.loads((folder / "run.json").read_text())
    for warnings in ([], [{"rule": "unit", "text": "x"}, {"rule": "pieces", "text": "y"}]):
        (folder / "run.json").write_text(json.dumps(record | {"warnings": warnings}))
        assert run_folder.runs_table([run_folder.read_run(folder)]).iloc[0]["warnings"] == len(warnings)


def test_every_complete_folder_gives_a_run(fake_raw):
    (fake_raw / ".half.12").mkdir()
    (fake_raw / ".half.12" / "run.json").write_text("{}")
    runs = run_folder.read_runs(fake_raw)
    assert len(runs) == 16
    expected = {(muscle, backend) for muscle in fake_runs.MUSCLES for backend in fake_runs.backends()}
    assert {(run.muscle, run.backend) for run in runs} == expected


def test_collision_time_is_update_detect_and_respond(tmp_path):
    folder = fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "sdf", frames=4)
    frames = pd.read_csv(folder / "frames.csv")
    frames[["update_ns", "detect_ns", "respond_ns"]] = [10, 200, 3000]
    frames.to_csv(folder / "frames.csv", index=False)
    assert run_folder.read_run(folder).frames["collision_ns"].tolist() == [3210] * 4


def test_unknown_cells_stay_unknown(tmp_path):
    folder = fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "sdf", frames=4)
    frames = pd.read_csv(folder / "frames.csv")
    frames["missed_contacts"] = np.nan
    frames.to_csv(folder / "frames.csv", index=False)
    row = run_folder.runs_table([run_folder.read_run(folder)]).iloc[0]
    assert np.isnan(row["missed_contacts"]) and row["false_contacts"] == 4  # two timed frames, two each


def test_warm_up_frames_are_not_timed(tmp_path):
    run = run_folder.read_run(fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "sdf", frames=5))
    assert run.timed_frames["frame"].tolist() == [3, 4, 5]


def test_a_failed_run_without_frames_is_a_row(tmp_path):
    folder = fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "fcl", status="failed", detail="exit code 2: why")
    (folder / "frames.csv").unlink()
    row = run_folder.runs_table([run_folder.read_run(folder)]).iloc[0]
    assert row["status"] == "failed" and row["status_detail"] == "exit code 2: why"
    assert np.isnan(row["median_collision_ns"]) and np.isnan(row["max_depth_m"])


@pytest.mark.parametrize("text", ["", "{", "[]", json.dumps({"status": "ok"})])
def test_a_broken_run_json_is_named(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(run_folder.ResultProblem, match="run.json"):
        run_folder.read_run(tmp_path)


def test_missing_columns_are_named(tmp_path):
    folder = fake_runs.write_run(tmp_path / "r", "lhdl/iliacus", "sdf", frames=1)
    (folder / "frames.csv").write_text("frame,angle_deg\n1,2\n")
    with pytest.raises(run_folder.ResultProblem, match="detect_ns"):
        run_folder.read_run(folder)


def test_the_published_numbers_are_those_of_the_paper():
    paper = published.read_published()
    assert len(paper.memory_mb) == 12
    assert paper.memory("iliacus", "voxel", "first_mb") == 537
    assert paper.memory("gluteus_maximus", "fcl", "last_mb") == 1048
    assert np.isnan(paper.memory("iliacus", "null", "first_mb"))
    assert paper.time_ratio("fcl") == ">200" and paper.time_ratio("null") == ""


def test_snapshots_are_read_with_their_extra_properties(tmp_path):
    ball = fake_runs.sphere((1.0, 2.0, 3.0), 0.5)
    depth, attached = np.arange(len(ball.vertices_m)) * 1e-3, np.arange(len(ball.vertices_m)) % 2
    extra = {"depth_m": depth.astype("<f8"), "attached": attached.astype("u1")}
    fake_runs.write_ply(tmp_path / "s.ply", ball.vertices_m, ball.triangles, extra)
    mesh = ply.read_ply(tmp_path / "s.ply")
    assert np.array_equal(mesh.vertices_m, ball.vertices_m) and np.array_equal(mesh.triangles, ball.triangles)
    assert np.array_equal(mesh.extra["depth_m"], depth) and np.array_equal(mesh.extra["attached"], attached)


@pytest.mark.parametrize("cut", [3, 200, -1])
def test_a_truncated_ply_file_is_refused(tmp_path, cut):
    ball = fake_runs.sphere((0, 0, 0), 1.0)
    fake_runs.write_ply(tmp_path / "whole.ply", ball.vertices_m, ball.triangles)
    (tmp_path / "cut.ply").write_bytes((tmp_path / "whole.ply").read_bytes()[:cut])
    with pytest.raises(run_folder.ResultProblem, match="cut.ply"):
        ply.read_ply(tmp_path / "cut.ply")


def test_a_ply_file_with_quadrilaterals_is_refused(tmp_path):
    ball = fake_runs.sphere((0, 0, 0), 1.0)
    fake_runs.write_ply(tmp_path / "q.ply", ball.vertices_m, ball.triangles)
    data = bytearray((tmp_path / "q.ply").read_bytes())
    data[-13] = 4
    (tmp_path / "q.ply").write_bytes(data)
    with pytest.raises(run_folder.ResultProblem, match="three corners"):
        ply.read_ply(tmp_path / "q.ply")
