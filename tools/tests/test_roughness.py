"""Roughness against shapes whose angles are known."""

import json

import numpy as np
import pytest

import fake_registry
import fake_runs
from musclebench.figures import looks
from musclebench.results.ply import PlyMesh
from musclebench.results.roughness import free_nodes_near, inner_edges, roughness_deg, turns_deg
from musclebench.results.run_folder import read_run
from musclebench.tables.smoothness_table import smoothness_table

ROLES = fake_registry.roles()
FRAMES = 10


def strip(turn_deg: float, rows: int = 6) -> PlyMesh:
    """Squares of two triangles each, in a row that turns by an angle at every second seam."""
    angle, points, place, sign = 0.0, [], np.zeros(3), 1
    for row in range(rows + 1):
        points += [place, place + [0, 0.01, 0]]
        place = place + 0.01 * np.array([np.cos(angle), 0, np.sin(angle)])
        angle += sign * np.radians(turn_deg)
        sign = -sign
    triangles = [corners for row in range(rows)
                 for corners in ((2 * row, 2 * row + 2, 2 * row + 1), (2 * row + 1, 2 * row + 2, 2 * row + 3))]
    vertices = np.array(points)
    return PlyMesh(vertices, np.array(triangles), {"attached": np.zeros(len(vertices), "u1")})


@pytest.mark.parametrize("turn_deg", [0.0, 1e-6, 30.0, 120.0])
def test_a_folded_strip_has_the_angle_of_its_folds(turn_deg):
    mesh = strip(turn_deg)
    edges, pairs = inner_edges(mesh.triangles)
    assert len(edges) == 11  # five seams, six diagonals
    seams = np.abs(edges[:, 0] - edges[:, 1]) == 1
    turns = turns_deg(mesh.vertices_m, mesh.triangles, pairs)
    across_a_seam = (edges[:, 0] // 2 == edges[:, 1] // 2) & seams
    assert turns[across_a_seam] == pytest.approx(turn_deg, rel=1e-6, abs=1e-9)
    assert turns[~across_a_seam] == pytest.approx(0, abs=1e-9)
    every = np.ones(len(mesh.vertices_m), bool)
    assert roughness_deg(mesh, every) == pytest.approx(turn_deg * np.sqrt(5 / 11), rel=1e-6, abs=1e-9)


def test_a_finer_ball_is_smoother_and_its_size_says_nothing():
    coarse, fine = (fake_runs.sphere((0, 0, 0), 0.05, rings) for rings in (10, 20))

    def rough(body, factor=1.0):
        mesh = PlyMesh(factor * body.vertices_m, body.triangles, {})
        return roughness_deg(mesh, np.ones(len(body.vertices_m), bool))
    assert rough(fine) == pytest.approx(rough(coarse) / 2, rel=0.1)
    assert rough(fine, 1000.0) == pytest.approx(rough(fine), rel=1e-9)


def test_edges_of_holes_triangles_without_area_and_bound_nodes_are_left_out():
    mesh = strip(30.0)
    mesh.vertices_m[1] = mesh.vertices_m[0]  # the first triangle has no area
    every = np.ones(len(mesh.vertices_m), bool)
    assert np.isfinite(roughness_deg(mesh, every))
    assert np.isnan(roughness_deg(mesh, ~every))
    mesh.extra["attached"][:6] = 1
    near = free_nodes_near(mesh, mesh.vertices_m[[0, 7]], 0.005)
    assert np.flatnonzero(near).tolist() == [7]


def test_a_rough_backend_is_told_from_the_exact_run(tmp_path):
    """Of the same edges; the run that starts off by rounding has no row, but is the bar."""
    looks.know(fake_registry.registry())
    ball, bone = fake_runs.sphere((0, 0, 0.05), 0.05), fake_runs.sphere((0, 0, -0.05), 0.05)
    noise = np.random.default_rng(1).normal(size=ball.vertices_m.shape)
    spread_m = {ROLES.unit: 1e-3, ROLES.exact: 0.0, "floor": 1e-5}
    for name, spread in spread_m.items():
        shots = [fake_runs.Snapshot(frame, angle, ball.vertices_m + (spread * noise if frame else 0), np.zeros(len(noise)),
                                    np.zeros(len(noise), "u1"), [(np.eye(3), np.zeros(3))] * 2) for frame, angle in ((0, 0), (5, 90), (10, 0))]
        backend = name if name != "floor" else ROLES.exact
        fake_runs.write_run(tmp_path / name, "synthetic/iliacus", backend, FRAMES, bones={"pelvis": bone, "femur": bone},
                            triangles=ball.triangles, snapshots=shots, loop={"start_noise_m": 1e-12} if name == "floor" else None)
    table = smoothness_table([read_run(tmp_path / name) for name in spread_m])
    rows = table.rows.set_index("backend")
    assert list(rows.index) == [ROLES.unit, ROLES.exact] and 0 < rows["nodes"].iloc[0] < len(noise) / 2
    assert rows.loc[ROLES.exact, "over_exact"] == 1 and rows.loc[ROLES.exact, "rms_mm"] == 0
    assert rows.loc[ROLES.unit, "over_exact"] > 2 and 0 < rows.loc[ROLES.unit, "floor_percent"] < 5
    assert (rows["rest_deg"] == rows["rest_deg"].iloc[0]).all() and (rows["angle_deg"] == 90).all()
    assert smoothness_table([read_run(tmp_path / ROLES.unit)]) is None
    assert json.loads((tmp_path / "floor" / "run.json").read_text())["case"]["loop"] == {"start_noise_m": 1e-12}
