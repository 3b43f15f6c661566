"""Counts of what is wrong with a published surface, and its size."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def mesh_quality(vertices_m: np.ndarray, triangles: np.ndarray) -> dict:
    edges = np.sort(_directed_edges(triangles), axis=1)
    unique_edges, uses = np.unique(edges, axis=0, return_counts=True)
    lengths_mm = 1000.0 * np.linalg.norm(vertices_m[unique_edges[:, 0]] - vertices_m[unique_edges[:, 1]], axis=1)
    referenced = np.unique(triangles)
    return {
        "unreferenced_vertices": len(vertices_m) - len(referenced),
        "duplicate_position_vertices": len(referenced) - len(np.unique(vertices_m[referenced], axis=0)),
        "zero_area_triangles": _zero_area_count(vertices_m, triangles),
        "duplicate_triangles": len(triangles) - len(np.unique(np.sort(triangles, axis=1), axis=0)),
        "boundary_edges": int(np.count_nonzero(uses == 1)),
        "non_manifold_edges": int(np.count_nonzero(uses > 2)),
        "components": _component_count(unique_edges, referenced),
        "euler_characteristic": len(referenced) - len(unique_edges) + len(triangles),
        "edges_with_inconsistent_orientation": _inconsistent_edges(triangles),
        "volume_ml": round(1e6 * signed_volume_m3(vertices_m, triangles), 3),
        "mean_edge_mm": round(float(lengths_mm.mean()), 3),
        "min_edge_mm": float(f"{lengths_mm.min():.3g}"),
        "max_edge_mm": round(float(lengths_mm.max()), 3),
    }


def signed_volume_m3(vertices_m: np.ndarray, triangles: np.ndarray) -> float:
    """Positive for a closed surface whose triangles face outward."""
    a, b, c = (vertices_m[triangles[:, i]] - vertices_m.mean(axis=0) for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _directed_edges(triangles: np.ndarray) -> np.ndarray:
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def _zero_area_count(vertices_m, triangles) -> int:
    a, b, c = (vertices_m[triangles[:, i]] for i in range(3))
    doubled_areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    return int(np.count_nonzero(doubled_areas <= 1e-12 * longest**2))


def _inconsistent_edges(triangles) -> int:
    _, uses = np.unique(_directed_edges(triangles), axis=0, return_counts=True)
    return int(np.count_nonzero(uses > 1))


def _component_count(edges, referenced) -> int:
    size = int(referenced.max()) + 1
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(size, size))
    _, labels = connected_components(graph, directed=False)
    return len(np.unique(labels[referenced]))
