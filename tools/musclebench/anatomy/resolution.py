"""Fewer triangles within a wanted error."""

import math

import vtk

from ..program.cli import Problem
from .mesh_file import open_edges
from .self_crossings import crossing_triangles
from .surface import Surface, as_vtk, from_vtk, largest_gap

TRIES = 6
FEWEST = 200  # triangles
KEPT_SHARES = (0.02, 1.0)


def decimated(surface: Surface, error_mm: float) -> tuple[Surface, float]:
    """By quadric edge collapse, with the largest distance between the two surfaces, which is at most `error_mm`, and no triangle that
    passes through another if none did. The surface itself where nothing smaller holds it."""
    least, most = max(KEPT_SHARES[0], FEWEST / len(surface.triangles)), KEPT_SHARES[1]
    best, gap, crossing = surface, 0.0, len(crossing_triangles(surface))
    for _ in range(TRIES):
        if least >= most:
            break
        share = (least * most) ** 0.5
        tried = _collapsed(surface, share)
        if (found := _gap(surface, tried)) <= error_mm and len(crossing_triangles(tried)) <= crossing:
            best, gap, most = tried, found, share
        else:
            least = share
    return best, gap


def _collapsed(surface: Surface, share: float) -> Surface:
    collapse = vtk.vtkQuadricDecimation()
    collapse.SetInputData(as_vtk(surface))
    collapse.SetTargetReduction(1 - share)
    collapse.VolumePreservationOn()
    collapse.Update()
    return from_vtk(collapse.GetOutput())


def _gap(surface: Surface, tried: Surface) -> float:
    """Infinite where it is no closed surface any more."""
    try:
        return math.inf if open_edges(tried) else largest_gap(surface, tried)
    except Problem:
        return math.inf
