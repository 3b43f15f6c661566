"""Reads a query set of musclebench (datasets/queries/README.md)."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class QuerySet:
    about: str
    bones: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)  # {name: (vertices_m (n, 3), triangles (m, 3))}
    arrays: dict[str, np.ndarray] = field(default_factory=dict)  # by the names below, one row a query


def read_query_set(path) -> QuerySet:
    with open(path, "rb") as file:
        if file.readline() != b"musclebench queries 1\n":
            raise ValueError(f"{path}: is no query set of version 1")
        found = QuerySet(file.readline().decode().rstrip("\n"))
        bones, queries = map(int, file.readline().split())
        counts = [file.readline().decode().split() for _ in range(bones)]

        def read(kind: str, rows: int, columns: int) -> np.ndarray:
            values = np.frombuffer(file.read(np.dtype(kind).itemsize * rows * columns), kind)
            return values.reshape(rows, columns) if columns > 1 else values

        for vertices, triangles, name in counts:
            found.bones[name] = (read("<f8", int(vertices), 3), read("<i4", int(triangles), 3))
        for name, kind, columns in (("points_m", "<f8", 3), ("closest_m", "<f8", 3), ("distances_m", "<f8", 1), ("bone", "<i4", 1),
                                    ("node", "<i4", 1), ("step", "<i4", 1), ("difficulty", "<i4", 1)):
            found.arrays[name] = read(kind, queries, columns)
    return found
