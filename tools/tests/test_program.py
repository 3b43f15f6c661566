"""The program as a user meets it: results, exit codes, and one clear line for bad input with nothing left behind."""

import json
import os
import re
import resource
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ball_on_box import SCENE, ball, box, off
from musclebench.results.ply import read_ply
from program import PROGRAM, call, needs_program

pytestmark = needs_program


def run(folder: Path, *arguments, scene="scene.toml", backend="sdf", **options):
    command = [PROGRAM, "run", str(folder / scene), "--backend", backend, "--out", str(folder / "out"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **options)


def assert_refused(done, folder: Path, *words):
    assert done.returncode == 2, done.stderr
    lines = [line for line in done.stderr.splitlines() if "warning" not in line]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert not (folder / "out").exists()
    assert not list(folder.glob(".out*"))


@pytest.mark.parametrize("backend", ["null", "voxel", "sdf", "fcl", "bvh", "brute_force"])
def test_every_backend_leaves_a_complete_run(folder, backend):
    done = run(folder, "--snapshots", "0,6,12", backend=backend)
    assert done.returncode == 0, done.stderr
    manifest = json.loads((folder / "out/run.json").read_text())
    frames = pd.read_csv(folder / "out/frames.csv")
    assert manifest["status"] == "suspect"  # the ball starts 1.5 mm deep in the box
    assert "before the first frame, up to 1.5 mm deep in the box" in manifest["status_detail"]
    assert ("null missed" in manifest["status_detail"]) == (backend == "null")
    assert len(frames) == manifest["frames"] == 12
    assert list(frames.frame) == list(range(1, 13))
    of_several = ["muscle_contacts", "nodes_inside_muscles", "max_muscle_depth_m", "muscle_crossing_triangles",
                  "muscle_surface_depth_m", "passed_nodes"]
    assert frames[of_several].isna().all().all()  # one muscle touches none
    of_crossings = ["self_intersecting_triangles", "bone_crossing_triangles"]
    assert frames[of_crossings].iloc[[5, 11]].notna().all().all()  # frames that are kept; others as the budget allows
    assert manifest["outcome"]["crossing_frames"] == frames[of_crossings[0]].notna().sum()
    assert frames.drop(columns=[*of_several, *of_crossings]).notna().all().all()
    collision = frames.update_ns + frames.detect_ns + frames.respond_ns
    assert (collision <= frames.frame_ns).all()
    assert frames.angle_deg[5] == pytest.approx(20)
    assert [shot["frame"] for shot in manifest["snapshots"]] == [0, 6, 12]
    shape = read_ply(folder / "out" / manifest["snapshots"][1]["file"])
    assert len(shape.vertices_m) == manifest["muscle"]["vertices"]
    assert np.isfinite(shape.vertices_m).all()
    if backend in ("sdf", "bvh", "brute_force"):
        assert frames.max_depth_m.is_monotonic_decreasing  # it began in the box, and is laid out slowly
        assert frames.max_depth_m.iloc[-1] < 1e-6  # held by the box
        assert frames.missed_contacts.sum() <= 5
    if backend == "null":
        assert frames.max_depth_m.max() > 1e-3  # it falls through
        assert "detect_ns" in frames and manifest["structure_bytes"] == 0
    if backend == "voxel":
        assert frames.missed_contacts.sum() == 0


def test_a_bone_that_a_library_does_not_take_is_no_mistake_of_the_user(folder):
    if "simbody" not in {one["name"] for one in json.loads(call("list", "--json").stdout)["backends"]}:
        pytest.skip("Simbody is not built in")
    vertices, triangles = box(0.05)
    fin = [(0, 1, len(vertices)), (0, len(vertices), 1)]  # a sheet without thickness on one edge
    (folder / "box.off").write_text(off([*vertices, (-0.2, -0.2, 0)], [*triangles, *fin]))
    done = run(folder, backend="simbody")
    assert done.returncode == 6 and "bone 'box': Simbody takes closed manifold surfaces only" in done.stderr, done.stderr
    assert not (folder / "out").exists()


def test_effects_the_scene_does_not_name_have_no_column(folder):
    (folder / "scene.toml").write_text(SCENE.replace("[effects.bending]\n", ""))
    assert run(folder).returncode == 0
    assert "bending_ns" not in pd.read_csv(folder / "out/frames.csv").columns
    assert "volume_ns" in pd.read_csv(folder / "out/frames.csv").columns


def test_the_command_line_adds_changes_and_removes_effects(folder):
    """What it says is as if the scene said it, to the bit."""
    assert run(folder, "--effect", "friction:coefficient=0.3", "--effect", "gravity:x_m_per_s2=1,z_m_per_s2=-5",
               "--no-effect", "bending").returncode == 0
    told = json.loads((folder / "out/run.json").read_text())
    (folder / "scene.toml").write_text(
        SCENE.replace("[effects.bending]\n", "").replace("[effects.gravity]", "[effects.gravity]\nx_m_per_s2 = 1\nz_m_per_s2 = -5")
        + "[effects.friction]\ncoefficient = 0.3\n")
    assert run(folder, "--force").returncode == 0
    written = json.loads((folder / "out/run.json").read_text())
    assert told["case"]["effects"] == written["case"]["effects"]
    assert told["state_hash"] == written["state_hash"] and told["run_id"] == written["run_id"]
    assert "friction_ns" in pd.read_csv(folder / "out/frames.csv").columns


def test_a_resolved_scene_ends_in_the_state_of_the_one_that_asked_for_it(folder):
    (folder / "meshes").mkdir()
    for name in ("box.off", "ball.off"):
        (folder / name).rename(folder / "meshes" / name)
    text = SCENE.replace('"box.off"', '"meshes/box.off"').replace('"ball.off"', '"meshes/ball.off"').replace("[effects.volume]\n", "")
    (folder / "scene.toml").write_text(text)
    assert run(folder, "--effects", "auto").returncode == 0
    told = json.loads((folder / "out/run.json").read_text())
    assert "volume" in [added["effect"] for added in told["added_effects"]]
    assert all(added["rule"] and added["reason"] for added in told["added_effects"])
    (folder / "elsewhere").mkdir()
    (folder / "out/resolved_scene.toml").rename(folder / "elsewhere/again.toml")
    assert run(folder, "--force", scene="elsewhere/again.toml").returncode == 0
    again = json.loads((folder / "out/run.json").read_text())
    assert again["state_hash"] == told["state_hash"] and again["case"]["effects"] == told["case"]["effects"]
    assert "added_effects" not in again
    (folder / "scene.toml").write_text(text.replace("[effects.gravity]", "[effects]\nauto = true\n[effects.gravity]"))
    assert run(folder, "--force").returncode == 0
    assert json.loads((folder / "out/run.json").read_text())["state_hash"] == told["state_hash"]
    (folder / "scene.toml").write_text(text)
    assert run(folder, "--force").returncode == 0
    assert json.loads((folder / "out/run.json").read_text())["state_hash"] != told["state_hash"]


def test_the_same_run_ends_in_the_same_state(folder):
    hashes = set()
    for threads in ("1", "2"):
        assert run(folder, "--threads", threads, "--force").returncode == 0
        hashes.add(json.loads((folder / "out/run.json").read_text())["state_hash"])
    assert len(hashes) == 1


def test_a_complete_run_is_skipped_unless_forced(folder):
    assert run(folder).returncode == 0
    written = (folder / "out/run.json").stat().st_mtime_ns
    assert "complete already" in run(folder).stdout
    assert (folder / "out/run.json").stat().st_mtime_ns == written
    assert run(folder, "--force").returncode == 0
    assert (folder / "out/run.json").stat().st_mtime_ns > written


def test_a_changed_scene_is_another_run(folder):
    attachment = """
[[attachment]]
name = "foot"
bone = "box"
outline_m = [[-0.02, -0.02, 0.03], [0.02, -0.02, 0.03], [0.0, 0.02, 0.03]]
distance_m = {}
[effects.attachment]
"""
    ids = set()
    for distance in (0.002, 0.006):
        (folder / "scene.toml").write_text(SCENE + attachment.format(distance))
        assert run(folder).returncode == 0
        ids.add(json.loads((folder / "out/run.json").read_text())["run_id"])
    assert len(ids) == 2


@pytest.mark.long
def test_shapes_that_are_kept_are_no_memory_of_the_run(tmp_path):
    """Some 6 MB of them: room for them is made before the first frame, where the Referee's is."""
    done = call("run", "synthetic/gluteus_maximus", "--backend", "voxel", "--preset", "paper", "--frames", 20, "--snapshots",
                ",".join(map(str, range(21))), "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    frames = pd.read_csv(tmp_path / "run" / "frames.csv")
    assert frames["resident_bytes"].iloc[-1] - frames["resident_bytes"].iloc[0] < 1e6


def test_numbers_read_back_to_the_same_bits(folder):
    assert run(folder).returncode == 0
    text = (folder / "out/frames.csv").read_text().splitlines()
    column = text[0].split(",").index("volume_m3")
    for line in text[1:]:
        value = line.split(",")[column]
        assert float(repr(float(value))) == float(value)
        assert len(value) >= 15


@pytest.mark.parametrize(("content", "words"), [
    (None, ["no such file"]),
    (b"", ["empty"]),
    (b"OFF\n4 4 0\n0 0 0\n1 0 0\n", ["box.off"]),
    (bytes(range(256)) * 20, ["box.off"]),
    (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", ["box.off", "7"]),
    (b"OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", ["box.off"]),
    (b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", ["box.off", "triangle"]),
])
def test_a_broken_mesh_is_refused(folder, content, words):
    (folder / "box.off").unlink()
    if content is not None:
        (folder / "box.off").write_bytes(content)
    assert_refused(run(folder), folder, "scene.toml:", *words)


@pytest.mark.parametrize(("arguments", "words"), [
    (["--backend", "sfd"], ["sfd", "voxel", "sdf"]),
    (["--param", "cels=3"], ["cels", "cells"]),
    (["--param", "cells=0"], ["cells", "0"]),
    (["--param", "cells=four"], ["cells", "four"]),
    (["--param", "cells"], ["cells", "key=value"]),
    (["--param", "cells=4", "--param", "cells=8"], ["cells=8", "twice"]),
    (["--param", "max_error_mm=1", "--param", "cells=8"], ["cells", "leave out", "max_error_mm"]),
    (["--param", "cells=4096"], ["cells", "MB"]),
    (["--preset", "papr"], ["papr", "paper"]),
    (["--loop", "substep=3"], ["substep", "substeps"]),
    (["--loop", "time_step_s=-1"], ["time_step_s", "-1"]),
    (["--effect", "gravty"], ["--effect gravty", "gravity"]),
    (["--effect", "gravity:"], ["--effect gravity:", "NAME:key=value"]),
    (["--effect", "gravity:z"], ["--effect gravity:z", "key=value"]),
    (["--effect", "friction:coefficient=-1"], ["--effect friction", "coefficient", "-1"]),
    (["--effect", "local_volume:pressure=2"], ["local_volume", "pressure", "contradict"]),
    (["--no-effect", "margin"], ["--no-effect margin", "leave the option out"]),
    (["--effects", "all"], ["--effects", "auto"]),
    (["--threads", "4096"], ["4096 threads are more than the", "cores of this machine; use at most"]),
    (["--data", "/no/such/folder"], ["/no/such/folder"]),
    (["--out", "/proc/nowhere/out"], ["/proc/nowhere/out"]),
])
def test_a_bad_option_is_refused(folder, arguments, words):
    command = [PROGRAM, "run", str(folder / "scene.toml")]
    if "--backend" not in arguments:
        command += ["--backend", "sdf"]
    if "--out" not in arguments:
        command += ["--out", str(folder / "out")]
    done = subprocess.run(command + arguments, capture_output=True, text=True, timeout=60, check=False)
    assert_refused(done, folder, *words)


LANDMARKS = """{"fibres": [{"muscle": "ball", "polylines_m": [[[0, 0, 0]]]}, {"muscle": "bell", "polylines_m": []}],
"attachments": []}"""


@pytest.mark.parametrize(("find", "replace", "words"), [
    ("[effects.bending]", "[effects.bendng]", ["scene.toml:19: effects.bendng", "did you mean 'bending'?"]),
    ("[effects.bending]", "[effects]\nbendng = false", ["scene.toml:20: effects.bendng", "did you mean 'bending'?"]),
    ("[effects.bending]", "[effects.friction]\ncoefficient = -1", ["scene.toml:20: effects.friction", "coefficient", "0 to 10"]),
    ("[effects.bending]", "[effects.friction]\ncoeficient = 1", ["scene.toml:20:", "coeficient", "did you mean 'coefficient'?"]),
    ("[effects.bending]", "[effects]\nfriction = 0.3", ["scene.toml:20: effects.friction", "write [effects.friction]"]),
    ("[effects.bending]", "[effects.local_volume]\npressure = 2", ["effects.local_volume", "contradict each other", "volume = false"]),
    ('"ball.off"', '"ball.off"\nfibres = "between_attachment"', ["scene.toml:14: muscle.fibres", "did you mean 'between_attachments'?"]),
    ('"ball.off"', '"ball.off"\nfibres = "no.json#ball"', ["scene.toml:14: muscle.fibres", "no.json", "no such file"]),
    ('"ball.off"', '"ball.off"\nfibres = "marks.json#boll"', ["scene.toml:14: muscle.fibres", "'boll'", "did you mean 'b"]),
    ('"ball.off"', '"ball.off"\nfibres = "marks.json#ball"', ["scene.toml:14: muscle.fibres", "no fibre of two points"]),
    ('"ball.off"', '"ball.off"\nfibres = "box.off#ball"', ["scene.toml:14: muscle.fibres", "box.off"]),
    ("[[bone]]", 'preset = "papr"\n[[bone]]', ["scene.toml:3: preset", "'papr'", "did you mean 'paper'?"]),
])
def test_a_bad_scene_is_refused_with_file_key_and_cure(folder, find, replace, words):
    (folder / "marks.json").write_text(LANDMARKS)
    (folder / "scene.toml").write_text(SCENE.replace(find, replace, 1))
    assert_refused(run(folder), folder, *words)


def test_bad_command_lines_exit_with_2(folder):
    for arguments in ([], ["rum"], ["run"], ["run", "x.toml"], ["run", "nowhere", "--backend", "sdf"], ["check"]):
        done = call(*arguments)
        assert done.returncode == 2, arguments
        assert done.stderr
    assert call("--help").returncode == 0


def test_a_full_disk_leaves_nothing(folder):
    def small_files_only():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = run(folder, preexec_fn=small_files_only)
    assert_refused(done, folder, "cannot be written")


def test_a_foreign_folder_is_not_replaced(folder):
    (folder / "out").mkdir()
    (folder / "out/thesis.txt").write_text("three years")
    done = run(folder)
    assert done.returncode == 2
    assert "something else" in done.stderr
    assert (folder / "out/thesis.txt").read_text() == "three years"


@pytest.mark.parametrize("manifest", ["{}", '{"run_id": 5}', '{"run_id": "x", "status": "ok"}'])
def test_a_folder_with_more_than_a_run_is_not_replaced(folder, manifest):
    (folder / "out").mkdir()
    (folder / "out/run.json").write_text(manifest)
    (folder / "out/thesis.txt").write_text("three years")
    assert run(folder, "--force").returncode == 2
    assert (folder / "out/thesis.txt").read_text() == "three years"


def test_the_current_folder_is_not_replaced(folder):
    assert run(folder).returncode == 0
    command = [PROGRAM, "run", str(folder / "scene.toml"), "--backend", "null", "--out", "."]
    done = subprocess.run(command, cwd=folder / "out", capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert (folder / "out/run.json").exists()


def test_a_refused_run_removes_the_folders_it_made(folder):
    done = run(folder, "--param", "cells=4096", "--out", str(folder / "a/b/c"))
    assert done.returncode == 2
    assert not (folder / "a").exists()


def test_names_are_no_paths(folder):
    (folder / "scene.toml").write_text(SCENE.replace('name = "box"', 'name = "../box"'))
    assert_refused(run(folder, "--snapshots", "0"), folder, "scene.toml:", "name", "../box")


def test_an_incomplete_run_is_run_again(folder):
    assert run(folder).returncode == 0
    (folder / "out/frames.csv").unlink()
    assert run(folder).returncode == 0
    assert (folder / "out/frames.csv").exists()


def test_odd_scenes_are_warned_of(folder):
    vertices, triangles = ball(0.02, [0.005, 0, 0.0485])
    (folder / "ball.off").write_text(off(vertices, triangles[1:]))
    (folder / "scene.toml").write_text(SCENE.replace("from_deg = 0", "from_deg = 5"))
    errors = run(folder, backend="null").stderr
    assert "volume" in errors and "boundary edges" in errors
    assert "starts at 5 degrees" in errors


def test_warnings_are_in_the_result_and_a_wrong_unit_is_no_ok_run(folder):
    done = run(folder, backend="bvh")
    [overlap] = json.loads((folder / "out/run.json").read_text())["warnings"]
    assert overlap["rule"] == "overlap_with_bone" and overlap["text"] in done.stderr
    vertices, triangles = ball(20, [5, 0, 48.5])
    (folder / "ball.off").write_text(off(vertices, triangles))
    done = run(folder, "--force", backend="bvh")
    manifest = json.loads((folder / "out/run.json").read_text())
    [warning] = [each for each in manifest["warnings"] if each["rule"] == "unit"]
    assert "millimetres" in warning["text"] and warning["text"] in done.stderr
    assert manifest["status"] == "suspect" and warning["text"] in manifest["status_detail"]


def test_a_blow_up_keeps_its_rows(folder):
    (folder / "scene.toml").write_text(
        SCENE.replace("[effects.gravity]", "[effects.gravity]\nz_m_per_s2 = -1e6\n")
        .replace("substeps = 2", "substeps = 2\ntime_step_s = 0.01"))
    done = run(folder, backend="null")
    assert done.returncode == 3
    assert "frame" in done.stderr
    manifest = json.loads((folder / "out/run.json").read_text())
    assert manifest["status"] == "diverged"
    assert "frame" in manifest["status_detail"]
    text = (folder / "out/frames.csv").read_text()
    assert len(text.splitlines()) == manifest["frames"] + 1
    assert "nan" not in text and "inf" not in text


def test_an_interrupted_run_keeps_its_rows(folder):
    process = subprocess.Popen([PROGRAM, "run", str(folder / "scene.toml"), "--backend", "voxel", "--frames", "9999999",
                                "--out", str(folder / "out"), "--progress"], stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        if line.startswith("progress ") and int(line.split()[1]) >= 3:
            break
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "its rows are kept" in errors
    manifest = json.loads((folder / "out/run.json").read_text())
    assert manifest["status"] == "interrupted" and "of 9999999" in manifest["status_detail"]
    assert len(pd.read_csv(folder / "out/frames.csv")) == manifest["frames"] >= 3
    assert not list(folder.glob(".out*"))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_run_inside_its_frame(folder, number):
    """Half a million substeps are left of the second frame when it comes."""
    (folder / "scene.toml").write_text(re.sub(r"\[effects[^[]*", "", SCENE))
    process = subprocess.Popen([PROGRAM, "run", str(folder / "scene.toml"), "--backend", "null", "--frames", "5", "--loop", "substeps=500000",
                                "--no-referee", "--out", str(folder / "out"), "--progress"], stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        if line.split()[:2] == ["progress", "1"]:
            break
    time.sleep(0.1)  # so that it is in the second frame
    process.send_signal(number)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130 and "its rows are kept" in errors
    manifest = json.loads((folder / "out/run.json").read_text())
    assert manifest["status"] == "interrupted"
    assert re.fullmatch(r"in frame 2 of 5, substep \d+ of 500000", manifest["status_detail"])
    assert len(pd.read_csv(folder / "out/frames.csv")) == manifest["frames"] == 1
    assert not list(folder.glob(".out*"))


def catches(pid: int, number: int) -> bool:
    caught = Path(f"/proc/{pid}/status").read_text().split("SigCgt:")[1].split()[0]
    return bool(int(caught, 16) >> (number - 1) & 1)


def test_ctrl_c_ends_a_long_build(folder):
    process = subprocess.Popen([PROGRAM, "run", str(folder / "scene.toml"), "--backend", "sdf", "--param", "cells=300",
                                "--out", str(folder / "deep/er/out")], stderr=subprocess.PIPE, text=True)
    while not catches(process.pid, signal.SIGINT):
        assert process.poll() is None
        time.sleep(0.02)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=120)
    assert process.returncode == 130
    assert not (folder / "deep").exists()


def test_another_runs_results_are_not_replaced_unless_forced(folder):
    assert run(folder).returncode == 0
    before = (folder / "out/run.json").read_text()
    for arguments, word in ((("--param", "cells=8"), "'cells'"), (("--frames", "5"), "'frames'")):
        done = run(folder, *arguments)
        assert done.returncode == 2
        assert "another case" in done.stderr and word in done.stderr and "--force" in done.stderr
    assert run(folder, backend="null").returncode == 2
    assert (folder / "out/run.json").read_text() == before
    assert run(folder, "--force", backend="null").returncode == 0
    assert (folder / "out/run.json").read_text() != before


def stl(vertices, triangles) -> bytes:
    corners = np.asarray(vertices)[np.asarray(triangles)].astype("<f4")
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
    facets["corners"] = corners
    return bytes(80) + np.uint32(len(corners)).tobytes() + facets.tobytes()


def obj_with_seam(vertices, triangles) -> str:
    """Half of the surface has vertices of its own, as where a texture has its edge."""
    lines = [f"v {float(x)!r} {float(y)!r} {float(z)!r}" for x, y, z in [*vertices, *vertices]]
    shift = [len(vertices) + 1 if i < len(triangles) // 2 else 1 for i in range(len(triangles))]
    return "\n".join(lines + [f"f {a + s} {b + s} {c + s}" for (a, b, c), s in zip(triangles, shift)]) + "\n"


def test_a_muscle_is_the_same_in_every_format(folder):
    vertices, triangles = ball(0.02, [0.005, 0, 0.0485])
    vertices = vertices.astype("f4").astype(float)  # what STL can hold
    written = {"off": off(vertices, triangles).encode(), "stl": stl(vertices, triangles),
               "obj": obj_with_seam(vertices, triangles).encode()}
    results = {}
    for ending, content in written.items():
        (folder / f"ball.{ending}").write_bytes(content)
        (folder / "scene.toml").write_text(SCENE.replace("ball.off", f"ball.{ending}"))
        done = run(folder, "--snapshots", "0,12", "--force", backend="bvh")
        assert done.returncode == 0, done.stderr
        assert "merged" not in done.stderr, "vertices of an STL at one position are no defect"
        manifest = json.loads((folder / "out/run.json").read_text())
        last = read_ply(folder / "out/snapshots/frame_0012.ply")
        rest = read_ply(folder / "out/snapshots/frame_0000.ply")
        assert manifest["muscle"]["vertices"] == len(rest.vertices_m)
        in_file = {"off": vertices, "stl": vertices[np.array(triangles)].reshape(-1, 3), "obj": [*vertices, *vertices]}
        assert np.array_equal(rest.vertices_m, in_file[ending])
        results[ending] = (manifest["muscle"]["nodes"], manifest["muscle"]["rest_volume_m3"], rest, last)
    nodes, volume, rest, last = results["off"]
    assert nodes == len(vertices)
    for ending in ("stl", "obj"):
        assert results[ending][0] == nodes
        assert results[ending][1] == pytest.approx(volume, rel=1e-12)
        # Snapshots have the file's vertices in the file's order; corners at one position stay at one.
        place = {tuple(position): i for i, position in enumerate(rest.vertices_m)}
        same = [place[tuple(position)] for position in results[ending][2].vertices_m]
        moved = results[ending][3].vertices_m
        for node in range(nodes):
            assert np.ptp(moved[[i for i, n in enumerate(same) if n == node]], axis=0).max() == 0
        assert np.abs(moved - last.vertices_m[same]).max() < 1e-3  # constraints in another order


def test_words_that_are_nearly_right_are_suggested(folder):
    for arguments, word in ((("rnu",), "'run'"), (("run", "x.toml", "--bakend", "sdf"), "'--backend'"),
                            (("check", "x.toml", "--dta=x"), "'--data'"), (("run", "x", "--backend", "sfd"), "'sdf'")):
        done = call(*arguments)
        assert done.returncode == 2 and "did you mean " + word in done.stderr, done.stderr
    for arguments in (("check",), ("run", "--backend", "sdf")):
        done = call(arguments[0], "scene", *arguments[1:], cwd=folder)
        assert done.returncode == 2 and "did you mean 'scene.toml'" in done.stderr


def test_check_goes_on_past_an_empty_attachment(folder):
    attachments = """
[[attachment]]
name = "foot"
bone = "box"
outline_m = [[-0.02, -0.02, 0.03], [0.02, -0.02, 0.03], [0.0, 0.02, 0.03]]
distance_m = 0.00001
"""
    (folder / "scene.toml").write_text(SCENE.replace('"ball.off"', '"ball.off"\nfibres = "between_attachments"')
                                       + attachments)
    done = call("check", folder / "scene.toml")
    assert done.returncode == 2, done.stderr
    for words in ("attachment 'foot' binds no node: the nearest is", "can't be run:", "attachment foot: 0 nodes"):
        assert words in done.stdout
    assert_refused(run(folder), folder, "between_attachments", "attachment 'foot' binds no node")


def test_a_run_is_suspect_whose_attachment_is_in_millimetres_or_binds_nothing(folder):
    for outline, distance, reason in (
            ("[[-20, -20, 30], [20, -20, 30], [0, 20, 30]]", "0.002", "its outline is .* m away from the scene"),
            ("[[-0.02, -0.02, 0.03], [0.02, -0.02, 0.03], [0.0, 0.02, 0.03]]", "2.0", "distance_m or margin_m is 2 m"),
            ("[[-0.02, -0.02, 0.03], [0.02, -0.02, 0.03], [0.0, 0.02, 0.03]]", "0.00001", "binds no node")):
        (folder / "scene.toml").write_text(
            SCENE + f'\n[[attachment]]\nname = "foot"\nbone = "box"\noutline_m = {outline}\ndistance_m = {distance}\n')
        done = run(folder, "--force")
        record = json.loads((folder / "out" / "run.json").read_text())
        assert done.returncode == 0 and record["status"] == "suspect", done.stderr
        assert re.search(f"attachment 'foot'.*{reason}", record["status_detail"]), record["status_detail"]


def in_millimetres(path: Path) -> None:
    """An OFF file: a line of counts, the vertices, the faces."""
    head, counts, *lines = path.read_text().splitlines()
    vertices = int(counts.split()[0])
    scaled = [" ".join(repr(1000 * float(word)) for word in line.split()) for line in lines[:vertices]]
    path.write_text("\n".join([head, counts, *scaled, *lines[vertices:]]) + "\n")


def test_the_line_that_check_proposes_mends_a_mesh_in_millimetres(folder):
    as_it_was = json.loads(call("check", folder / "scene.toml", "--json").stdout)
    in_millimetres(folder / "ball.off")
    assert "its unit is likely millimetres: write unit = \"mm\"" in call("check", folder / "ball.off").stdout
    told = call("check", folder / "scene.toml").stdout
    line, proposed = re.search(r"muscle 'ball' is .* write (unit = \"mm\") in its table \(\S+:(\d+)\)", told).group(2, 1)
    lines = (folder / "scene.toml").read_text().splitlines()
    assert lines[int(line) - 1] == "[muscle]"
    (folder / "scene.toml").write_text("\n".join([*lines[:int(line)], proposed, *lines[int(line):]]) + "\n")
    mended = json.loads(call("check", folder / "scene.toml", "--json").stdout)
    assert [warning["text"] for warning in mended["warnings"]] == [warning["text"] for warning in as_it_was["warnings"]]


@pytest.mark.parametrize("device", ["pipe", "/dev/zero"])
def test_a_scene_that_never_ends_is_refused(folder, device):
    (folder / "scene.toml").unlink()
    if device == "pipe":
        os.mkfifo(folder / "scene.toml")
    else:
        (folder / "scene.toml").symlink_to(device)
    assert_refused(run(folder), folder, "scene.toml", "no regular file")


def test_six_runs_at_once_make_their_folders_below_a_new_one(folder):
    command = [PROGRAM, "run", folder / "scene.toml", "--backend", "null", "--loop", "frames=1", "--out"]
    runs = [subprocess.Popen([*command, folder / f"new/x/r{number}"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            for number in range(6)]
    told = [run.communicate()[1] for run in runs]
    assert [run.returncode for run in runs] == [0] * 6, told
    assert sorted(path.name for path in (folder / "new/x").iterdir()) == [f"r{number}" for number in range(6)]


def test_check_and_list_speak(folder):
    checked = call("check", folder / "scene.toml")
    assert checked.returncode == 0
    assert "overlap with box at rest" in checked.stdout
    told = json.loads(call("check", folder / "scene.toml", "--json", "--backend", "voxel", "--param", "cells=8").stdout)
    assert told["scene"] == "scene" and told["obstacles"] == [] and told["added_effects"] == []
    assert {finding["id"] for finding in told["findings"]} >= {"surface_contact", "grid_cells"}
    for finding in told["findings"]:
        assert set(finding) == {"id", "kind", "place", "where", "what", "figures", "add", "remove", "effect"}
        assert finding["place"].startswith(str(folder / "scene.toml"))
        assert f"[{finding['id']}]: {finding['place']}: {finding['where']}: " in call("check", folder / "scene.toml", "--backend", "voxel",
                                                                  "--param", "cells=8").stdout
    assert call("check", folder / "box.off", "--json").returncode == 2
    mesh = call("check", folder / "box.off")
    assert "no defects" in mesh.stdout
    listed = call("list").stdout
    for word in ("voxel", "cells", "bending", "synthetic/iliacus", "paper", "standard", "time_step_s"):
        assert word in listed


def test_a_bone_that_a_library_can_not_take_is_unsupported(folder):
    """Exit code 6, by which a study tells it from a mistake."""
    if "openvdb" not in {backend["name"] for backend in json.loads(call("list", "--json").stdout)["backends"]}:
        pytest.skip("the program has no openvdb")
    done = run(folder, "--param", "voxel_size_m=1", backend="openvdb")
    assert done.returncode == 6 and "is too coarse" in done.stderr and not (folder / "out").exists()
