"""What passes through what in the shapes that a run kept, counted anew: no line of the program's judge is used."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..results.ply import read_ply

Points = NDArray[np.float64]
Corners = NDArray[np.int64]
DOUBTFUL = 1e-12  # of a determinant over the product of its edges: below it fractions decide
BONE, MUSCLE, ITSELF = "bone", "muscle", "itself"


@dataclass(frozen=True)
class Surface:
    name: str
    points: Points
    triangles: Corners
    attached: NDArray[np.bool_]  # of each triangle, whether a corner is


@dataclass(frozen=True)
class Shape:
    """All surfaces at one moment, world frame, m."""

    frame: int
    muscles: list[Surface]
    bones: list[Surface]


def shapes_of(run: Path, manifest: dict[str, Any]) -> Iterator[Shape]:
    """Of a run's folder, moment by moment."""
    meshes = {bone["name"]: read_ply(run / "meshes" / f"{bone['name']}.ply") for bone in manifest["bones"]}
    welded = None
    for shot in manifest["snapshots"]:
        kept = read_ply(run / shot["file"])
        points, triangles = np.asarray(kept.vertices_m, float), np.asarray(kept.triangles)
        if welded is None:
            welded = _welded(points, [muscle["vertices"] for muscle in manifest.get("muscles") or [manifest["muscle"]]])
        triangles = welded[triangles]
        is_attached = (np.asarray(kept.extra["attached"])[triangles] > 0).any(axis=1)
        muscles, start = [], 0
        for muscle in manifest.get("muscles") or [manifest["muscle"]]:
            stop = start + muscle["vertices"]
            own = ((triangles >= start) & (triangles < stop)).all(axis=1)
            muscles.append(Surface(muscle.get("name", MUSCLE), points, triangles[own], is_attached[own]))
            start = stop
        bones = []
        for (name, mesh), pose in zip(meshes.items(), shot["bone_poses"]):
            posed = np.asarray(mesh.vertices_m, float) @ np.array(pose["rotation"]).reshape(3, 3).T + pose["translation_m"]
            bones.append(Surface(name, posed, np.asarray(mesh.triangles), np.zeros(len(mesh.triangles), bool)))
        yield Shape(shot["frame"], muscles, bones)


def _welded(points: Points, counts: list[int]) -> NDArray[np.int64]:
    """Of each vertex the first of its muscle that is at its place: an STL file gives each triangle corners for itself."""
    first = np.empty(len(points), dtype=np.int64)
    start = 0
    for count in counts:
        _, place, same = np.unique(points[start:start + count], axis=0, return_index=True, return_inverse=True)
        first[start:start + count] = start + place[same.ravel()]
        start += count
    return first


def counted(shape: Shape, carriers: dict[str, set[str]] | None = None) -> dict[str, int]:
    """Triangles of muscles that pass through bones, other muscles and their own. `carriers`: the bones that each muscle is
    attached to, whose triangles with an attached corner don't count; without it they count against no bone."""
    def free(muscle: Surface, bone: Surface) -> Corners:
        is_carrier = carriers is None or bone.name in carriers.get(muscle.name, set())
        return muscle.triangles[~muscle.attached] if is_carrier else muscle.triangles

    found = {BONE: sum(passing(muscle.points, free(muscle, bone), bone.points, bone.triangles)
                       for muscle, bone in product(shape.muscles, shape.bones)),
             ITSELF: sum(passing(muscle.points, muscle.triangles, muscle.points, muscle.triangles) for muscle in shape.muscles)}
    if len(shape.muscles) > 1:
        found[MUSCLE] = sum(passing(one.points, one.triangles, other.points, other.triangles) for one, other in combinations(shape.muscles, 2))
    return found


def passing(points: Points, triangles: Corners, others: Points, other_triangles: Corners) -> int:
    """Triangles of the first surface that pass through the second."""
    same = triangles is other_triangles
    hit = set(piercing(others, edges_of(other_triangles), points, triangles, same)[1].tolist())
    own = edges_of(triangles)
    crossing = {tuple(edge) for edge in own[piercing(points, own, others, other_triangles, same)[0]].tolist()}
    for number, triangle in enumerate(np.sort(triangles, axis=1).tolist() if crossing else []):
        if any(edge in crossing for edge in combinations(triangle, 2)):
            hit.add(number)
    return len(hit)


def piercing(points: Points, edges: Corners, others: Points, triangles: Corners, same: bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of an edge and a triangle of which the one passes through the inside of the other; every pair is tried. `same`: of
    one surface, where what shares a vertex does not count."""
    ends, corners = points[edges], others[triangles]
    meet = np.ones((len(edges), len(triangles)), bool)
    for axis in range(3):
        meet &= ends[:, :, axis].min(1)[:, None] <= corners[:, :, axis].max(1)[None]
        meet &= ends[:, :, axis].max(1)[:, None] >= corners[:, :, axis].min(1)[None]
    one, other = np.nonzero(meet)
    if same:
        apart = ~(edges[one][:, :, None] == triangles[other][:, None, :]).any((1, 2))
        one, other = one[apart], other[apart]
    p, q = points[edges[one, 0]], points[edges[one, 1]]
    a, b, c = (others[triangles[other, k]] for k in range(3))
    through = sides(a, b, c, p) * sides(a, b, c, q) < 0
    around = np.array([sides(p, q, x, y) for x, y in ((a, b), (b, c), (c, a))])
    through &= (around > 0).all(0) | (around < 0).all(0)
    return one[through], other[through]


def edges_of(triangles: Corners) -> Corners:
    edges: Corners = np.unique(np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1), axis=0)
    return edges


def sides(a: Points, b: Points, c: Points, d: Points) -> NDArray[np.int64]:
    """Of each row the side of d to the plane of a, b, c: -1, 1, or 0 in it; exact."""
    u, v, w = a - d, b - d, c - d
    det = np.einsum("ij,ij->i", u, np.cross(v, w))
    size = np.abs(u).max(1, initial=0) * np.abs(v).max(1, initial=0) * np.abs(w).max(1, initial=0)
    sign: NDArray[np.int64] = np.sign(det).astype(np.int64)
    for row in np.flatnonzero(np.abs(det) <= DOUBTFUL * size):
        sign[row] = _exact_side([p[row] for p in (a, b, c, d)])
    return sign


def _exact_side(corners: list[Points]) -> int:
    (a, b, c), d = [[Fraction(float(x)) for x in corner] for corner in corners[:3]], [Fraction(float(x)) for x in corners[3]]
    u, v, w = ([x - y for x, y in zip(p, d)] for p in (a, b, c))
    det = (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    return (det > 0) - (det < 0)


def winding(point: Points, points: Points, triangles: Corners) -> float:
    """How often a surface goes round a point: 1 inside of a closed one, 0 outside (the sum of solid angles; van Oosterom and
    Strackee 1983)."""
    a, b, c = (points[triangles[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    det = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
    return float(np.arctan2(det, below).sum() / (2 * np.pi))
