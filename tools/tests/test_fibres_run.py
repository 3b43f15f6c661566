"""Fibres that a run follows: the program itself, on a small scene."""

import csv
import json
import math
import os
import subprocess

import pytest

pytestmark = pytest.mark.skipif("MUSCLEBENCH_BINARY" not in os.environ, reason="MUSCLEBENCH_BINARY is not set")

SCENE = """
title = "a bar between a plate and one that turns away"

[measure]
fibres = 20

[loop]
frames = 10
substeps = 10
bone_motion = "interpolated"

[effects.attachment]
[effects.edge_length]
[effects.volume]

[[bone]]
name = "left"
mesh = "left.off"

[[bone]]
name = "right"
mesh = "right.off"
[bone.motion]
axis = [0, 0, 1]
centre_m = [0.1, 0, 0]
from_deg = 0
to_deg = 20
course = "there"

[muscle]
name = "bar"
mesh = "bar.off"
"""
ATTACHMENT = """
[[attachment]]
name = "on_{bone}"
bone = "{bone}"
outline_m = [[{x}, -0.02, -0.02], [{x}, 0.02, -0.02], [{x}, 0.02, 0.02], [{x}, -0.02, 0.02]]
distance_m = 0.001
margin_m = 0.001
"""


def box(low, high, cells):
    """OFF of a box whose faces are grids of cells[axis] cells."""
    vertices, faces = {}, []

    def vertex(point):
        return vertices.setdefault(point, len(vertices))

    def at(axis, i):
        return low[axis] + (high[axis] - low[axis]) * i / cells[axis]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    corners = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        point = [0.0, 0.0, 0.0]
                        point[axis], point[u], point[v] = at(axis, side), at(u, i + di), at(v, j + dj)
                        corners.append(vertex(tuple(point)))
                    corners = corners if side else corners[::-1]
                    faces += [(corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3])]
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(repr, point)) for point in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines) + "\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "left.off").write_text(box((-0.02, -0.03, -0.03), (0, 0.03, 0.03), (1, 1, 1)))
    (tmp_path / "right.off").write_text(box((0.1, -0.03, -0.03), (0.12, 0.03, 0.03), (1, 1, 1)))
    (tmp_path / "bar.off").write_text(box((0, -0.01, -0.01), (0.1, 0.01, 0.01), (20, 4, 4)))
    write(tmp_path)
    return tmp_path


def write(folder, scene=SCENE, bones=("left", "right")):
    attachments = "".join(ATTACHMENT.format(bone=bone, x=0.0 if bone == "left" else 0.1) for bone in bones)
    (folder / "scene.toml").write_text(scene + attachments)


def run(folder, *more, out="out"):
    return subprocess.run([os.environ["MUSCLEBENCH_BINARY"], "run", folder / "scene.toml", "--backend", "bvh", "--out",
                           folder / out, *map(str, more)], capture_output=True, text=True)


def rows(path):
    return list(csv.DictReader(path.open()))


def test_their_rows_follow_the_schema_and_theory(folder):
    done = run(folder, "--snapshots", "0,10")
    assert done.returncode == 0, done.stderr
    assert "20 fibres of bar" in done.stdout
    told = json.loads((folder / "out" / "run.json").read_text())
    assert told["case"]["fibres"] == 20
    assert told["fibres"] == [{"muscle": "bar", "asked": 20, "followed": 20}]
    assert told["memory"]["fibre_bytes"] > 0
    listed = subprocess.run([os.environ["MUSCLEBENCH_BINARY"], "list", "--json"], capture_output=True, text=True)
    schema = json.loads(listed.stdout)["results"]
    for name in ("fibres", "fibre_lengths"):
        wanted = [column["name"] for column in schema[name]["columns"]]
        assert (folder / "out" / f"{name}.csv").read_text().splitlines()[0].split(",") == wanted
    muscles, fibres = rows(folder / "out" / "fibres.csv"), rows(folder / "out" / "fibre_lengths.csv")
    assert len(muscles) == 11 and len(fibres) == 11 * 20
    assert float(muscles[0]["mean_length_m"]) == pytest.approx(0.1, abs=1e-4)
    # The axis goes through the middle of the insertion: fibres on one side of it grow longer, on the other shorter.
    assert abs(float(muscles[5]["mean_moment_arm_m"])) < 0.005
    assert float(muscles[5]["max_moment_arm_m"]) > 0.003
    assert float(muscles[5]["min_moment_arm_m"]) < -0.003
    assert all(float(row["inside_share"]) <= 1 for row in muscles)
    lines = (folder / "out" / "snapshots" / "fibres_0010.vtk").read_text()
    assert f"POINTS {20 * 17} double" in lines and "SCALARS stretch" in lines


def test_they_change_nothing_in_the_run_and_are_absent_where_nobody_asks(folder):
    assert run(folder).returncode == 0
    assert run(folder, "--fibres", 0, out="without").returncode == 0
    with_fibres, without = (json.loads((folder / out / "run.json").read_text()) for out in ("out", "without"))
    assert with_fibres["state_hash"] == without["state_hash"]
    assert "fibres" not in without and "fibres" not in without["case"] and "fibre_bytes" not in without["memory"]
    assert sorted(path.name for path in (folder / "without").iterdir()) == ["frames.csv", "run.json"]


@pytest.mark.long
def test_a_cut_table_is_not_complete(folder):
    assert run(folder).returncode == 0
    assert "complete already" in run(folder).stdout
    table = folder / "out" / "fibre_lengths.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-3]) + "\n")
    assert "complete already" not in run(folder).stdout


def assert_refused(done, *words):
    assert done.returncode == 2, done.stdout
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    for word in words:
        assert word in done.stderr


def test_bad_input_is_one_line(folder):
    write(folder, SCENE.replace("fibres = 20", "fibres = 1.5"))
    assert_refused(run(folder), "scene.toml:5: measure.fibres", "whole number")
    write(folder, SCENE.replace("fibres = 20", "fibers = 20"))
    assert_refused(run(folder), "fibers", "fibres")
    write(folder, SCENE.replace("frames = 10", "frames = 2"))
    assert_refused(run(folder), "measure.fibres", "3 frames of motion", "loop.frames")
    write(folder, SCENE.replace("to_deg = 20", "to_deg = 0"))
    assert_refused(run(folder), "measure.fibres", "none turns")
    write(folder, bones=("right",))
    assert_refused(run(folder), "measure.fibres", "muscle 'bar'", "no two ends", "all bound nodes are on bone 'right'")
    write(folder)
    assert_refused(run(folder, "--motion", "to_degrees=3"), "to_degrees", "to_deg")
    assert not (folder / "out").exists()


def test_measured_fibres_of_another_place_are_refused(folder):
    far = {"fibres": [{"muscle": "bar", "polylines_m": [[[5, 0, 0], [5.1, 0, 0]]]}]}
    (folder / "far.json").write_text(json.dumps(far))
    write(folder, SCENE + 'fibres = "far.json#bar"\n')
    done = run(folder)
    assert done.returncode == 2
    assert "muscle 'bar', fibres: leave the surface" in done.stderr.splitlines()[-1]
    assert not (folder / "out").exists()


def test_the_motion_can_be_changed(folder):
    assert run(folder, "--motion", "to_deg=-10").returncode == 0
    angles = [float(row["angle_deg"]) for row in rows(folder / "out" / "fibres.csv")]
    assert angles[-1] == pytest.approx(-10) and math.isclose(angles[0], 0)
