"""Distances between shapes, and what coupled runs did to the muscle."""

import json
import math

import numpy as np
import pytest

import fake_registry
import fake_runs
import fake_study
from fake_study import SCENES, Truth, write_coupled
from musclebench.accuracy import cases, shapes
from musclebench.accuracy.aggregates import aggregates_of, find
from musclebench.accuracy.configurations import configuration
from musclebench.results import ply
from musclebench.tables import outcomes


def mesh_of(body):
    return ply.PlyMesh(np.asarray(body.vertices_m, dtype=float), np.asarray(body.triangles), {})


def square(height_m, half_m=1.0):
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * half_m + [0, 0, height_m]
    return ply.PlyMesh(corners.astype(float), np.array([[0, 1, 2], [0, 2, 3]]), {})


def test_distances_of_parallel_squares_and_of_spheres():
    assert ply.rms_distance_m(square(0), square(0.25)) == pytest.approx(0.25)
    assert shapes.hausdorff_distance_m(square(0), square(0.25)) == pytest.approx(0.25, rel=1e-6)
    small, large = (mesh_of(fake_runs.sphere((0, 0, 0), r, rings=24)) for r in (1.0, 1.5))
    assert shapes.hausdorff_distance_m(small, large) == pytest.approx(0.5, rel=1e-3)
    assert ply.rms_distance_m(small, large) == pytest.approx(0.5)


def test_the_hausdorff_distance_is_symmetric_and_to_the_surface():
    inner, outer = square(0.1, half_m=0.5), square(0.0, half_m=2.0)
    far = math.hypot(math.hypot(1.5, 1.5), 0.1)
    assert shapes.hausdorff_distance_m(inner, outer) == pytest.approx(far, rel=1e-6)
    assert shapes.hausdorff_distance_m(outer, inner) == pytest.approx(far, rel=1e-6)
    # The same square in finer triangles: no distance to the surface, half an edge from vertex to vertex.
    finer = np.array([[0, 0, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    fan = ply.PlyMesh(finer, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]), {})
    assert shapes.hausdorff_distance_m(square(0), fan) == pytest.approx(0, abs=1e-12)


def test_shapes_of_different_nodes_have_no_rms():
    assert math.isnan(ply.rms_distance_m(square(0), mesh_of(fake_runs.sphere((0, 0, 0), 1.0))))
    broken = square(0)
    broken.vertices_m[0] = math.nan
    assert math.isnan(shapes.hausdorff_distance_m(broken, square(0)))


@pytest.fixture
def coupled(tmp_path):
    raw = tmp_path / "raw"
    write_coupled(raw / "e", SCENES[0], "bvh", Truth(15, remaining_mm=0.02))
    for repetition in range(2):
        write_coupled(raw / f"s{repetition}", SCENES[0], "sdf", Truth(0.3, noise=0, remaining_mm=0.1, shift_mm=0.7,
                                                                     parameters={"cells": 64}), repetition)
    write_coupled(raw / "n", SCENES[0], "null", Truth(0.0005, remaining_mm=9, shift_mm=4, structure_bytes=0))
    return tmp_path


def test_outcomes_are_compared_with_the_exact_runs_shape(coupled):
    aggregates = aggregates_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(aggregates, outcomes.shape_distances(aggregates), []).rows.set_index("configuration")
    assert rows.loc["sdf 64", "full_rms_mm"] == pytest.approx(0.7) and rows.loc["bvh", "full_rms_mm"] == 0
    assert 0.55 < rows.loc["sdf 64", "final_hausdorff_mm"] <= 0.7 + 1e-9
    assert rows.loc["sdf 64", "node_depth_mm"] == pytest.approx(0.12)
    assert rows.loc["sdf 64", "collision_s"] == pytest.approx(0.3e-3 * fake_study.FRAMES)
    assert rows.loc["sdf 64", "max_volume_percent"] == pytest.approx(2)


def test_without_an_exact_run_shapes_stay_unknown(coupled):
    path = coupled / "raw" / "e" / "run.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"status": "diverged"}))
    aggregates = aggregates_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(aggregates, outcomes.shape_distances(aggregates), []).rows.set_index("configuration")
    assert math.isnan(rows.loc["sdf 64", "full_rms_mm"]) and rows.loc["bvh", "status"] == "diverged"


def test_a_snapshot_that_is_gone_costs_only_its_own_cells(coupled):
    for path in (coupled / "raw" / "s0" / "snapshots").iterdir():
        path.unlink()
    aggregates = aggregates_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(aggregates, outcomes.shape_distances(aggregates), []).rows.set_index("configuration")
    assert math.isnan(rows.loc["sdf 64", "full_rms_mm"]) and rows.loc["sdf 64", "node_depth_mm"] > 0


def test_remaining_depth_is_the_surfaces_else_the_nodes(coupled):
    aggregate = find(aggregates_of(cases.read_cases(coupled)), SCENES[0], configuration(fake_registry.registry().backend("sdf"), {}))
    assert aggregate.remaining_depth_mm == pytest.approx(0.2)
    for case in aggregate.ok:
        case.run.record.get("outcome", {}).pop("p99_surface_depth_m", None)
    assert aggregate.remaining_depth_mm == pytest.approx(0.1)
