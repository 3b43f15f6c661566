"""Triangles of a surface that pass through others of it: what decimation must not make."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .surface import Points, Surface

MOST_PAIRS = 20_000_000  # near each other: a mesh of such long triangles is not looked at
INSIDE = 1e-6  # share of an edge or a triangle: what only touches does not count
FLAT = 1e-9  # sine of an angle: an edge in the plane of a triangle does not pass through it


def crossing_triangles(surface: Surface) -> NDArray[np.int64]:
    """Those that pass through one that shares no edge with them; none where there are more than MOST_PAIRS to look at."""
    corners = surface.corners
    pairs = _near_pairs(surface)
    crossed = np.zeros(len(pairs), dtype=bool)
    for one, other in ((0, 1), (1, 0)):
        for k in range(3):
            edges = corners[pairs[:, one]][:, [k, (k + 1) % 3]]
            crossed |= _pierces(edges, corners[pairs[:, other]])
    found: NDArray[np.int64] = np.unique(pairs[crossed])
    return found


def _near_pairs(surface: Surface) -> NDArray[np.int64]:
    """(n, 2) triangles whose boxes meet and that share no edge."""
    if not len(surface.triangles):
        return np.empty((0, 2), dtype=np.int64)
    corners = surface.corners
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    order = np.argsort(reach)
    tree = cKDTree(centres)
    if tree.query_ball_point(centres, 2 * reach, return_length=True).sum() > MOST_PAIRS:
        return np.empty((0, 2), dtype=np.int64)
    near = tree.query_ball_point(centres, 2 * reach)  # the larger of two finds the smaller
    first = np.repeat(np.arange(len(near)), [len(one) for one in near])
    second = np.concatenate([np.asarray(one, dtype=np.int64) for one in near])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    keep = rank[second] < rank[first]
    first, second = first[keep], second[keep]
    low, high = corners.min(axis=1), corners.max(axis=1)
    keep = np.all((low[first] <= high[second]) & (low[second] <= high[first]), axis=1)
    keep &= (surface.triangles[first][:, :, None] == surface.triangles[second][:, None, :]).sum(axis=(1, 2)) < 2
    return np.column_stack([first[keep], second[keep]])


def _pierces(edges: Points, triangles: Points) -> NDArray[np.bool_]:
    """Whether an edge passes through the inside of a triangle (Moeller and Trumbore 1997)."""
    start, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    ab, ac = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(along, ac)
    volume = np.einsum("ij,ij->i", ab, across)
    is_flat = np.abs(volume) <= FLAT * np.prod([np.linalg.norm(one, axis=1) for one in (ab, ac, along)], axis=0)
    safe = np.where(is_flat, 1.0, volume)
    to_start = start - triangles[:, 0]
    u = np.einsum("ij,ij->i", to_start, across) / safe
    turned = np.cross(to_start, ab)
    v = np.einsum("ij,ij->i", along, turned) / safe
    at = np.einsum("ij,ij->i", ac, turned) / safe
    found: NDArray[np.bool_] = ~is_flat & (u > INSIDE) & (v > INSIDE) & (u + v < 1 - INSIDE) & (at > INSIDE) & (at < 1 - INSIDE)
    return found
