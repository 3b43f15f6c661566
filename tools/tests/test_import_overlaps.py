"""Distances of the importer, and muscles that it moves apart."""

from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
import vtk

from anatomy_shapes import ball
from musclebench.anatomy import overlaps
from musclebench.anatomy.overlaps import CLEAR_MM, moved_apart, overlaps_of
from musclebench.anatomy.surface import Surface, as_vtk, sample_points
from musclebench.program.cli import Problem
from musclebench.program.native_module import add_native_module
from program import needs_native_module

pytestmark = needs_native_module


@pytest.fixture
def crowd() -> dict[str, Surface]:
    return {"a": ball(10), "b": ball(9, (16, 0, 0)), "c": ball(8, (8, 12, 1))}


def test_distances_are_those_of_vtk():
    surface = ball(10)
    points = np.random.default_rng(3).uniform(-15, 15, (400, 3))
    judge = vtk.vtkImplicitPolyDataDistance()
    judge.SetInput(as_vtk(surface))
    told = np.array([judge.EvaluateFunction(point) for point in points])
    assert surface.distance(points) == pytest.approx(told, abs=1e-9) and told.min() < -5 < 5 < told.max()
    closest, gradient = np.zeros(3), np.zeros(3)
    for point in points[:20]:
        judge.EvaluateGradient(point, gradient)
        judge.EvaluateFunctionAndGetClosestPoint(point, closest)
        assert surface.distance.gradients(point[None])[0] == pytest.approx(gradient, abs=1e-6)
        assert surface.distance.nearest(point) == pytest.approx(closest, abs=1e-6)
    assert surface.distance.within(points, 0.0)[np.abs(points).max(axis=1) > 10] == pytest.approx(np.inf)


def test_a_surface_that_changes_is_asked_anew():
    surface = ball(10)
    here = np.array([[0, 0, 12.0]])
    first = surface.distance
    assert surface.distance is first and first(here) == pytest.approx(2)
    surface.vertices = surface.vertices + [0, 0, 5]
    assert surface.distance(here) == pytest.approx(-3, abs=0.01)
    open_one = Surface(surface.vertices, surface.triangles[:-50])
    with pytest.raises(Problem, match="no inside; close its holes"):
        open_one.distance(here)


def test_muscles_that_overlap_are_moved_apart(crowd):
    found = overlaps_of(crowd)
    assert {(one.muscle, one.other) for one in found} == {("a", "b"), ("a", "c"), ("b", "c")}
    deepest = found[0]
    assert deepest.triangles > 20 and deepest.deepest == pytest.approx(3, abs=0.1) and deepest.at == pytest.approx([8.9, 0, 0], abs=2)
    free = {name: np.zeros(len(one.vertices), dtype=bool) for name, one in crowd.items()}
    farthest = moved_apart(crowd, free, {}, found)
    assert all(0.5 < far < 6 for far in farthest.values()) and overlaps_of(crowd) == []
    for one in crowd.values():
        gaps = [other.distance(sample_points(one)).min() for other in crowd.values() if other is not one]
        assert min(gaps) > 0.9 * CLEAR_MM


def test_a_muscle_inside_another_is_an_overlap():
    (found,) = overlaps_of({"whole": ball(10), "inner": ball(2)})
    assert found.triangles == 0 and found.nodes == len(ball(2).vertices) and found.deepest == pytest.approx(8, abs=0.1) and found.at is None


def test_only_what_can_be_too_near_is_asked_and_nothing_is_missed(crowd, monkeypatch):
    """Bit for bit what comes of asking everything in every round."""
    free = {name: np.zeros(len(one.vertices), dtype=bool) for name, one in crowd.items()}
    free["a"][:300] = True
    bones, all_asked = {"bone": ball(6, (8, -6, 0))}, deepcopy(crowd)
    moved_apart(crowd, free, bones, overlaps_of(crowd))
    monkeypatch.setattr(overlaps, "ROUNDING_MM", np.inf)
    moved_apart(all_asked, free, bones, overlaps_of(all_asked))
    assert all(np.array_equal(crowd[name].vertices, all_asked[name].vertices) for name in crowd)


def test_a_muscle_sees_that_another_comes():
    one, other = ball(10), ball(9, (19.6, 0, 0))
    side = overlaps._Side(one, np.zeros(len(one.vertices), dtype=bool), other)
    assert not side.push()
    other.vertices = other.vertices - [1.0, 0, 0]
    assert side.push() and one.vertices[:, 0].max() < 9.9


def test_a_program_without_the_module_is_told(tmp_path):
    (tmp_path / "bench").mkdir()
    with pytest.raises(Problem, match="has no Python module beside it; run tools/setup pybind11-dev"):
        add_native_module(Path(tmp_path / "bench" / "musclebench"))
