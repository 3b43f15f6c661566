"""Modes of shape: how the meshes of a folder differ, which have the same vertices in the same order. Lengths in metres."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..anatomy.mesh_file import READERS, read_mesh
from ..anatomy.surface import Points, Surface
from ..program.cli import Problem
from .deformation import Map, carried, samples_of
from .shape_words import MODES

FEWEST = 3
ROUNDS = 40  # of nearest points
SAMPLES = 1200
NEAR = 0.015  # of the bone's diagonal: a mean shape that is farther off (RMS) is another bone
OTHER_SIDE = 0.7  # of how far it is off: a mirrored one that is less is of the other side


@dataclass
class Modes:
    """On a bone of the scene."""

    points: Points  # (n, 3) of the mean shape, brought over the bone
    directions: Points  # (k, n, 3), of one standard deviation each
    off: float  # RMS distance of the mean shape from the bone and of the bone from it, the larger one, over the bone's diagonal
    scale: float  # by which the mean shape was made larger
    explained: list[float]  # share of the variance

    def map_of(self, amounts: list[float]) -> Map:
        """`amounts`: in standard deviations, of the first modes; those beyond the last one do nothing."""
        own = amounts[: len(self.directions)]
        moved = np.tensordot(np.array(own), self.directions[: len(own)], axes=1)
        return carried(self.points, moved)


def read_modes(folder: Path, bone: Surface, name: str) -> Modes:
    """Raises Problem."""
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in READERS) if folder.is_dir() else []
    if len(files) < FEWEST:
        raise Problem(f"{folder}: has {len(files)} meshes; modes need {FEWEST} or more, of {', '.join(sorted(READERS))}")
    meshes = [read_mesh(path) for path in files]
    for path, mesh in zip(files, meshes):
        if mesh.triangles.shape != meshes[0].triangles.shape or (mesh.triangles != meshes[0].triangles).any():
            raise Problem(f"{path}: its triangles differ from those of {files[0].name}; meshes have to correspond, vertex by vertex")
    shapes = _aligned(np.array([mesh.vertices for mesh in meshes]))
    mean = shapes.mean(axis=0)
    _, deviations, rows = np.linalg.svd((shapes - mean).reshape(len(shapes), -1), full_matrices=False)
    kept = [k for k in range(min(MODES, len(shapes) - 1)) if deviations[k] > 1e-9 * deviations[0]]
    if not kept or not deviations[0] > 0:
        raise Problem(f"{folder}: all of its meshes have one shape; there is no mode")
    scale, rotation, shift, off = _brought_over(Surface(mean, meshes[0].triangles), bone)
    mirrored = _brought_over(Surface(mean * [-1, 1, 1], meshes[0].triangles), bone)[3]
    if mirrored < OTHER_SIDE * off:
        raise Problem(f"{folder}: its mean shape fits {name} better when mirrored ({mirrored / bone.diagonal:.1%} of the diagonal off, else "
                      f"{off / bone.diagonal:.1%}); take meshes of the same side")
    if off > NEAR * bone.diagonal:
        raise Problem(f"{folder}: its mean shape is {off / bone.diagonal:.1%} of the diagonal off {name} (RMS, at most {NEAR:.1%}); "
                      "is it the same bone, and all of it?")
    over = scale * mean @ rotation.T + shift
    picked = np.unique(np.linspace(0, len(over) - 1, min(SAMPLES, len(over))).astype(int))
    _, first = np.unique(over[picked], axis=0, return_index=True)
    picked = picked[np.sort(first)]
    directions = [scale * deviations[k] / np.sqrt(len(shapes) - 1) * rows[k].reshape(-1, 3)[picked] @ rotation.T for k in kept]
    shares = deviations**2 / (deviations**2).sum()
    return Modes(over[picked], np.array(directions), off / bone.diagonal, scale, [float(shares[k]) for k in kept])


def _aligned(shapes: Points) -> Points:
    """Moved and turned onto their mean, not scaled. Source: Gower 1975, Psychometrika 40, 33."""
    shapes = shapes - shapes.mean(axis=1, keepdims=True)
    mean = shapes[0]
    for _ in range(10):
        shapes = np.array([one @ _rotation(one, mean).T for one in shapes])
        mean = shapes.mean(axis=0)
    return shapes


def _rotation(points: Points, onto: Points) -> Points:
    """That brings points best onto others, which correspond. Source: Kabsch 1976, Acta Cryst. A32, 922."""
    u, _, v = np.linalg.svd(onto.T @ points)
    found: Points = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return found


def _brought_over(mean: Surface, bone: Surface) -> tuple[float, Points, Points, float]:
    """Scale, rotation, shift and RMS distance of the best of four starts by principal axes. Source: iterative closest points (Besl
    and McKay 1992, IEEE PAMI 14, 239)."""
    source, target = samples_of(mean, SAMPLES), samples_of(bone, 20 * SAMPLES)
    tree = cKDTree(target)
    centre, middle = source.mean(axis=0), target.mean(axis=0)
    own, other = (np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2] for points in (source, target))
    best: tuple[float, Points, Points, float] | None = None
    for signs in product((1, -1), repeat=3):
        rotation = other.T @ np.diag(signs) @ own
        if np.linalg.det(rotation) < 0:
            continue
        scale = float(np.sqrt(((target - middle) ** 2).sum(axis=1).mean() / ((source - centre) ** 2).sum(axis=1).mean()))
        shift = middle - scale * rotation @ centre
        for _ in range(ROUNDS):
            nearest = target[tree.query(scale * source @ rotation.T + shift)[1]]
            rotation = _rotation(source - centre, nearest - nearest.mean(axis=0))
            turned = (source - centre) @ rotation.T
            scale = float((turned * (nearest - nearest.mean(axis=0))).sum() / (turned**2).sum())
            shift = nearest.mean(axis=0) - scale * rotation @ centre
        placed = scale * source @ rotation.T + shift
        there, back = tree.query(placed)[0], cKDTree(placed).query(target)[0]
        # The bone has more samples, whose distances to the nearest of few are no smaller than these are apart.
        apart = np.median(cKDTree(placed).query(placed, 2)[0][:, 1])
        off = float(max(np.sqrt((there**2).mean()), np.sqrt((np.maximum(back - apart, 0) ** 2).mean())))
        if best is None or off < best[3]:
            best = (scale, rotation, shift, off)
    assert best is not None
    return best
