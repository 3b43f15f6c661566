"""What the judge counts as passing through each other, against a count of the kept shapes that shares no code with it."""

import csv
import json

import pytest

from musclebench.stress.judge import counted, shapes_of
from program import call, needs_program

pytestmark = needs_program
COLUMNS = {"bone": "bone_crossing_triangles", "muscle": "muscle_crossing_triangles", "itself": "self_intersecting_triangles"}


@pytest.mark.parametrize("scene, backend, kinds", [
    ("effects/muscle_contact", "bvh", {"muscle"}), ("effects/multi_bone", "bvh", {"bone"}),
    ("hard/face_over_edge", "null", {"bone"}), ("effects/bending", "bvh", set())])
def test_crossings_are_those_of_another_count(tmp_path, scene, backend, kinds):
    out = tmp_path / "run"
    done = call("run", scene, "--backend", backend, "--snapshots", "0,8,16", "--out", out)
    assert done.returncode == 0, done.stderr
    manifest = json.loads((out / "run.json").read_text())
    frames = {int(row["frame"]): row for row in csv.DictReader((out / "frames.csv").open())}
    seen = set()
    for shape in shapes_of(out, manifest):
        expected = counted(shape)
        told = {kind: manifest["outcome"][f"{column}_at_rest"] if shape.frame == 0 else int(frames[shape.frame][column])
                for kind, column in COLUMNS.items() if kind in expected}
        assert told == expected, shape.frame
        seen |= {kind for kind, count in expected.items() if count}
    assert seen == kinds
