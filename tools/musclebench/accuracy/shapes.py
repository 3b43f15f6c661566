"""Distances between two shapes of one muscle."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersModeling import vtkHausdorffDistancePointSetFilter

from ..results.ply import PlyMesh


def hausdorff_distance_m(a: PlyMesh, b: PlyMesh) -> float:
    """Symmetric, from the vertices of each to the surface of the other: never more than the surfaces' own, and less by
    no more than an edge. NaN where a mesh is empty or not finite."""
    if not all(len(m.triangles) and np.all(np.isfinite(m.vertices_m)) for m in (a, b)):
        return float("nan")
    distance = vtkHausdorffDistancePointSetFilter()
    distance.SetInputData(0, _poly_data(a))
    distance.SetInputData(1, _poly_data(b))
    distance.SetTargetDistanceMethodToPointToCell()
    distance.Update()
    return float(distance.GetHausdorffDistance())


def _poly_data(mesh: PlyMesh) -> vtkPolyData:
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.vertices_m, dtype=np.float64), deep=True))
    corners = np.column_stack([np.full(len(mesh.triangles), 3), mesh.triangles]).astype(np.int64).ravel()
    cells = vtkCellArray()
    cells.SetCells(len(mesh.triangles), numpy_to_vtkIdTypeArray(corners, deep=True))
    surface = vtkPolyData()
    surface.SetPoints(points)
    surface.SetPolys(cells)
    return surface
