"""Recordings and replays as a user meets them: the exact backend agrees with its recording, bad input is refused."""

import json
import resource
import signal
import subprocess
import time
from pathlib import Path

import pandas as pd
import pytest

from ball_on_box import write_scene
from program import PROGRAM, call, complaint, needs_program

pytestmark = needs_program

FRAMES = 10
STEPS = 2  # a frame
QUICK = {"sdf": ["--param", "cells=8"], "voxel": ["--param", "cells=7"]}


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    return write_scene(tmp_path_factory.mktemp("scene"))


def record(scene: Path, file: Path, *arguments, **options):
    return call("record", scene, "--frames", FRAMES, "--out", file, *arguments, **options)


@pytest.fixture(scope="module")
def recording(scene, tmp_path_factory) -> Path:
    file = tmp_path_factory.mktemp("recording") / "ball.recording"
    done = record(scene, file)
    assert done.returncode == 0, done.stderr
    return file


def replay(recording: Path, out: Path, *arguments, backend="bvh"):
    done = call("replay", recording, "--backend", backend, "--out", out, *arguments,
                *([] if arguments else QUICK.get(backend, [])))
    assert done.returncode == 0, done.stderr
    return json.loads((out / "run.json").read_text()), pd.read_csv(out / "frames.csv")


def assert_refused(done, *words):
    assert done.returncode == 2, done.stderr
    assert len(complaint(done).splitlines()) == 1, done.stderr
    for word in words:
        assert word in done.stderr


def test_the_same_scene_makes_the_same_recording(scene, recording, tmp_path):
    again = tmp_path / "again.recording"
    done = record(scene, again, "--threads", 2)
    assert again.read_bytes() == recording.read_bytes()
    assert "bytes a node and step" in done.stdout


def test_the_exact_backend_answers_its_own_recording_exactly(recording, tmp_path):
    manifest, frames = replay(recording, tmp_path / "out")
    assert manifest["status"] == "ok"
    assert manifest["case"]["mode"] == "replay"
    assert manifest["recording"]["iterations"] == FRAMES * STEPS
    assert manifest["structures"] == "built"
    accuracy = manifest["accuracy"]
    assert accuracy["true_contacts"] > 0
    assert accuracy["missed_contacts"] == accuracy["false_contacts"] == 0
    assert accuracy["contacts"] == accuracy["true_contacts"]
    assert accuracy["max_depth_error_m"] < 1e-15
    assert accuracy["max_normal_error_deg"] < 1e-3
    assert list(frames.frame) == list(range(1, FRAMES + 1))
    assert (frames.iterations == STEPS).all()
    assert (frames.detect_ns > 0).all()
    assert manifest["wall_ns"] > frames[["update_ns", "detect_ns", "respond_ns"]].to_numpy().sum()
    for count in ("contacts", "true_contacts", "missed_contacts", "false_contacts", "measured_contacts"):
        assert frames[count].sum() == accuracy[count]
    assert frames.max_depth_error_m.max() == accuracy["max_depth_error_m"]
    assert manifest["surface_offset"]["max_offset_m"] == 0 and manifest["surface_offset"]["sites"] > 0


@pytest.mark.parametrize("backend", ["null", "voxel", "sdf", "fcl", "brute_force"])
def test_every_backend_is_asked_the_same(recording, tmp_path, backend):
    told_exact, _ = replay(recording, tmp_path / "exact")
    manifest, _ = replay(recording, tmp_path / "out", backend=backend)
    exact, declared = told_exact["accuracy"], manifest["declared"]
    assert manifest["queries_hash"] == told_exact["queries_hash"] and manifest["contact_hash"] != told_exact["queries_hash"]
    accuracy, offset = manifest["accuracy"], manifest["surface_offset"]
    assert offset is None or offset["sites"] == sum(kind["sites"] for kind in offset["of_difficulties"]) > 0
    assert accuracy["true_contacts"] == exact["true_contacts"]
    assert accuracy["contacts"] - accuracy["false_contacts"] == accuracy["true_contacts"] - accuracy["missed_contacts"]
    if backend == "null":
        assert accuracy["missed_contacts"] == accuracy["true_contacts"]
        assert accuracy["max_depth_error_m"] is None
        assert offset["p99_inward_m"] == manifest["band_m"] and offset["open_sites"] == offset["sites"]
    if backend == "voxel":
        assert accuracy["missed_contacts"] == 0
        assert accuracy["max_depth_error_m"] is None and accuracy["max_normal_error_deg"] is None
        assert accuracy["max_false_distance_m"] < declared["false_distance_m"] < 0.1
        assert offset["max_offset_m"] < 1e-9  # the grid ends where the box does
    if backend == "sdf":
        assert 0 < accuracy["max_depth_error_m"] < 1e-3
        assert offset["max_offset_m"] < 1e-3
        assert accuracy["max_missed_depth_m"] < declared["missed_depth_m"] < 1e-2
    if backend == "fcl":  # it collides surfaces
        assert offset is None and declared["missed_depth_m"] is None
    if backend == "brute_force":
        assert offset["max_offset_m"] == 0


def test_other_positions_are_other_questions(scene, recording, tmp_path):
    """Under the same bones' poses: what drives the muscle moves it elsewhere."""
    done = record(scene, tmp_path / "free.recording", "--backend", "null")
    assert done.returncode == 0, done.stderr
    told = [replay(file, tmp_path / file.stem)[0]["queries_hash"] for file in (recording, tmp_path / "free.recording")]
    assert told[0] != told[1]


def test_threads_change_no_contact(recording, tmp_path):
    hashes = {replay(recording, tmp_path / threads, "--threads", threads)[0]["contact_hash"] for threads in "12"}
    assert len(hashes) == 1


def test_a_stride_keeps_the_last_frame(recording, tmp_path):
    told_whole, whole = replay(recording, tmp_path / "whole")
    told_part, part = replay(recording, tmp_path / "part", "--stride", 4)
    assert told_whole["queries_hash"] != told_part["queries_hash"]
    assert list(part.frame) == [4, 8, 10]
    same = whole[whole.frame.isin(part.frame)].reset_index(drop=True)
    of_the_machine = [column for column in part.columns if column.endswith("_ns")] + ["warm_up", "involuntary_switches"]
    pd.testing.assert_frame_equal(same.drop(columns=of_the_machine), part.drop(columns=of_the_machine))


def test_without_referee_errors_stay_empty(recording, tmp_path):
    manifest, frames = replay(recording, tmp_path / "out", "--no-referee")
    assert manifest["accuracy"] is None and manifest["surface_offset"] is None
    assert frames.contacts.notna().all()
    assert frames[["true_contacts", "missed_contacts", "max_depth_error_m", "mean_normal_error_deg"]].isna().all().all()


def test_a_loaded_field_says_so(recording, tmp_path):
    arguments = ("--param", "cells=8", "--param", f"structures={tmp_path / 'fields'}", "--force")
    first, second = (replay(recording, tmp_path / "out", *arguments, backend="sdf")[0] for _ in range(2))
    assert (first["structures"], second["structures"]) == ("built", "loaded")
    assert first["contact_hash"] == second["contact_hash"]


def test_a_complete_replay_is_skipped(recording, tmp_path):
    replay(recording, tmp_path / "out")
    done = call("replay", recording, "--backend", "bvh", "--out", tmp_path / "out")
    assert "complete already" in done.stdout


def test_progress_counts_both_passes(recording, tmp_path):
    done = call("replay", recording, "--backend", "brute_force", "--out", tmp_path / "out", "--progress")
    totals = {line.split()[2] for line in done.stderr.splitlines() if line.startswith("progress ")}
    assert totals <= {str(2 * FRAMES)}


def test_a_truncated_recording_is_refused(recording, tmp_path):
    cut = tmp_path / "cut.recording"
    cut.write_bytes(recording.read_bytes()[:-1000])
    assert_refused(call("replay", cut, "--backend", "bvh", "--out", tmp_path / "out"), str(cut), "truncated")
    assert not (tmp_path / "out").exists()


def test_one_changed_byte_is_refused(recording, tmp_path):
    content = bytearray(recording.read_bytes())
    content[len(content) // 2] ^= 1
    changed = tmp_path / "changed.recording"
    changed.write_bytes(content)
    sealed = content[-64:].decode()
    done = call("replay", changed, "--backend", "bvh", "--out", tmp_path / "out")
    assert_refused(done, str(changed), f"ends in {sealed}", "its hash is")


@pytest.mark.long
def test_a_recording_of_another_scene_is_refused(recording, tmp_path):
    for scene, counts in (("synthetic/adductor_brevis", "muscles 1"), ("synthetic/hip", "has 4")):
        done = call("replay", recording, "--backend", "bvh", "--out", tmp_path / "out", "--scene", scene)
        assert_refused(done, "'scene'", scene, counts, "--scene")


def test_a_recording_of_the_same_counts_is_told_by_its_hash(scene, recording, tmp_path):
    turned = tmp_path / "scene.toml"
    text = scene.read_text().replace("to_deg = 20", "to_deg = 21")
    turned.write_text(text.replace('"box.off"', f'"{scene.parent / "box.off"}"')
                      .replace('"ball.off"', f'"{scene.parent / "ball.off"}"'))
    done = call("replay", recording, "--backend", "bvh", "--out", tmp_path / "out", "--scene", turned)
    assert_refused(done, "is of another scene", "--scene")


def test_what_is_no_recording_is_refused(tmp_path):
    for name, content in (("empty", b""), ("mesh.ply", b"ply\nformat ascii 1.0\n" * 50)):
        (tmp_path / name).write_bytes(content)
        done = call("replay", tmp_path / name, "--backend", "bvh", "--out", tmp_path / "out")
        assert_refused(done, name, "not a recording")
    assert_refused(call("replay", tmp_path / "none", "--backend", "bvh", "--out", tmp_path / "out"), "cannot be read")


def test_a_full_disk_leaves_nothing(scene, tmp_path):
    def small_files_only():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (10000, 10000))

    assert_refused(record(scene, tmp_path / "a.recording", preexec_fn=small_files_only), "cannot be written")
    assert not list(tmp_path.iterdir())


def test_a_foreign_file_is_not_replaced(scene, tmp_path):
    (tmp_path / "thesis").write_text("three years")
    assert_refused(record(scene, tmp_path / "thesis"), "something else")
    assert (tmp_path / "thesis").read_text() == "three years"
    assert_refused(record(scene, tmp_path / "no/such/folder/a.recording"), "a.recording")


@pytest.mark.parametrize(("number", "leaves"), [(signal.SIGKILL, 1), (signal.SIGINT, 0), (signal.SIGTERM, 0)])
def test_a_killed_record_leaves_nothing_under_its_name(scene, tmp_path, number, leaves):
    file = tmp_path / "a.recording"
    command = [PROGRAM, "record", str(scene), "--frames", "100000", "--out", str(file)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 30
    while not list(tmp_path.glob(".a.recording.*.part")) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(number)
    process.wait(timeout=30)
    assert not file.exists()
    assert len(list(tmp_path.iterdir())) <= leaves


def test_a_blow_up_is_not_recorded(scene, tmp_path):
    done = record(scene, tmp_path / "a.recording", "--loop", "time_step_s=1000")
    assert done.returncode == 3
    assert "diverged" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_run_that_diverges_leaves_what_can_be_replayed(tmp_path):
    run = call("run", "hard/time_step", "--backend", "null", "--effect", "gravity:z_m_per_s2=-1000", "--no-effect", "damping",
               "--loop", "time_step_s=0.002", "--frames", "60", "--out", tmp_path / "run")
    assert run.returncode == 3 and "before_divergence.recording" in run.stderr
    record = json.loads((tmp_path / "run/run.json").read_text())
    assert record["status"] == "diverged" and (tmp_path / "run/frames.csv").read_text().count("\n") == 31
    replayed = call("replay", tmp_path / "run/before_divergence.recording", "--backend", "bvh", "--out", tmp_path / "replay")
    assert replayed.returncode == 0, replayed.stderr
    assert (tmp_path / "replay/frames.csv").read_text().count("\n") == 4  # a header, three frames
