"""The adductor brevis of 502 vertices, which upstream does not publish, from the published one of 8564."""

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy


def decimate(vertices_m: np.ndarray, triangles: np.ndarray, target_triangles: int):
    """(vertices_m, triangles) after VTK's quadric edge collapse. It works in millimetres, because the collapse order
    depends on the unit, and rounds its result to single precision (VTK 9.1), 3e-8 m here."""
    collapse = vtk.vtkQuadricDecimation()
    collapse.SetInputData(_poly_data(vertices_m * 1000.0, triangles))
    collapse.SetTargetReduction(1.0 - target_triangles / len(triangles))
    collapse.Update()
    result = collapse.GetOutput()
    points = vtk_to_numpy(result.GetPoints().GetData()).astype(np.float64) / 1000.0
    corners = vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return points, corners.astype(np.int32)


def _poly_data(vertices: np.ndarray, triangles: np.ndarray) -> vtk.vtkPolyData:
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    corners = np.ascontiguousarray(triangles, dtype=np.int64).ravel()
    cells = vtk.vtkCellArray()
    cells.SetData(
        numpy_to_vtk(offsets, deep=True, array_type=vtk.VTK_ID_TYPE),
        numpy_to_vtk(corners, deep=True, array_type=vtk.VTK_ID_TYPE),
    )
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    return data
