"""Numbers small enough to travel inside of a page: rounded to steps, differences, bytes by weight, deflate, base64. The
page undoes it (tools/page/unpack.js)."""

import base64
import zlib
from dataclasses import dataclass

import numpy as np

from ..results.ply import PlyMesh

STEP_M, BONE_STEP_M = 3e-5, 5e-6  # of positions; of larger ones the smallest with which they fit
DEPTH_STEP_M = 1e-6
STEPS = 65535
LEVEL = 6


@dataclass
class PackedShapes:
    """Positions of the same nodes at several moments: origin_m + step_m * whole numbers."""

    step_m: float
    origin_m: list[float]
    text: str


def packed_bytes(data: bytes) -> str:
    packer = zlib.compressobj(LEVEL, strategy=zlib.Z_FILTERED)
    return base64.b64encode(packer.compress(data) + packer.flush()).decode()


def packed_words(values: np.ndarray, bits: int) -> str:
    """Whole numbers modulo 2**bits: all low bytes, then all next ones; of small numbers of either sign (0, -1, 1, -2, ...)
    only low bytes differ from zero."""
    half = 1 << (bits - 1)
    signed = (values.astype(np.int64) + half) % (2 * half) - half
    words = np.where(signed >= 0, 2 * signed, -2 * signed - 1).astype("<u8")
    planes = np.ascontiguousarray(words).reshape(-1, 1).view(np.uint8)[:, :bits // 8]
    return packed_bytes(np.ascontiguousarray(planes.T).tobytes())


def neighbours_order(count: int, triangles: np.ndarray) -> np.ndarray:
    """A permutation of the vertices in which neighbours of the mesh stand near each other (breadth first), so that their
    differences are small; vertices of no triangle last."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    starts, ends = np.searchsorted(edges[:, 0], [np.arange(count), np.arange(1, count + 1)])
    targets, seen = edges[:, 1].tolist(), bytearray(count)
    order: list[int] = []
    for seed in range(count):
        if seen[seed] or starts[seed] == ends[seed]:
            continue
        seen[seed], head = 1, len(order)
        order.append(seed)
        while head < len(order):
            vertex, head = order[head], head + 1
            for other in targets[starts[vertex]:ends[vertex]]:
                if not seen[other]:
                    seen[other] = 1
                    order.append(other)
    rest = [vertex for vertex in range(count) if not seen[vertex]]
    return np.array(order + rest, dtype=np.int64)


def packed_triangles(triangles: np.ndarray, order: np.ndarray) -> str:
    """Of the vertices in this order; differences along the list of corners."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    corners = place[triangles]
    corners = corners[np.argsort(corners.min(axis=1), kind="stable")].ravel()
    return packed_words(np.diff(corners, prepend=0), 32)


def packed_shapes(shapes_m: np.ndarray, order: np.ndarray, finest_m: float = STEP_M) -> PackedShapes:
    """`shapes_m`: (moments, vertices, 3). Differences to the moment before, then to the vertex before."""
    low, high = shapes_m.min(axis=(0, 1)), shapes_m.max(axis=(0, 1))
    step_m = max(finest_m, float((high - low).max()) / STEPS)
    steps = np.rint((shapes_m[:, order] - low) / step_m).astype(np.int64).transpose(0, 2, 1)
    steps = np.diff(steps, axis=0, prepend=0)
    return PackedShapes(step_m, low.tolist(), packed_words(np.diff(steps, axis=2, prepend=0), 16))


def packed_depths(depths_m: np.ndarray, order: np.ndarray) -> tuple[float, str]:
    """(step_m, text) of (moments, vertices): differences to the vertex before."""
    step_m = max(DEPTH_STEP_M, float(depths_m.max(initial=0.0)) / STEPS)
    steps = np.rint(np.maximum(depths_m[:, order], 0.0) / step_m).astype(np.int64)
    return step_m, packed_words(np.diff(steps, axis=1, prepend=0), 16)


def packed_mesh(mesh: PlyMesh) -> dict:
    """A surface that does not change its shape."""
    order = neighbours_order(len(mesh.vertices_m), mesh.triangles)
    shape = packed_shapes(mesh.vertices_m[None], order, BONE_STEP_M)
    return {"vertices": len(order), "triangles": len(mesh.triangles), "corners": packed_triangles(mesh.triangles, order),
            "step_m": shape.step_m, "origin_m": shape.origin_m, "positions": shape.text}
