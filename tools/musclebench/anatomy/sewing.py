"""Two open surfaces whose borders run beside each other become one."""

import numpy as np
import vtk
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from vtk.util.numpy_support import numpy_to_vtk

from .surface import Points, Surface, Values, as_vtk, from_vtk, merged

Loop = NDArray[np.int64]


class Unsewable(Exception):
    """The borders are not the same number of closed loops."""


def clipped(surface: Surface, values: Values, at: float, keeps_below: bool) -> Surface:
    """The part where `values`, one a vertex, are below `at` or above it; triangles on the border are cut."""
    data = as_vtk(surface)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values), deep=True))
    clip = vtk.vtkClipPolyData()
    clip.SetInputData(data)
    clip.SetValue(at)
    clip.SetInsideOut(keeps_below)
    clip.Update()
    clean = vtk.vtkCleanPolyData()
    clean.SetInputData(clip.GetOutput())
    clean.SetTolerance(0.0)
    clean.Update()
    found = from_vtk(clean.GetOutput())
    return Surface(found.vertices, found.triangles[_have_area(found)])


def without_bumps(surface: Surface, values: Values, low: float, high: float) -> Values:
    """Values, those of connected areas that rise above `low` and nowhere above `high` set to `low`."""
    parts = _areas(surface, values > low)
    most = np.full(len(values), -np.inf)
    np.maximum.at(most, parts, values)
    found: Values = np.where((values > low) & (most[parts] <= high), low, values)
    return found


def without_bays(surface: Surface, values: Values, low: float, high: float) -> Values:
    """Values, those of connected areas that fall below `high` and nowhere below `low` set to `high`."""
    return -without_bumps(surface, -values, -high, -low)


def _areas(surface: Surface, among: NDArray[np.bool_]) -> NDArray[np.int32]:
    """By vertex, the connected area of those that are `among`; each other one is one of its own."""
    edges = surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[among[edges].all(axis=1)]
    size = len(surface.vertices)
    found: NDArray[np.int32] = connected_components(coo_matrix((np.ones(len(edges)), edges.T), shape=(size, size)), directed=False)[1]
    return found


def sew(one: Surface, other: Surface) -> Surface:
    """Both, and a strip of triangles along each border loop."""
    both = merged([one, other])
    loops = border_loops(one)
    others = [loop + len(one.vertices) for loop in border_loops(other)]
    if len(loops) != len(others) or not loops:
        raise Unsewable
    strips = [both.triangles]
    for loop in loops:
        nearest = min(range(len(others)), key=lambda i: _apart(both.vertices, loop, others[i]))
        strips.append(_strip(both.vertices, loop, others.pop(nearest)[::-1]))
    return Surface(both.vertices, np.concatenate(strips))


def border_loops(surface: Surface) -> list[Loop]:
    """Each in the direction in which its triangles run along it. Raises Unsewable where a border meets itself."""
    edges = np.concatenate([surface.triangles[:, [0, 1]], surface.triangles[:, [1, 2]], surface.triangles[:, [2, 0]]])
    inner = {(int(b), int(a)) for a, b in edges}
    following: dict[int, int] = {}
    for start, end in ((int(a), int(b)) for a, b in edges):
        if (start, end) in inner:
            continue
        if start in following:
            raise Unsewable
        following[start] = end
    loops = []
    while following:
        first, at = following.popitem()
        loop = [first]
        while at != first:
            loop.append(at)
            if at not in following:
                raise Unsewable
            at = following.pop(at)
        loops.append(np.array(loop))
    return loops


def _strip(vertices: Points, left: Loop, right: Loop) -> NDArray[np.int64]:
    """Triangles between two loops that run the same way, always across the shorter diagonal."""
    apart = np.linalg.norm(vertices[left][:, None] - vertices[right][None], axis=2)
    i, j = (int(k) for k in np.unravel_index(apart.argmin(), apart.shape))
    left, right = np.roll(left, -i), np.roll(right, -j)
    a, b = vertices[np.append(left, left[0])], vertices[np.append(right, right[0])]
    triangles = []
    i = j = 0
    while i < len(left) or j < len(right):
        goes_left = j == len(right) or (i < len(left) and np.linalg.norm(a[i + 1] - b[j]) <= np.linalg.norm(a[i] - b[j + 1]))
        at, beside = left[i % len(left)], right[j % len(right)]
        if goes_left:
            i += 1
            triangles.append((left[i % len(left)], at, beside))
        else:
            j += 1
            triangles.append((beside, right[j % len(right)], at))
    return np.array(triangles)


def _apart(vertices: Points, loop: Loop, other: Loop) -> float:
    from_loop = np.linalg.norm(vertices[loop][:, None] - vertices[other][None], axis=2)
    return float(from_loop.min(axis=1).mean())


def _have_area(surface: Surface) -> NDArray[np.bool_]:
    a, b, c = surface.triangles.T
    found: NDArray[np.bool_] = (a != b) & (b != c) & (c != a)
    return found
