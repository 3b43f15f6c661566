"""Reads a mesh of any format that VTK knows, and brings it in order: welded, of one part, closed, outside out."""

import faulthandler
import multiprocessing
import os
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import vtk
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..program.cli import Problem
from .surface import Surface, Triangles, as_vtk, from_vtk

READERS = {".stl": vtk.vtkSTLReader, ".obj": vtk.vtkOBJReader, ".ply": vtk.vtkPLYReader, ".vtp": vtk.vtkXMLPolyDataReader,
           ".vtk": vtk.vtkPolyDataReader}
SMALL_HOLE = 0.1  # of the mesh's diagonal; a larger one is a missing part
SMALL_PART = 0.02  # of the largest part's area: debris of a segmentation
ROUNDED = 1e-6  # of the mesh's diagonal: vertices that are so near are one
FLAT = 1e-9  # volume over the diagonal cubed of what encloses nothing
FORKED = multiprocessing.get_context("fork")


@dataclass
class Mended:
    surface: Surface
    repairs: list[str] = field(default_factory=list)


def read_mesh(path: Path) -> Surface:
    """As in the file, in its unit. Raises Problem."""
    # VTK's readers end the process at some damaged files, so each reads in one of its own.
    mine, theirs = FORKED.Pipe(duplex=False)
    child = FORKED.Process(target=_read, args=(path, theirs))
    child.start()
    theirs.close()
    surface: Surface | None
    try:
        surface, error = mine.recv()
    except EOFError:
        surface, error = None, "it ends VTK's reader"
    finally:
        child.join()
    if surface is None:
        raise Problem(f"{path}: can't be read ({error}); is it whole? Export it again")
    if not len(surface.triangles):
        raise Problem(f"{path}: holds no triangle; export it as a surface (STL, PLY, OBJ, VTP or VTK)")
    if not np.isfinite(surface.vertices).all():
        raise Problem(f"{path}: has coordinates that are no numbers; export it again")
    return surface


def _read(path: Path, answer: Connection) -> None:
    """Sends the surface, or None and what is wrong."""
    told = _wrong_numbers(path) if path.suffix.lower() == ".obj" else []
    faulthandler.disable()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # some of what readers say goes past VTK
    reader = READERS[path.suffix.lower()]()
    for event in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(event, lambda *_: told.append("VTK finds it damaged"))
    reader.SetFileName(str(path))
    reader.Update()
    surface = from_vtk(reader.GetOutput())
    corners = surface.triangles
    if len(corners) and not (0 <= corners.min() and corners.max() < len(surface.vertices)):
        told.append("a triangle names a vertex that is not there")
    answer.send((None, told[0]) if told else (surface, ""))


def _wrong_numbers(path: Path) -> list[str]:
    """VTK takes a word for 0."""
    for number, line in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
        if line.startswith("v "):
            try:
                if all(np.isfinite(float(word)) for word in line.split()[1:4]):
                    continue
            except ValueError:
                pass
            return [f"line {number} has no three numbers"]
    return []


def mend(surface: Surface, name: str) -> Mended:
    """Welds vertices at one place, drops what is degenerate or debris, closes small holes, turns triangles outward. Raises Problem
    where the surface then is not closed, or encloses nothing."""
    mended = Mended(_welded(_snapped(surface)))
    _drop(mended, _degenerate(mended.surface), "degenerate or double triangles")
    _drop(mended, _debris(mended.surface), "triangles of loose parts")
    if not len(mended.surface.triangles):
        raise Problem(f"{name}: encloses no volume; export a closed surface")
    if open_edges(mended.surface):
        _close(mended)
    if rest := open_edges(mended.surface):
        raise Problem(f"{name}: is open ({rest} edges have no second triangle, in holes wider than {SMALL_HOLE:.0%} of it); close it in a mesh editor")
    _turn_outward(mended)
    if not mended.surface.volume > FLAT * mended.surface.diagonal**3:
        raise Problem(f"{name}: encloses no volume; export a closed surface")
    return mended


def open_edges(surface: Surface) -> int:
    """Edges that do not have two triangles."""
    edges = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    return int(np.count_nonzero(uses % 2))


def parts_of(surface: Surface) -> tuple[int, NDArray[np.int32]]:
    """How many connected parts there are, and which one each vertex belongs to."""
    ends = surface.triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    size = len(surface.vertices)
    count, labels = connected_components(coo_matrix((np.ones(len(ends)), ends.T), shape=(size, size)), directed=False)
    return int(count), labels


def _snapped(surface: Surface) -> Surface:
    """Vertices that differ by what an export rounds are at one place."""
    clean = vtk.vtkCleanPolyData()
    clean.SetInputData(as_vtk(surface))
    clean.SetTolerance(ROUNDED)
    clean.ConvertPolysToLinesOff()
    clean.Update()
    return from_vtk(clean.GetOutput())


def _welded(surface: Surface) -> Surface:
    used, triangles = np.unique(surface.triangles, return_inverse=True)
    vertices, places = np.unique(surface.vertices[used], axis=0, return_inverse=True)
    return Surface(vertices, places[triangles].reshape(-1, 3).astype(np.int64))


def _degenerate(surface: Surface) -> NDArray[np.bool_]:
    """Without area, or one of several on the same vertices; two of them that face each other are a fold, and both go."""
    triangles = np.sort(surface.triangles, axis=1)
    a, b, c = surface.triangles.T
    turn = np.where((a < b) & (b < c) | (b < c) & (c < a) | (c < a) & (a < b), 1, -1)  # whether sorting keeps the side that it faces
    _, first, groups = np.unique(triangles, axis=0, return_index=True, return_inverse=True)
    facing = np.bincount(groups, weights=turn)
    keeps = np.zeros(len(triangles), dtype=bool)
    keeps[first[facing != 0]] = True
    found: NDArray[np.bool_] = ~keeps | (triangles[:, 0] == triangles[:, 1]) | (triangles[:, 1] == triangles[:, 2])
    return found


def _debris(surface: Surface) -> NDArray[np.bool_]:
    _, labels = parts_of(surface)
    of_triangles = labels[surface.triangles[:, 0]]
    areas = np.bincount(of_triangles, weights=surface.areas)
    found: NDArray[np.bool_] = (areas < SMALL_PART * areas.max(initial=0.0))[of_triangles]
    return found


def _drop(mended: Mended, which: NDArray[np.bool_], what: str) -> None:
    if which.any():
        mended.repairs.append(f"{np.count_nonzero(which)} {what} left out")
        mended.surface = _welded(Surface(mended.surface.vertices, mended.surface.triangles[~which]))


def _close(mended: Mended) -> None:
    filler = vtk.vtkFillHolesFilter()
    filler.SetInputData(as_vtk(mended.surface))
    filler.SetHoleSize(SMALL_HOLE * mended.surface.diagonal)
    filler.Update()
    closed = _welded(from_vtk(filler.GetOutput()))
    if added := len(closed.triangles) - len(mended.surface.triangles):
        mended.repairs.append(f"holes closed by {added} triangles")
    mended.surface = closed


def _turn_outward(mended: Mended) -> None:
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(as_vtk(mended.surface))
    normals.SplittingOff()
    normals.ConsistencyOn()
    normals.AutoOrientNormalsOn()
    normals.ComputePointNormalsOff()
    normals.ComputeCellNormalsOn()  # without either the filter does nothing
    normals.Update()
    turned = from_vtk(normals.GetOutput())
    if turned.volume < 0:
        turned = Surface(turned.vertices, turned.triangles[:, ::-1].copy())
    before, after = (_from_smallest(one.triangles) for one in (mended.surface, turned))
    if changed := len(np.unique(np.concatenate([before, after]), axis=0)) - len(after):
        mended.repairs.append("turned inside out, and turned back" if changed == len(before) else f"{changed} triangles turned outward")
    mended.surface = turned


def _from_smallest(triangles: Triangles) -> Triangles:
    """Each once, with its smallest corner first: another order means that it faces the other side."""
    turned = (triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3
    found: Triangles = np.unique(np.take_along_axis(triangles, turned, axis=1), axis=0)
    return found
