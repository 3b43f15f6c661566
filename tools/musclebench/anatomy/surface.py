"""A surface of triangles, as the importer works on it, and distances from it."""

import json
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
import vtk
from numpy.typing import NDArray
from vtk.util.numpy_support import vtk_to_numpy

from ..pictures.rendering import poly_data
from ..program.cli import Problem
from ..program.native_module import native

Points = NDArray[np.float64]  # (n, 3)
Triangles = NDArray[np.int64]  # (m, 3)
Values = NDArray[np.float64]  # (n,)


@dataclass
class Surface:
    """Vertices in millimetres unless a function says otherwise; triangles face outward where the surface is closed."""

    vertices: Points
    triangles: Triangles
    _built: tuple[Points, Triangles, "SignedDistance"] | None = field(default=None, repr=False, compare=False)

    @property
    def distance(self) -> "SignedDistance":
        """Built where it is asked for the first time, and anew where vertices or triangles are another array by now: do not write into them."""
        if self._built is None or self._built[0] is not self.vertices or self._built[1] is not self.triangles:
            self._built = self.vertices, self.triangles, SignedDistance(self)
        return self._built[2]

    def __getstate__(self) -> dict[str, Any]:
        """What goes to another process: that builds its own."""
        return vars(self) | {"_built": None}

    @property
    def corners(self) -> NDArray[np.float64]:
        """(m, 3, 3)"""
        return self.vertices[self.triangles]

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @property
    def volume(self) -> float:
        """Positive where triangles face outward."""
        a, b, c = np.moveaxis(self.corners - self.vertices.mean(axis=0), 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def areas(self) -> Values:
        a, b, c = np.moveaxis(self.corners, 1, 0)
        found: Values = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        return found


def as_vtk(surface: Surface) -> Any:
    return poly_data(surface.vertices, surface.triangles)


def from_vtk(data: Any) -> Surface:
    """Triangles of polygon data; vertices stay as they are, also those at one place."""
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(data)
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.Update()
    result = triangles.GetOutput()
    if not result.GetNumberOfPoints() or not result.GetNumberOfPolys():
        return Surface(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    corners = vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return Surface(vtk_to_numpy(result.GetPoints().GetData()).astype(np.float64), corners.astype(np.int64))


def merged(surfaces: list[Surface]) -> Surface:
    starts = np.cumsum([0, *(len(one.vertices) for one in surfaces)])
    return Surface(np.concatenate([one.vertices for one in surfaces]),
                   np.concatenate([one.triangles + start for one, start in zip(surfaces, starts)]))


class SignedDistance:
    """Signed distance to a closed surface: negative inside. In the surface's unit, exact to rounding, by the program's own tree: the
    importer and the judge of a run tell inside from outside alike, also where a surface folds or passes through itself. Raises Problem for
    a surface that can't be closed."""

    def __init__(self, surface: Surface):
        module = native()
        self._low, self._high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        try:
            self._tree = module.Backend(_exact_backend(), module.Bone("surface", surface.vertices, surface.triangles))
        except module.InputError as problem:
            raise Problem(str(problem)) from None

    def __call__(self, points: Points) -> Values:
        found: Values = self._tree.locate(points)["signed_distance_m"]
        return found

    def within(self, points: Points, reach: float) -> Values:
        """Infinite where a point is farther than `reach` from the surface's box."""
        found = np.full(len(points), np.inf)
        near = np.all((points > self._low - reach) & (points < self._high + reach), axis=1)
        if near.any():
            found[near] = self(points[near])
        return found

    def gradients(self, points: Points) -> Points:
        found: Points = self._tree.locate(points)["normal"]
        return found

    def nearest(self, point: Points) -> Points:
        """The nearest point of the surface."""
        found: Points = self._tree.locate(point[None])["closest_m"][0]
        return found


@cache
def _exact_backend() -> str:
    """That tells exact distances on both sides of a surface."""
    known: list[dict[str, Any]] = json.loads(native().catalogue())["backends"]
    return next(str(one["name"]) for one in known if one["exact"] and one["face_contact"])


def sample_points(surface: Surface) -> Points:
    """Vertices, middles of edges and of triangles: where one surface is compared with another."""
    corners = surface.corners
    edges = (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3) / 2
    return np.concatenate([surface.vertices, edges[::2], corners.mean(axis=1)])


def largest_gap(one: Surface, other: Surface) -> float:
    """Distance between two surfaces, both ways: the largest from a point of either to the other, at `sample_points`."""
    return max(float(np.abs(to.distance(sample_points(of))).max()) for of, to in ((one, other), (other, one)))
