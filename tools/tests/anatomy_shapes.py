"""Surfaces that tests of the importer make, and files of them."""

import locale
from pathlib import Path

import vtk

from musclebench.anatomy.mesh_file import mend
from musclebench.anatomy.surface import Surface, as_vtk, from_vtk

WRITERS = {".stl": vtk.vtkSTLWriter, ".ply": vtk.vtkPLYWriter, ".obj": vtk.vtkOBJWriter, ".vtp": vtk.vtkXMLPolyDataWriter, ".vtk": vtk.vtkPolyDataWriter}


def ball(radius=10.0, centre=(0, 0, 0), cells=24) -> Surface:
    source = vtk.vtkSphereSource()
    source.SetRadius(radius)
    source.SetCenter(*centre)
    source.SetThetaResolution(cells)
    source.SetPhiResolution(cells)
    source.Update()
    return mend(from_vtk(source.GetOutput()), "ball").surface


def spindle(length=100.0, radius=8.0) -> Surface:
    """Along z, from 0 to its length."""
    long = ball(1.0, cells=40)
    return Surface(long.vertices * [radius, radius, length / 2] + [0, 0, length / 2], long.triangles)


def write(surface: Surface, path: Path) -> Path:
    writer = WRITERS[path.suffix]()
    writer.SetInputData(as_vtk(surface))
    writer.SetFileName(str(path))
    before = locale.setlocale(locale.LC_ALL)
    writer.Write()
    locale.setlocale(locale.LC_ALL, before)  # VTK's legacy writer sets another one, and files of later tests were read as ASCII
    return path
