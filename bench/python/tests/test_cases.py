"""Runs, recordings and replays: what the program does, as data frames."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import ball_on_box
import numpy as np
import pytest

import musclebench

LONG_RUN = """
import sys, musclebench
scene = musclebench.load_scene("synthetic/iliacus")
print("ready", flush=True)
try:
    musclebench.run(scene, "bvh", out=sys.argv[1])
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_a_run_has_the_bits_of_the_program(scene, scene_file, program, tmp_path):
    subprocess.run([program, "run", scene_file, "--backend", "sdf", "--param", "cells=32", "--snapshots", "0,12", "--out",
                    tmp_path / "theirs"], check=True, capture_output=True)
    theirs = musclebench.read_run(tmp_path / "theirs")
    ours = musclebench.run(scene, "sdf", {"cells": 32}, snapshots=[12, 0])
    assert ours.record["state_hash"] == theirs.record["state_hash"]
    assert ours.record["run_id"] == theirs.record["run_id"]
    assert list(ours.frames.columns) == list(theirs.frames.columns)
    shapes = [musclebench.read_snapshots(run) for run in (ours, theirs)]
    assert [shape.frame for shape in shapes[0]] == [0, 12]
    assert (shapes[0][1].mesh.vertices_m == shapes[1][1].mesh.vertices_m).all()


def test_what_is_changed_is_told(scene_file):
    scene = musclebench.load_scene(scene_file, loop={"frames": 10, "substeps": 4},
                                   effects={"volume": False, "friction": {"coefficient": 0.25}})
    run = musclebench.run(scene, "bvh")
    case = run.record["case"]
    assert (case["loop"]["frames"], case["loop"]["substeps"], len(run.frames)) == (10, 4, 10)
    assert scene.effects["friction"]["coefficient"] == case["effects"]["friction"]["coefficient"] == 0.25
    assert "volume" not in case["effects"]


def test_what_a_result_lacks_is_a_warning(scene, scene_file):
    with pytest.warns(musclebench.SceneWarning, match="no forces of contacts: each node weighs 1 kg"):
        musclebench.run(scene, "bvh", forces=True)
    with pytest.warns(musclebench.SceneWarning, match="looks at contacts with bones, and 'null' finds none"):
        musclebench.run(musclebench.load_scene(scene_file, effects={"friction": True}), "null")


def test_a_wish_that_nobody_judges_is_a_warning(scene_file):
    wishing = scene_file.with_name("wishing.toml")
    wishing.write_text(scene_file.read_text() + "[wanted]\nsurface_mm = 5.0\n")
    with pytest.warns(musclebench.SceneWarning, match="what is wanted is not looked at"):
        run = musclebench.run(musclebench.load_scene(wishing), "bvh", judge=False)
    assert "wanted" in [warning["rule"] for warning in run.record["warnings"]]


def test_what_is_odd_about_a_scene_is_a_warning(tmp_path):
    ball_on_box.write_scene(tmp_path)
    text = (tmp_path / "scene.toml").read_text().replace('mesh = "ball.off"', 'mesh = "ball.off"\nunit = "mm"')
    (tmp_path / "small.toml").write_text(text)
    with pytest.warns(musclebench.SceneWarning):
        musclebench.load_scene(tmp_path / "small.toml")


def test_a_recording_is_that_of_the_program(scene, scene_file, program, tmp_path):
    musclebench.record(scene, tmp_path / "ours")
    subprocess.run([program, "record", scene_file, "--out", tmp_path / "theirs"], check=True, capture_output=True)
    ours, theirs = (musclebench.replay(tmp_path / name, "voxel") for name in ("ours", "theirs"))
    assert ours.record["queries_hash"] == theirs.record["queries_hash"]
    assert ours.record["contact_hash"] == theirs.record["contact_hash"]


def test_another_case_is_not_overwritten(scene, tmp_path):
    musclebench.run(scene, "bvh", out=tmp_path / "out")
    with pytest.raises(musclebench.InputError):
        musclebench.run(scene, "sdf", out=tmp_path / "out")
    assert musclebench.run(scene, "sdf", out=tmp_path / "out", force=True).backend == "sdf"


def test_a_result_without_a_folder_goes_with_the_run(scene):
    run = musclebench.run(scene, "bvh")
    folder = run.folder
    assert folder.is_dir()
    del run
    assert not folder.parent.exists()


@pytest.mark.parametrize("call, words", [
    (lambda scene, out: musclebench.load_scene("synthetic/iliacu"), "did you mean 'synthetic/iliacus'"),
    (lambda scene, out: musclebench.load_scene("synthetic/iliacus", effects={"frictio": True}), "did you mean 'friction'"),
    (lambda scene, out: musclebench.load_scene("synthetic/iliacus", effects={"friction": 1}), "True, False or a dict"),
    (lambda scene, out: musclebench.load_scene("synthetic/iliacus", loop={"frame": 1}), "did you mean 'frames'"),
    (lambda scene, out: musclebench.load_scene("synthetic/iliacus", loop={"frames": np.array(10.9)}), "type ndarray"),
    (lambda scene, out: musclebench.load_scene("synthetic/iliacus", fibres=-5), "are -5; give 0 to"),
    (lambda scene, out: scene.poses(13), "is not within 0 (rest) and 12"),
    (lambda scene, out: musclebench.run(scene, "bvh", snapshots=[13]), "frame 13 is not within 0 (rest) and 12"),
    (lambda scene, out: musclebench.run(scene, "bvh", threads=0), "give at least 1"),
    (lambda scene, out: musclebench.run(scene, "bvh", response="back"), "did you mean 'backtrack'"),
    (lambda scene, out: musclebench.run(scene, "bvh", colliders=["bo=sdf"]), "did you mean 'box'"),
    (lambda scene, out: musclebench.record(scene, out / "no/such/folder/steps"), "folder"),
    (lambda scene, out: musclebench.replay(out / "none", "bvh"), "none"),
    (lambda scene, out: musclebench.probe(scene, "bvh", points=0), "give at least 1"),
])
def test_bad_input_is_one_line_with_a_cure(call, words, scene, tmp_path):
    with pytest.raises(musclebench.InputError) as refused:
        call(scene, tmp_path)
    assert words in str(refused.value) and "\n" not in str(refused.value)
    assert not [path for path in tmp_path.iterdir() if path.is_file()]


def test_numbers_of_numpy_are_numbers(scene_file):
    scene = musclebench.load_scene(scene_file, loop={"time_step_s": np.float32(0.0015), "frames": np.int64(5)}, effects={"volume": np.False_})
    assert scene.loop["time_step_s"] == np.float32(0.0015) and scene.frames == 5 and "volume" not in scene.effects


def test_a_recording_finds_its_scene_from_another_folder(scene_file, tmp_path, monkeypatch):
    monkeypatch.chdir(scene_file.parent)
    musclebench.record(musclebench.load_scene("scene.toml"), tmp_path / "steps")
    monkeypatch.chdir(tmp_path)
    assert musclebench.replay("steps", "bvh").status == "ok"


FORKED = """
import multiprocessing, sys, musclebench
scene = musclebench.load_scene(sys.argv[1])
tree = musclebench.Backend("bvh", scene, threads=2)
tree.locate(scene.nodes)
def work():
    for call in (lambda: tree.locate(scene.nodes), lambda: musclebench.run(scene, "bvh", threads=2)):
        try:
            call()
        except musclebench.InputError as error:
            print(error, flush=True)
    print(musclebench.run(scene, "bvh"), flush=True)
if __name__ == "__main__":
    child = multiprocessing.get_context("fork").Process(target=work)
    child.start()
    child.join(30)
    print(child.exitcode, flush=True)
    child.kill()
"""


@pytest.mark.skipif(os.cpu_count() == 1, reason="one core has no second thread")
def test_a_forked_process_has_one_thread(scene_file):
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED, scene_file], capture_output=True, text=True, timeout=120)
    lines = done.stdout.splitlines()
    assert len(lines) == 4 and "spawn" in lines[0] and "spawn" in lines[1] and lines[2].startswith("Run(") and lines[3] == "0", done


def test_a_scene_that_leaves_its_effects_to_trials_is_refused(scene_file, tmp_path):
    text = scene_file.read_text() + '\n[wanted]\nmax_depth_mm = 1\n'
    asking = scene_file.with_name("asking.toml")
    asking.write_text('effects = "auto"\n' + text.replace("[effects.", "[effects."))
    with pytest.raises(musclebench.InputError):
        musclebench.run(musclebench.load_scene(asking), "bvh")


def test_ctrl_c_ends_a_run_with_nothing_written(tmp_path):
    running = subprocess.Popen([sys.executable, "-c", LONG_RUN, tmp_path / "out"], stdout=subprocess.PIPE, text=True)
    assert running.stdout and running.stdout.readline() == "ready\n"
    time.sleep(1.5)
    running.send_signal(signal.SIGINT)
    assert running.communicate(timeout=20)[0] == "interrupted\n"
    assert not list(tmp_path.iterdir())


def test_the_catalogue_is_the_programs(program):
    listed = json.loads(subprocess.run([program, "list", "--json"], check=True, capture_output=True, text=True).stdout)
    assert musclebench.catalogue() == listed


@pytest.mark.long
def test_types_are_those_of_the_stubs(tmp_path):
    pytest.importorskip("mypy")
    package = Path(musclebench.__file__).parent
    env = {**os.environ, "MYPYPATH": str(package.parent)}
    # What pybind11 does to every class: a metaclass of its own, and a constructor that refuses.
    (tmp_path / "allowed").write_text("".join(f"musclebench.native.{name}\n" for name in ("Backend", "Bone", "Scene", "Scene.__init__")))
    for check in (["mypy.stubtest", "musclebench.native", "--allowlist", str(tmp_path / "allowed")],
                  ["mypy", "--strict", "--follow-imports=silent", "--ignore-missing-imports", str(package / "__init__.py")]):
        done = subprocess.run([sys.executable, "-m", *check], capture_output=True, text=True, env=env, cwd="/tmp")
        assert done.returncode == 0, done.stdout + done.stderr


def test_everything_says_what_it_takes():
    for name in musclebench.__all__:
        member = getattr(musclebench, name)
        assert member.__doc__, name
    for kind in (musclebench.Backend, musclebench.Scene, musclebench.Bone):
        for name, member in vars(kind).items():
            if callable(member) and not name.startswith("_"):
                assert len(member.__doc__.splitlines()[-1]) > 20, f"{kind.__name__}.{name}"
