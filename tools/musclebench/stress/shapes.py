"""Closed surfaces, each a map of a box of squares: balls, bars, needles, rings that close, dented lumps. And a room."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Corners = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    points: Points  # m
    triangles: Corners  # counter-clockwise from outside

    def placed(self, rotation: Points, at_m: Points) -> "Mesh":
        return Mesh(self.points @ rotation.T + at_m, self.triangles)


def box(cells: tuple[int, int, int]) -> Mesh:
    """From -1 to 1 along each axis, with so many squares along it."""
    points: dict[tuple[int, ...], int] = {}
    triangles = []
    for axis in range(3):
        across, up = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, cells[axis]):
            for i in range(cells[across]):
                for j in range(cells[up]):
                    square = []
                    for step in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[across], at[up] = end, i + step[0], j + step[1]
                        square.append(points.setdefault(tuple(at), len(points)))
                    square = square if end else square[::-1]
                    triangles += [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
    places = 2 * np.array(list(points), dtype=float) / np.array(cells) - 1
    return Mesh(places, np.array(triangles, dtype=np.int64))


def ball(points: Points) -> Points:
    round_it: Points = points / np.linalg.norm(points, axis=1, keepdims=True) * np.abs(points).max(axis=1, keepdims=True)
    return round_it


def bar(points: Points) -> Points:
    return points


def needle(points: Points) -> Points:
    """To a point at its upper end, nearly."""
    thick = (1.02 - points[:, 2:]) / 2.02
    return np.hstack([points[:, :2] * thick, points[:, 2:]])


def hook(points: Points) -> Points:
    """A bar bent by 300 degrees: its ends look at each other."""
    angle = points[:, 2] * np.radians(150)
    radius = 1 + 0.3 * points[:, 0]
    return np.stack([radius * np.cos(angle), 0.3 * points[:, 1], radius * np.sin(angle)], axis=1)


SHAPES: dict[str, tuple[Callable[[Points], Points], tuple[float, float, float]]] = {  # with half sizes over the largest
    "ball": (ball, (1.0, 1.0, 1.0)), "lump": (ball, (0.5, 0.8, 1.0)), "block": (bar, (0.7, 0.8, 1.0)), "bar": (bar, (0.2, 0.25, 1.0)),
    "plate": (bar, (0.04, 1.0, 1.0)), "needle": (needle, (0.08, 0.08, 1.0)), "hook": (hook, (1.0, 1.0, 1.0)),
}


def shape(name: str, half_m: float, cells: int, random: np.random.Generator) -> Mesh:
    """With up to `cells` squares along its longest side, dented at random. Turned anyhow, about 0."""
    mapped, sizes = SHAPES[name]
    along = [max(1, round(cells * size)) for size in (sizes if mapped is not hook else (0.3, 0.3, 2.0))]
    raw = box((along[0], along[1], along[2]))
    points = mapped(raw.points)
    for _ in range(3):
        wave, phase = random.normal(size=3) * 2, random.uniform(0, 2 * np.pi)
        points = points + 0.03 * np.sin(points @ wave + phase)[:, None] * random.normal(size=3)
    points = points * sizes * half_m
    return Mesh(points, raw.triangles).placed(turn(random), np.zeros(3))


def room(half_m: float, wall_m: float, cells: int) -> Mesh:
    """A box with a wall around what is in it."""
    inner, outer = box((cells, cells, cells)), box((cells, cells, cells))
    return Mesh(np.vstack([(half_m + wall_m) * outer.points, half_m * inner.points]),
                np.vstack([outer.triangles, inner.triangles[:, ::-1] + len(outer.points)]))


def turn(random: np.random.Generator) -> Points:
    """Any rotation, each as likely (Shoemake 1992)."""
    w, x, y, z = (quaternion := random.normal(size=4)) / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def write_stl(path: Path, mesh: Mesh) -> None:
    """Binary, in millimetres and single precision, as strangers' meshes are: each triangle has corners for itself."""
    rows = np.zeros(len(mesh.triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = 1e3 * mesh.points[mesh.triangles]
    path.write_bytes(b"\0" * 80 + np.uint32(len(rows)).tobytes() + rows.tobytes())
