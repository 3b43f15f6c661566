"""A small scene of its own files: a ball that falls on a box that turns."""

from pathlib import Path

import numpy as np

SCENE = """
title = "a ball on a box"
[[bone]]
name = "box"
mesh = "box.off"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 20
[muscle]
name = "ball"
mesh = "ball.off"
[loop]
frames = 12
substeps = 2
[effects.gravity]
[effects.edge_length]
[effects.bending]
[effects.volume]
"""


def off(vertices, triangles) -> str:
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0"]
    lines += [" ".join(f"{float(x)!r}" for x in vertex) for vertex in vertices]
    return "\n".join(lines + ["3 " + " ".join(map(str, triangle)) for triangle in triangles]) + "\n"


def box(half):
    vertices = [[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array(vertices), [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def ball(radius, centre, rings=9, around=12):
    vertices = [[0, 0, -1]]
    for i in range(1, rings):
        for j in range(around):
            polar, azimuth = np.pi * i / rings, 2 * np.pi * j / around
            vertices.append([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)])
    vertices.append([0, 0, 1])
    top = len(vertices) - 1
    triangles = []
    for j in range(around):
        k = (j + 1) % around
        triangles.append((0, 1 + k, 1 + j))
        triangles.append((top, top - around + j, top - around + k))
        for i in range(rings - 2):
            a, b = 1 + i * around, 1 + (i + 1) * around
            triangles += [(a + j, a + k, b + k), (a + j, b + k, b + j)]
    return radius * np.array(vertices) + centre, triangles


TWO_MUSCLES = """[[muscle]]
name = "ball"
mesh = "ball.off"
[[muscle]]
name = "other"
mesh = "other.off"
[contact]
muscle_contact = true
"""


def write_scene_of_two(folder: Path) -> Path:
    """Two balls side by side that begin half a millimetre in each other."""
    alone = write_scene(folder)
    alone.write_text(alone.read_text().replace('[muscle]\nname = "ball"\nmesh = "ball.off"\n', TWO_MUSCLES))
    (folder / "other.off").write_text(off(*ball(0.02, [-0.0345, 0, 0.0485])))
    return alone


def write_scene(folder: Path) -> Path:
    (folder / "scene.toml").write_text(SCENE)
    (folder / "box.off").write_text(off(*box(0.03)))
    (folder / "ball.off").write_text(off(*ball(0.02, [0.005, 0, 0.0485])))
    return folder / "scene.toml"


def write_scene_of_balls(folder: Path) -> Path:
    """On a bone that is round, fields and voxels err."""
    scene = write_scene(folder)
    (folder / "box.off").write_text(off(*ball(0.03, [0, 0, 0], rings=18, around=24)))
    return scene
