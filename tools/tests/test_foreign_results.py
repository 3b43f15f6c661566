"""Results and inputs as they are found in a folder: suspect, cut, or put there by others."""

import json
import os

import pytest

from ball_on_box import ball, off
from musclebench.results.damage import damage
from program import call, needs_program

PROBED = [{"name": "femur"}, {"name": "pelvis"}]


def run(folder, *arguments):
    return call("run", folder / "scene.toml", "--backend", "null", "--out", folder / "out", *arguments)


@pytest.fixture
def overlapping(folder):
    """A scene whose run is suspect: the muscle lies in the bone before anything moves."""
    (folder / "ball.off").write_text(off(*ball(0.02, [0.005, 0, 0.02])))
    return folder


@needs_program
def test_strict_is_as_strict_with_a_result_that_is_there_already(overlapping):
    done = run(overlapping)
    assert done.returncode == 0 and "suspect: " in done.stderr, done.stderr
    assert json.loads((overlapping / "out/run.json").read_text())["status"] == "suspect"
    again = run(overlapping)
    assert again.returncode == 0 and "complete already" in again.stdout and "before the first frame" in again.stderr
    strict = run(overlapping, "--strict")
    assert strict.returncode == 1 and "complete already" in strict.stdout and "suspect: " in strict.stderr
    assert run(overlapping, "--strict", "--force").returncode == 1


@needs_program
def test_strict_is_refused_where_nothing_is_judged(folder):
    done = run(folder, "--strict", "--no-referee")
    assert done.returncode == 2 and "--no-referee" in done.stderr and len(done.stderr.splitlines()) == 1


@needs_program
def test_strict_accepts_a_run_that_is_ok(folder):
    (folder / "ball.off").write_text(off(*ball(0.02, [0.2, 0, 0.05])))
    for words in ((), ("complete already",)):
        done = run(folder, "--strict")
        assert done.returncode == 0 and all(word in done.stdout for word in words), done.stderr


@needs_program
@pytest.mark.parametrize("lines", [0, 1, 5, 12])
def test_a_cut_table_is_no_complete_run(folder, lines):
    assert run(folder).returncode == 0
    whole = (folder / "out/frames.csv").read_text().splitlines(keepends=True)
    (folder / "out/frames.csv").write_text("".join(whole[:lines]))
    done = run(folder)
    assert done.returncode == 0 and "complete already" not in done.stdout, done.stderr
    assert len((folder / "out/frames.csv").read_text().splitlines()) == len(whole) == 13
    assert "complete already" in run(folder).stdout


@needs_program
def test_a_cut_probe_is_no_complete_probe(folder):
    def probe():
        return call("probe", folder / "scene.toml", "--backend", "bvh", "--points", "50", "--out", folder / "out")

    assert probe().returncode == 0
    assert "complete already" in probe().stdout
    (folder / "out/probe.csv").write_text("".join((folder / "out/probe.csv").read_text().splitlines(keepends=True)[:3]))
    done = probe()
    assert done.returncode == 0 and "complete already" not in done.stdout, done.stderr


@needs_program
@pytest.mark.parametrize("force", [(), ("--force",)])
def test_a_pipe_in_place_of_a_record_is_refused(folder, force):
    (folder / "out").mkdir()
    os.mkfifo(folder / "out/run.json")
    done = run(folder, *force)
    assert done.returncode == 2 and "holds something else than a run" in done.stderr, done.stderr


@needs_program
def test_a_pipe_in_place_of_landmarks_is_refused(folder):
    os.mkfifo(folder / "landmarks.json")
    scene = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(scene.replace('"ball.off"', '"ball.off"\nfibres = "landmarks.json#ball"'))
    done = run(folder)
    assert done.returncode == 2 and "landmarks.json" in done.stderr and "pipe" in done.stderr, done.stderr


def write_result(folder, table, text, case, **told):
    (folder / "run.json").write_text(json.dumps({"status": "ok", "case": case, **told}))
    (folder / table).write_text(text)


@pytest.mark.parametrize("text, words", [
    ("bone,region\n" + 6 * "femur,all\n", ""), ("bone,region\n" + 5 * "femur,all\n", "probe.csv has 5 of 6 rows"),
    ("bone,region\n" + 5 * "femur,all\n" + "pel", "probe.csv has 5 of 6 rows"), ("", "probe.csv has 0 of 6 rows"),
])
def test_damage_of_a_probe(tmp_path, text, words):
    write_result(tmp_path, "probe.csv", text, {"mode": "probe"}, probed=PROBED)
    assert damage(tmp_path) == words


@pytest.mark.parametrize("rows, recording, words", [
    ((1, 2, 3), None, ""), ((1, 2, 2), None, "frames.csv ends with frame 2, not 3"),
    ((4, 8, 10), {"frames": 10}, ""), ((2, 4, 8), {"frames": 10}, "frames.csv ends with frame 8, not 10"),
    ((1, 2), None, "frames.csv has 2 of 3 rows"),
])
def test_damage_of_frames(tmp_path, rows, recording, words):
    text = "frame,angle_deg\n" + "".join(f"{row},0.5\n" for row in rows)
    told = {"frames": 3} | ({"recording": recording} if recording else {})
    write_result(tmp_path, "frames.csv", text, {"mode": "replay" if recording else "coupled"}, **told)
    assert damage(tmp_path) == words
