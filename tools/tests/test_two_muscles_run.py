"""Several muscles through every command and study as real runs: what is recorded, replayed, judged and tabled."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import accuracy
from ball_on_box import write_scene_of_two
from musclebench.results.damage import damage
from program import PROGRAM, call, complaint, needs_program

pytestmark = needs_program
FRAMES = 10
TOOLS = Path(accuracy.__file__).parent


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    return write_scene_of_two(tmp_path_factory.mktemp("two"))


@pytest.fixture(scope="module")
def recording(scene, tmp_path_factory) -> Path:
    file = tmp_path_factory.mktemp("recording") / "two.recording"
    done = call("record", scene, "--frames", FRAMES, "--out", file)
    assert done.returncode == 0, done.stderr
    return file


def test_a_run_has_a_row_a_frame_and_muscle_and_keeps_them_apart(scene, tmp_path):
    done = call("run", scene, "--backend", "bvh", "--frames", FRAMES, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    rows = pd.read_csv(tmp_path / "run" / "muscles.csv")
    assert rows.groupby("muscle").size().to_dict() == {"ball": FRAMES, "other": FRAMES}
    pairs = pd.read_csv(tmp_path / "run" / "pairs.csv")
    assert pairs.groupby(["muscle", "other"]).size().to_dict() == {
        ("ball", "box"): FRAMES, ("other", "box"): FRAMES, ("ball", "other"): FRAMES}
    assert (pairs.groupby(["muscle", "other"])["contacts"].max() > 0).all()
    asked = pairs[pairs["other"] == "box"].groupby("frame")["detect_ns"].sum()
    detection = pd.read_csv(tmp_path / "run" / "frames.csv").set_index("frame")["detect_ns"]
    assert (0 < asked).any() and (asked <= detection).all(), "pairs are parts of the detection of one thread"
    last = rows[rows["frame"] == FRAMES]
    assert (last["max_muscle_depth_m"] < 1e-4).all(), "they overlap by 0.5 mm at rest"
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert [one["muscles"] for one in told["case"]["muscle_contact"]] == [["ball", "other"]]


def test_what_detects_between_muscles_does_not_change_where_they_end(scene, tmp_path):
    hashes = {}
    for name in ("bvh", "brute_force"):
        done = call("run", scene, "--backend", "bvh", "--for", f"muscles={name}", "--frames", FRAMES, "--no-referee",
                    "--out", tmp_path / name)
        assert done.returncode == 0, done.stderr
        hashes[name] = json.loads((tmp_path / name / "run.json").read_text())["state_hash"]
    assert hashes["bvh"] == hashes["brute_force"]


def test_a_recording_of_two_muscles_is_replayed_by_every_backend(scene, recording, tmp_path):
    names = [one["name"] for one in json.loads(call("list", "--json").stdout)["backends"]]
    for name in names:
        quick = {"sdf": ["--param", "cells=8"], "voxel": ["--param", "cells=7"]}.get(name, [])
        done = call("replay", recording, "--backend", name, *quick, "--out", tmp_path / name)
        assert done.returncode == 0, f"{name}: {done.stderr}"
        rows = pd.read_csv(tmp_path / name / "frames.csv")
        assert len(rows) == FRAMES
        if name in ("bvh", "brute_force"):
            told = json.loads((tmp_path / name / "run.json").read_text())["accuracy"]
            assert told["missed_contacts"] == told["false_contacts"] == 0 < told["true_contacts"]


def test_a_replay_has_a_row_a_frame_and_muscle_and_keeps_them_apart(recording, tmp_path):
    """A backend that finds nothing, asked about one muscle: what it misses is that muscle's."""
    done = call("replay", recording, "--backend", "bvh", "--for", "ball/box=null", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "ball with bones" in done.stdout and "other with bones" in done.stdout
    frames, muscles, pairs = (pd.read_csv(tmp_path / "out" / f"{name}.csv", keep_default_na=False, na_values=[""])
                              for name in ("frames", "muscles", "pairs"))
    assert muscles.groupby("muscle").size().to_dict() == {"ball": FRAMES, "other": FRAMES}
    assert pairs.groupby(["muscle", "other"]).size().to_dict() == {
        ("ball", "box"): FRAMES, ("other", "box"): FRAMES, ("ball", "other"): FRAMES}
    ball, other = (muscles[muscles["muscle"] == name] for name in ("ball", "other"))
    assert (ball["contacts"] == 0).all() and ball["missed_contacts"].sum() > 0 == other["missed_contacts"].sum()
    for table in (muscles, pairs[pairs["other"] == "box"]):
        for column in ("contacts", "true_contacts", "missed_contacts", "false_contacts", "measured_contacts"):
            assert (table.groupby("frame")[column].sum().to_numpy() == frames[column]).all(), column
        largest = table.groupby("frame")["max_depth_error_m"].max().to_numpy()
        assert np.array_equal(largest, frames["max_depth_error_m"], equal_nan=True)  # empty: no contact that both see
    told = json.loads((tmp_path / "out" / "run.json").read_text())["accuracy_of_muscles"]
    assert [(one["muscle"], one["missed_contacts"] > 0) for one in told] == [("ball", True), ("other", False)]
    with_box = pairs[pairs["other"] == "box"].set_index("muscle")
    assert set(with_box.loc["ball", "backend"]) == {"null"} and (with_box.loc["other", "detect_ns"] > 0).any()


def test_what_detects_between_muscles_is_replayed_on_equal_inputs(recording, tmp_path):
    backends = json.loads(call("list", "--json").stdout)["backends"]
    able = [one["name"] for one in backends if one["muscle_contact"]]
    told = {}
    for name in able:
        done = call("replay", recording, "--backend", "null", "--for", f"muscles={name}", "--out", tmp_path / name)
        assert done.returncode == 0, f"{name}: {done.stderr}"
        assert f"ball and other by {name}" in done.stdout
        pairs = pd.read_csv(tmp_path / name / "pairs.csv")
        rows = pairs[pairs["other"] == "other"]
        assert len(rows) == FRAMES and (rows["backend"] == name).all() and (rows["detect_ns"] > 0).all()
        assert (rows["true_contacts"] > 0).any() and (rows["false_contacts"] == 0).all()
        told[name] = json.loads((tmp_path / name / "run.json").read_text())
        accuracy_of_pair = told[name]["muscle_accuracy"][0]
        assert accuracy_of_pair["muscles"] == ["ball", "other"]
        if name != "fcl":  # which measures to the closest of the triangles that cut
            assert accuracy_of_pair["missed_contacts"] == 0 and accuracy_of_pair["max_depth_error_m"] < 1e-12
    assert told["bvh"]["muscle_contact_hash"] == told["brute_force"]["muscle_contact_hash"]


def test_a_replay_of_bones_only_asks_nothing_between_muscles(recording, tmp_path):
    done = call("replay", recording, "--backend", "bvh", "--bones-only", "--out", tmp_path / "bones")
    assert done.returncode == 0, done.stderr
    assert set(pd.read_csv(tmp_path / "bones" / "pairs.csv")["other"]) == {"box"}
    assert json.loads((tmp_path / "bones" / "run.json").read_text())["muscle_accuracy"] == []


@pytest.mark.parametrize("command, table", [("run", "muscles.csv"), ("run", "pairs.csv"), ("replay", "muscles.csv"), ("replay", "pairs.csv")])
def test_a_result_with_a_cut_table_is_not_complete(scene, recording, tmp_path, command, table):
    out = tmp_path / "out"
    what = [recording] if command == "replay" else [scene, "--frames", FRAMES]
    assert call(command, *what, "--backend", "bvh", "--out", out).returncode == 0
    assert "complete already" in call(command, *what, "--backend", "bvh", "--out", out).stdout
    lines = (out / table).read_text().splitlines(keepends=True)
    (out / table).write_text("".join(lines[:-1]))
    assert damage(out).startswith(table)
    assert "complete already" not in call(command, *what, "--backend", "bvh", "--out", out).stdout
    assert damage(out) == "" and (out / table).read_text().count("\n") == len(lines)


@pytest.mark.parametrize("pair, words", [
    ('muscles = ["ball", "other"]\nbackend = "sdf"', ["pair[1].backend", "can't follow a surface that deforms"]),
    ('muscle = "ball"\nbone = "box"\nbackend = "sfd"', ["pair[1].backend", "did you mean 'sdf'"]),
    ('muscle = "ball"\nbone = "bax"\nsteps = 2', ["pair[1].bone", "did you mean 'box'"]),
])
def test_a_pair_that_cannot_be_is_told_in_one_line(scene, tmp_path, pair, words):
    wrong = scene.with_name("wrong.toml")
    wrong.write_text(f"{scene.read_text()}\n[[pair]]\n{pair}\n")
    done = call("run", wrong, "--backend", "bvh", "--out", tmp_path / "out")
    told = complaint(done)
    assert done.returncode == 2 and len(told.splitlines()) == 1 and not (tmp_path / "out").exists()
    assert all(word in told for word in ["wrong.toml:", *words])
    checked = call("check", wrong)
    assert all(word in checked.stdout + checked.stderr for word in words)


def test_a_backend_of_a_muscle_and_a_bone_stands_in_the_record(scene, tmp_path):
    done = call("run", scene, "--backend", "bvh", "--for", "ball/box=sdf:cells=16", "--frames", "3", "--no-referee",
                "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert list(told["case"]["bone_backends"]) == ["ball/box"]
    assert told["case"]["bone_backends"]["ball/box"]["parameters"]["cells"] == 16
    assert [error["bone"] for error in told["structure_errors"]] == ["box"]


def run_tool(name: str, scene: Path, out: Path, *arguments: str) -> str:
    done = subprocess.run([sys.executable, TOOLS / f"{name}.py", "--musclebench", PROGRAM, "--scene", scene, "--out", out,
                           *arguments], capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.long
def test_the_budget_takes_a_scene_of_two_muscles(scene, tmp_path):
    text = run_tool("budget", scene, tmp_path / "out", "--finest", "2")
    rows = pd.read_csv(tmp_path / "out" / "tables" / "budget.csv")
    assert set(rows["scene"]) == {scene.stem} and {"time step", "iterations", "rounding"} <= set(rows["source"])
    assert f"{scene.stem}: " in text and rows.set_index("source").loc["time step", "shape_mm"] >= 0


@pytest.mark.long
def test_paper_takes_a_scene_of_two_muscles(scene, tmp_path):
    run_tool("paper", scene, tmp_path / "out", "--frames-limit", "4", "--jobs", "1")
    depths = pd.read_csv(next((tmp_path / "out").glob("**/table_4_depths.csv")))
    assert set(depths["muscle"]) == {"ball", "other"}


@pytest.mark.long
def test_accuracy_takes_a_scene_of_two_muscles(scene, tmp_path):
    run_tool("accuracy", scene, tmp_path / "out", "--quick", "--frames-limit", "4", "--jobs", "1")
    cases = pd.read_csv(tmp_path / "out" / "accuracy.csv")
    measured = cases[cases["status"].isin(["ok", "suspect"])]
    assert {"replay", "coupled"} <= set(measured["mode"]) and {"bvh", "sdf", "voxel"} <= set(measured["backend"])


@pytest.mark.weekly
def test_effects_take_a_scene_of_two_muscles(scene, tmp_path):
    run_tool("effects", scene, tmp_path / "out", "--quick", "--frames-limit", "4", "--jobs", "1")
    assert list((tmp_path / "out").glob("**/*.csv"))


def test_advise_and_probe_take_a_scene_of_two_muscles(scene, tmp_path):
    done = call("advise", scene, "--depth-mm", "5", "--frames", "4")
    assert done.returncode == 0, done.stderr
    done = call("probe", scene, "--backend", "bvh", "--frames", "4", "--out", tmp_path / "probe")
    assert done.returncode == 0, done.stderr
    assert len(pd.read_csv(next((tmp_path / "probe").glob("*.csv")))) > 0


@pytest.mark.long
def test_four_muscles_of_the_hip_end_in_the_same_bits_on_one_thread_and_on_two(tmp_path):
    hashes = []
    for threads in ("1", "2"):
        done = call("run", "synthetic/hip", "--backend", "sdf", "--param", "cells=16", "--threads", threads, "--frames", "2",
                    "--no-referee", "--out", tmp_path / threads)
        assert done.returncode == 0, done.stderr
        hashes.append(json.loads((tmp_path / threads / "run.json").read_text())["state_hash"])
        assert pd.read_csv(tmp_path / threads / "muscles.csv")["muscle"].nunique() == 4
    assert hashes[0] == hashes[1]


# A program of its own, since most kernels can't be left out in another process from here: those of sizes and of other
# scenes take longer than all the rest.
FEW_KERNELS = """
import sys
sys.path.insert(0, {tools!r})
from dataclasses import replace
import speed
from musclebench.speed import quick
whole, quick.FRAMES = speed.of_project("speed"), 4
few = tuple(one for one in whole.groups if one.mode == "run" or one.name in ("constraints", "loop", "allocations"))
speed.of_project = lambda name: replace(whole, groups=few)
sys.exit(speed.main(sys.argv[1:]))
"""


@pytest.mark.weekly
def test_speed_takes_a_scene_of_two_muscles(scene, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", FEW_KERNELS.format(tools=str(TOOLS)), "--quick", "--repetitions", "1", "--musclebench", PROGRAM,
         "--scene", scene, "--out", tmp_path / "out"], capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    rows = pd.read_csv(tmp_path / "out" / "speed.csv").set_index("what")["measured"].groupby(level=0).first()
    for what in ("collision time, sdf 64 / voxel 64", "two threads over one, loop without collision, `standard`",
                 "bending, ns a constraint: one by one / SIMD lanes (of AVX-512)"):
        assert rows[what] > 0, what
