"""Exact closest points on a triangle mesh, for the few thousand queries that the importer needs."""

import numpy as np
from scipy.spatial import cKDTree


def closest_on_triangles(point, corners):
    """Closest point to `point` (3,) on each triangle of `corners` (n, 3, 3), after the region walk of
    C. Ericson, Real-Time Collision Detection (2005), 5.1.5. Triangles without area are allowed."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac = b - a, c - a
    d1, d2 = _dots(ab, ac, point - a)
    d3, d4 = _dots(ab, ac, point - b)
    d5, d6 = _dots(ab, ac, point - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    on_ab = a + _share(d1, d1 - d3)[:, None] * ab
    on_ac = a + _share(d2, d2 - d6)[:, None] * ac
    on_bc = b + _share(d4 - d3, (d4 - d3) + (d5 - d6))[:, None] * (c - b)
    area = va + vb + vc
    inside = a + _share(vb, area)[:, None] * ab + _share(vc, area)[:, None] * ac
    regions = [
        (d1 <= 0) & (d2 <= 0),
        (d3 >= 0) & (d4 <= d3),
        (d6 >= 0) & (d5 <= d6),
        (vc <= 0) & (d1 >= 0) & (d3 <= 0),
        (vb <= 0) & (d2 >= 0) & (d6 <= 0),
        (va <= 0) & (d4 >= d3) & (d5 >= d6),
    ]
    answers = [a, b, c, on_ab, on_ac, on_bc]
    return np.select([region[:, None] for region in regions], answers, default=inside)


def closest_on_mesh(points, vertices, triangles, limit):
    """(distances, closest points) of `points` (n, 3); distance is infinite where it exceeds `limit`."""
    corners = vertices[triangles]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max()
    tree = cKDTree(centres)
    distances, closest = np.full(len(points), np.inf), np.full((len(points), 3), np.nan)
    to_centre, _ = tree.query(points, distance_upper_bound=limit + reach)
    for i in np.flatnonzero(np.isfinite(to_centre)):
        candidates = tree.query_ball_point(points[i], min(to_centre[i], limit) + reach)
        near = closest_on_triangles(points[i], corners[candidates])
        gaps = np.linalg.norm(near - points[i], axis=1)
        best = int(gaps.argmin())
        if gaps[best] <= limit:
            distances[i], closest[i] = gaps[best], near[best]
    return distances, closest


def _dots(ab, ac, to_point):
    return np.einsum("ij,ij->i", ab, to_point), np.einsum("ij,ij->i", ac, to_point)


def _share(part, whole):
    return np.divide(part, whole, out=np.zeros_like(part), where=whole != 0)
