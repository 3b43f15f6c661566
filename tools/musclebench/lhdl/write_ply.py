"""Writer of the data folder's PLY files: binary little-endian, double x y z, triangles as uchar + 3 ints."""

from pathlib import Path

import numpy as np

COMMENTS = (
    "LHDL dataset, right hip; see README.md at the top of the data folder",
    "licence CC BY-NC-SA 2.0 BE; units metre; frame x left, y posterior, z superior",
)


def ply_bytes(vertices_m: np.ndarray, triangles: np.ndarray, comments=COMMENTS) -> bytes:
    """vertices (n, 3) in metres, triangles (m, 3)."""
    header = ["ply", "format binary_little_endian 1.0", *(f"comment {c}" for c in comments)]
    header += [f"element vertex {len(vertices_m)}", *(f"property double {axis}" for axis in "xyz")]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    faces = np.empty(len(triangles), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, triangles
    return ("\n".join(header) + "\n").encode() + vertices_m.astype("<f8").tobytes() + faces.tobytes()


def write_ply(path: Path, vertices_m: np.ndarray, triangles: np.ndarray, comments=COMMENTS) -> None:
    path.write_bytes(ply_bytes(vertices_m, triangles, comments))
