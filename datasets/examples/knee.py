#!/usr/bin/python3
"""Writes a small scene of one's own: a knee of two bones and a muscle behind them, in three file formats.

datasets/examples/knee.py [FOLDER]      default: my_knee; writes tibia.ply, femur.obj, popliteus.stl and my_knee.toml

The shapes are made up: two shafts with a round end each, and a strap. Lengths are in metres, z points up, y forward; the
knee bends about the x axis through the origin.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

CONDYLE_RADIUS = 0.030
SHAFT_RADIUS = 0.014
PLATEAU_Z = -0.034
GAP = 0.0015  # between the muscle and the bones at its ends

SCENE = """\
title = "My knee"
preset = "standard"            # loop and effects; tables below overwrite single keys; `bending = false` removes an effect

[[bone]]
name = "tibia"
mesh = "tibia.ply"             # PLY, OBJ, STL, OFF, ... in metres; relative to this file

[[bone]]
name = "femur"
mesh = "femur.obj"
[bone.motion]                  # a rotation about an axis through a centre; or table = "knee.mot", column = "angle"
axis = [-1.0, 0.0, 0.0]
centre_m = [0.0, 0.0, 0.0]
from_deg = 0.0
to_deg = 40.0

[muscle]
name = "popliteus"
mesh = "popliteus.stl"
fibres = "between_attachments" # or "none", or "landmarks.json#muscle"

[[attachment]]                 # nodes within distance_m of the bone, over the outlined area grown by margin_m
name = "origin"
bone = "femur"
outline_m = {origin}
distance_m = 0.003
margin_m = 0.002

[[attachment]]
name = "insertion"
bone = "tibia"
outline_m = {insertion}
distance_m = 0.003
margin_m = 0.002

[effects.bending]
compliance_rad_per_n_m = 1e6

[effects.self_contact]         # at full flexion the muscle folds
"""


def femur_radius(z: np.ndarray) -> np.ndarray:
    """Of the round end about the knee's centre, which goes over into the shaft."""
    ball = np.sqrt(np.maximum(CONDYLE_RADIUS**2 - z**2, 0.0))
    return np.where(z < 0.02, ball, SHAFT_RADIUS + (ball - SHAFT_RADIUS) * np.clip((0.026 - z) / 0.006, 0.0, 1.0))


def tibia_radius(z: np.ndarray) -> np.ndarray:
    """Wide below the joint, then the shaft; rounded towards the plateau."""
    wide = SHAFT_RADIUS + 0.018 * np.exp(-(((z - PLATEAU_Z + 0.010) / 0.022) ** 2))
    return wide * np.sqrt(np.clip((PLATEAU_Z - z) / 0.004, 0.0, 1.0))


def lathe(z: np.ndarray, radius: np.ndarray, around: int = 48) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface of revolution about the z axis, from the lowest z to the highest; its ends are points."""
    turn = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    rings = [np.column_stack([r * np.cos(turn), r * np.sin(turn), np.full(around, height)])
             for height, r in zip(z[1:-1], radius[1:-1])]
    return closed_tube(rings, np.array([0.0, 0.0, z[0]]), np.array([0.0, 0.0, z[-1]]))


def closed_tube(rings: list[np.ndarray], first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles that look outwards where a ring turns anticlockwise, seen from its last end."""
    around, count = len(rings[0]), len(rings)
    vertices = np.vstack([*rings, first, last])
    bottom, top = count * around, count * around + 1
    triangles = []
    for i in range(around):
        j = (i + 1) % around
        triangles += [(bottom, j, i), (top, (count - 1) * around + i, (count - 1) * around + j)]
        for ring in range(count - 1):
            a, b = ring * around + i, ring * around + j
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    return vertices, np.array(triangles)


def bone_meshes() -> tuple[tuple, tuple]:
    """Tibia and femur."""
    down = PLATEAU_Z - 0.22 * np.linspace(0.0, 1.0, 60)[::-1] ** 1.5
    tibia = lathe(np.concatenate([[down[0] - 0.004], down]), np.concatenate([[0.0], tibia_radius(down)]))
    # Even steps along the round end: by its angle.
    up = np.concatenate([-CONDYLE_RADIUS * np.cos(np.linspace(0.0, 2.3, 30)), np.linspace(0.024, 0.22, 40)])
    femur = lathe(np.concatenate([up, [0.224]]), np.concatenate([femur_radius(up), [0.0]]))
    return tibia, femur


def muscle_mesh(along: int = 40, around: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """A strap from the back of the femur's round end down to the back of the tibia's shaft."""
    share = np.linspace(0.0, 1.0, along)
    z = 0.008 - 0.100 * share
    bones = np.maximum(femur_radius(z) * (z > PLATEAU_Z), tibia_radius(z) * (z < PLATEAU_Z))
    thickness = 0.0028 * np.sqrt(np.clip(np.minimum(share, 1 - share) / 0.06, 0.05, 1.0))
    # Over the joint's gap, where there is no bone, the strap goes straight.
    back = np.interp(z, *_upper_hull(z[::-1], bones[::-1])) + GAP + thickness
    turn = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    rings = [np.column_stack([0.007 * np.cos(turn), -y - t * np.sin(turn), np.full(around, height)])
             for height, y, t in zip(z, back, thickness)]
    ends = [np.array([0.0, -back[i], z[i] + step]) for i, step in ((0, 0.0015), (-1, -0.0015))]
    return closed_tube(rings, *ends)


def _upper_hull(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a curve with growing x: what a string that is pulled tight over it would do."""
    kept: list[int] = []
    for i in range(len(x)):
        while len(kept) > 1:
            a, b = kept[-2], kept[-1]
            if (y[b] - y[a]) * (x[i] - x[a]) > (y[i] - y[a]) * (x[b] - x[a]):
                break
            kept.pop()
        kept.append(i)
    return x[kept], y[kept]


def write_ply(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Text."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property double {axis}" for axis in "xyz"),
            f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines = [" ".join(map(repr, map(float, vertex))) for vertex in vertices]
    path.write_text("\n".join([*head, *lines, *(f"3 {a} {b} {c}" for a, b, c in triangles)]) + "\n")


def write_obj(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    lines = [f"v {float(x)!r} {float(y)!r} {float(z)!r}" for x, y, z in vertices]
    path.write_text("\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles)]) + "\n")


def write_stl(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Binary: three corners a triangle, which know nothing of their neighbours."""
    corners = vertices[triangles].astype("<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["normal"], rows["corners"] = normals, corners
    path.write_bytes(b"made by knee.py".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes())


def outline(y: float, z_from: float, z_to: float, half_width: float = 0.009) -> str:
    """A rectangle behind the bone."""
    corners = [(-half_width, y, z_from), (half_width, y, z_from), (half_width, y, z_to), (-half_width, y, z_to)]
    return str([[round(value, 4) for value in corner] for corner in corners])


def write_scene(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (tibia, femur), muscle = bone_meshes(), muscle_mesh()
    write_ply(folder / "tibia.ply", *tibia)
    write_obj(folder / "femur.obj", *femur)
    write_stl(folder / "popliteus.stl", *muscle)
    scene = folder / "my_knee.toml"
    scene.write_text(SCENE.format(origin=outline(-0.029, -0.002, 0.012), insertion=outline(-0.016, -0.096, -0.078)))
    return scene


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("my_knee"), help="default: my_knee")
    folder = parser.parse_args().folder
    try:
        print(f"wrote {write_scene(folder)}")
    except OSError as problem:
        print(f"knee.py: {problem}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
