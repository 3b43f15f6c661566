"""Reader of the snapshots and bones that musclebench writes: binary little-endian PLY, triangles only."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .run_folder import ResultProblem

NUMPY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4",
    "double": "<f8", "int8": "i1", "uint8": "u1", "int32": "<i4", "uint32": "<u4", "float32": "<f4", "float64": "<f8",
}


@dataclass
class PlyMesh:
    vertices_m: np.ndarray  # (n, 3)
    triangles: np.ndarray  # (m, 3)
    extra: dict[str, np.ndarray]  # further vertex properties by name, such as depth_m and attached


def read_ply(path: Path) -> PlyMesh:
    try:
        data = path.read_bytes()
    except OSError as problem:
        raise ResultProblem(f"{path}: can't be read ({problem.strerror}); run the case again") from None
    header, separator, body = data.partition(b"end_header\n")
    lines = header.decode("latin-1").split("\n")
    if not separator or lines[0] != "ply" or "format binary_little_endian 1.0" not in lines:
        raise ResultProblem(f"{path}: not a binary little-endian PLY file; run the case again")
    try:
        return _parse_body(_elements(lines), body)
    except (KeyError, ValueError, IndexError) as problem:
        raise ResultProblem(f"{path}: truncated or not a mesh of triangles ({problem}); run the case again") from None


def _elements(lines: list[str]) -> dict[str, dict]:
    """{element: {count, properties}}, in file order."""
    elements: dict[str, dict] = {}
    for words in (line.split() for line in lines):
        if words[:1] == ["element"]:
            elements[words[1]] = {"count": int(words[2]), "properties": []}
        elif words[:1] == ["property"]:
            list(elements.values())[-1]["properties"].append(words[1:])
    return elements


def _parse_body(elements: dict[str, dict], body: bytes) -> PlyMesh:
    vertex = elements["vertex"]
    vertex_type = np.dtype([(name, NUMPY_TYPES[kind]) for kind, name in vertex["properties"]])
    rows = np.frombuffer(body, vertex_type, vertex["count"])
    (_, size_type, corner_type, _), = elements["face"]["properties"]
    face_type = np.dtype([("size", NUMPY_TYPES[size_type]), ("corners", NUMPY_TYPES[corner_type], 3)])
    faces = np.frombuffer(body, face_type, elements["face"]["count"], offset=rows.nbytes)
    if np.any(faces["size"] != 3):
        raise ValueError("a face has more or less than three corners")
    vertices = np.stack([rows[axis] for axis in "xyz"], axis=1).astype(np.float64)
    extra = {name: rows[name] for name in vertex_type.names if name not in "xyz"}
    return PlyMesh(vertices, faces["corners"].astype(np.int64), extra)


def rms_distance_m(a: PlyMesh, b: PlyMesh) -> float:
    """Over nodes of the same number; NaN for meshes of different nodes."""
    if a.vertices_m.shape != b.vertices_m.shape or not len(a.vertices_m):
        return float("nan")
    return float(np.sqrt(np.mean(np.sum((a.vertices_m - b.vertices_m) ** 2, axis=1))))
