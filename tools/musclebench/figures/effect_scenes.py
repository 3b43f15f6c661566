"""The small scenes, each as it begins (outline) and as it ends: drawn without a display, by sorting triangles."""

import math
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from scipy.spatial import ConvexHull, QhullError

from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones, read_snapshots
from . import style
from .style import plt

COLUMNS = 4
PANEL_INCHES = 1.75
# From the side and a little from above: x to the right, z up.
EYE = np.array([0.25, -1.0, 0.42]) / np.linalg.norm([0.25, -1.0, 0.42])
RIGHT = np.cross([0, 0, 1.0], EYE) / np.linalg.norm(np.cross([0, 0, 1.0], EYE))
UP = np.cross(EYE, RIGHT)
LIGHT = (EYE + 0.8 * UP - 0.6 * RIGHT) / np.linalg.norm(EYE + 0.8 * UP - 0.6 * RIGHT)
MUSCLE_COLOURS = ("#B25850", "#D69D4C")
BONE_COLOUR = "#E8DDBE"
FINEST_M = 0.006  # bones are cut finer, so that sorting triangles by their middles hides what is behind
BEHIND_M = 0.004  # a bone counts as farther from the eye by this: what touches it lies before it
AROUND = 1.25  # of what is shown, over the size of the muscle's shapes


def draw_scenes(runs: list[Run], stem: Path) -> list[Path]:
    if not runs:
        return []
    style.apply_style()
    rows = math.ceil(len(runs) / COLUMNS)
    figure, panels = plt.subplots(rows, COLUMNS, figsize=(style.PAGE_INCHES, rows * PANEL_INCHES), squeeze=False)
    for axes, run in zip(panels.flat, runs):
        draw_snapshot(axes, run, read_snapshots(run)[-1])
        axes.set_title(run.scene.split("/")[-1].replace("_", " "), loc="left", fontsize=7.5)
    for axes in panels.flat[len(runs):]:
        axes.set_axis_off()
    figure.tight_layout(w_pad=0.3, h_pad=0.5)
    return style.save_figure(figure, stem)


def draw_snapshot(axes, run: Run, end: Snapshot) -> None:
    """With the outline of the run's first snapshot, in which nothing has moved."""
    rest = read_snapshots(run)[0]
    bones = [_cut_finely((bone.vertices_m @ rotation.T + translation_m)[bone.triangles])
             for bone, (rotation, translation_m) in zip(read_bones(run).values(), end.poses)]
    muscle = end.mesh.vertices_m[end.mesh.triangles]
    corners = np.concatenate([*bones, muscle])
    colours = np.concatenate([np.tile(to_rgb(BONE_COLOUR), (len(corners) - len(muscle), 1)), _muscle_colours(run, end)])
    nearness = (corners @ EYE).mean(axis=1) - BEHIND_M * (np.arange(len(corners)) < len(corners) - len(muscle))
    axes.add_collection(_painted(corners, colours, nearness))
    axes.add_collection(PolyCollection(_outline(rest), facecolors="none", edgecolors="#7a7a7a", linewidths=0.7,
                                       linestyles=(0, (2, 1.5))))
    shown = np.vstack([_flat(snapshot.mesh.vertices_m) for snapshot in (rest, end)])
    middle, reach = (shown.max(axis=0) + shown.min(axis=0)) / 2, AROUND * np.ptp(shown, axis=0).max() / 2
    axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    axes.set_axis_off()


def _muscle_colours(run: Run, end: Snapshot) -> np.ndarray:
    """One a triangle; several muscles differ."""
    counts = [muscle["triangles"] for muscle in run.record.get("muscles") or []] or [len(end.mesh.triangles)]
    return np.concatenate([np.tile(to_rgb(MUSCLE_COLOURS[i % len(MUSCLE_COLOURS)]), (count, 1))
                           for i, count in enumerate(counts)])


def _cut_finely(corners_m: np.ndarray) -> np.ndarray:
    """Each triangle (3, 3) in four until none has a long edge."""
    while np.linalg.norm(corners_m - np.roll(corners_m, 1, axis=1), axis=2).max() > FINEST_M:
        a, b, c = corners_m[:, 0], corners_m[:, 1], corners_m[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners_m = np.concatenate([np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return corners_m


def _flat(points_m: np.ndarray) -> np.ndarray:
    """To the right and up in the picture."""
    return np.column_stack([points_m @ RIGHT, points_m @ UP])


def _painted(corners_m: np.ndarray, colours: np.ndarray, nearness_m: np.ndarray) -> PolyCollection:
    """What is nearer to the eye is drawn later. As pixels: in an SVG it would be megabytes."""
    normals = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    light = 0.45 + 0.55 * np.abs(normals @ LIGHT) / np.where(lengths > 0, lengths, 1)
    order = np.argsort(nearness_m)
    shaded = np.clip(colours * light[:, None], 0, 1)[order]
    polygons = np.stack([corners_m @ RIGHT, corners_m @ UP], axis=2)[order]
    return PolyCollection(polygons, facecolors=shaded, edgecolors=shaded, linewidths=0.2, rasterized=True)


def _outline(rest: Snapshot) -> list[np.ndarray]:
    """Of each muscle's shadow on the picture; flat ones have none."""
    points = _flat(rest.mesh.vertices_m)
    try:
        return [points[ConvexHull(points).vertices]]
    except QhullError:
        return []
