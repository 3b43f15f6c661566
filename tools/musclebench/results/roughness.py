"""How rough a muscle's surface is where it lies on its bones: by how much the normal turns across an edge."""

import numpy as np
from scipy.spatial import cKDTree

from .ply import PlyMesh


def inner_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges with two triangles: their nodes (n, 2), and these triangles (n, 2)."""
    ends = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owners = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, owners = ends[order], owners[order]
    edges, firsts, counts = np.unique(ends, axis=0, return_index=True, return_counts=True)
    twice = counts == 2
    return edges[twice], np.stack([owners[firsts[twice]], owners[firsts[twice] + 1]], axis=1)


def turns_deg(vertices_m: np.ndarray, triangles: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Angle between the normals of each two triangles, 0 where the surface is flat; NaN at one without area."""
    corners = vertices_m[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = normals / lengths
    a, b = normals[pairs[:, 0]], normals[pairs[:, 1]]
    sines, cosines = np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b)
    return np.degrees(np.arctan2(sines, cosines))  # an arc cosine loses half of the digits of small angles


def free_nodes_near(mesh: PlyMesh, bones_m: np.ndarray, near_m: float) -> np.ndarray:
    """Which nodes are bound to nothing and no farther from a bone's vertex than `near_m`."""
    distances, _ = cKDTree(bones_m).query(mesh.vertices_m, distance_upper_bound=near_m)
    return np.isfinite(distances) & (mesh.extra["attached"] == 0)


def roughness_deg(mesh: PlyMesh, chosen: np.ndarray) -> float:
    """Root of the mean square turn across the edges between chosen nodes; NaN without any."""
    edges, pairs = inner_edges(mesh.triangles)
    turns = turns_deg(mesh.vertices_m, mesh.triangles, pairs[chosen[edges].all(axis=1)])
    turns = turns[np.isfinite(turns)]
    return float(np.sqrt(np.mean(turns**2))) if len(turns) else float("nan")
