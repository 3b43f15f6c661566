"""What the judge counts as passing through each other, against a count of the kept shapes that shares no code with it."""

import csv
import json
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from musclebench.results.ply import read_ply
from program import call, needs_program

pytestmark = needs_program
COLUMNS = {"bone": "bone_crossing_triangles", "muscle": "muscle_crossing_triangles", "itself": "self_intersecting_triangles"}


def exact_sign(corners) -> int:
    (a, b, c), d = [[Fraction(float(x)) for x in corner] for corner in corners[:3]], [Fraction(float(x)) for x in corners[3]]
    u, v, w = ([x - y for x, y in zip(p, d)] for p in (a, b, c))
    det = (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    return (det > 0) - (det < 0)


def sides(a, b, c, d):
    """Of each row the side of d to the plane of a, b, c."""
    u, v, w = a - d, b - d, c - d
    det = np.einsum("ij,ij->i", u, np.cross(v, w))
    size = np.abs(u).max(1) * np.abs(v).max(1) * np.abs(w).max(1)
    sign = np.sign(det).astype(int)
    for row in np.flatnonzero(np.abs(det) <= 1e-12 * size):
        sign[row] = exact_sign([p[row] for p in (a, b, c, d)])
    return sign


def piercing(points, edges, others, triangles, same):
    """Pairs of an edge and a triangle of which the one passes through the inside of the other; every pair is tried."""
    ends, corners = points[edges], others[triangles]
    meet = np.ones((len(edges), len(triangles)), bool)
    for axis in range(3):
        meet &= ends[:, :, axis].min(1)[:, None] <= corners[:, :, axis].max(1)[None]
        meet &= ends[:, :, axis].max(1)[:, None] >= corners[:, :, axis].min(1)[None]
    one, other = np.nonzero(meet)
    if same:
        apart = ~(edges[one][:, :, None] == triangles[other][:, None, :]).any((1, 2))
        one, other = one[apart], other[apart]
    p, q = points[edges[one, 0]], points[edges[one, 1]]
    a, b, c = (others[triangles[other, k]] for k in range(3))
    through = sides(a, b, c, p) * sides(a, b, c, q) < 0
    around = [sides(p, q, x, y) for x, y in ((a, b), (b, c), (c, a))]
    through &= (np.array(around) > 0).all(0) | (np.array(around) < 0).all(0)
    return one[through], other[through]


def edges_of(triangles):
    return np.unique(np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1), axis=0)


def passing(points, triangles, others, other_triangles) -> int:
    """Triangles of the first surface that pass through the second."""
    same = triangles is other_triangles
    hit = set(piercing(others, edges_of(other_triangles), points, triangles, same)[1].tolist())
    own = edges_of(triangles)
    crossing = {tuple(edge) for edge in own[piercing(points, own, others, other_triangles, same)[0]].tolist()}
    for number, triangle in enumerate(np.sort(triangles, axis=1).tolist()):
        if any(edge in crossing for edge in combinations(triangle, 2)):
            hit.add(number)
    return len(hit)


def counted(run: Path, manifest: dict, shot: dict) -> dict[str, int]:
    shape = read_ply(run / shot["file"])
    points, triangles = np.asarray(shape.vertices_m, float), np.asarray(shape.triangles)
    found, start, parts = {"bone": 0, "itself": 0}, 0, []
    for muscle in manifest.get("muscles") or [manifest["muscle"]]:
        stop = start + muscle["vertices"]
        parts.append(triangles[((triangles >= start) & (triangles < stop)).all(1)])
        start = stop
    for faces in parts:
        for bone, pose in zip(manifest["bones"], shot["bone_poses"]):
            mesh = read_ply(run / "meshes" / f"{bone['name']}.ply")
            turned = np.asarray(mesh.vertices_m, float) @ np.array(pose["rotation"]).reshape(3, 3).T + pose["translation_m"]
            free = faces[~(np.asarray(shape.extra["attached"])[faces] > 0).any(1)]
            found["bone"] += passing(points, free, turned, np.asarray(mesh.triangles))
        found["itself"] += passing(points, faces, points, faces)
    for one, other in combinations(parts, 2):
        found["muscle"] = found.get("muscle", 0) + passing(points, one, points, other)
    return found


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
    for shot in manifest["snapshots"]:
        expected = counted(out, manifest, shot)
        told = {kind: manifest["outcome"][f"{column}_at_rest"] if shot["frame"] == 0 else int(frames[shot["frame"]][column])
                for kind, column in COLUMNS.items() if kind in expected}
        assert told == expected, shot["frame"]
        seen |= {kind for kind, count in expected.items() if count}
    assert seen == kinds
