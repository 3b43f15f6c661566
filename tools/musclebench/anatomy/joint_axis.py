"""The axis of a joint from the shape of its articular surface."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..program.cli import Problem
from .surface import Points, Surface

UNCERTAIN = 0.2  # cosine of an angle
FACING_MM = 6.0  # a point of the surface articulates where the other one is as near


@dataclass
class Axis:
    direction: Points  # (3,) unit length
    centre: Points  # (3,)
    radius: float | None = None  # of the fitted shape, where it was fitted
    rms: float | None = None  # distance of the surface's points from it


def articulating_points(surface: Surface, facing: Surface | None) -> Points:
    """Centres of triangles of `surface`; of those that face the other, and lie near to it, where there is one."""
    corners = surface.corners
    centres: Points = corners.mean(axis=1)
    if facing is None:
        return centres
    distance = facing.distance
    gaps = distance.within(centres, FACING_MM)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    near = np.flatnonzero(gaps < FACING_MM)
    away = distance.gradients(centres[near])
    near = near[np.einsum("ij,ij->i", normals[near], away) < 0]
    return centres[near]


def fit_cylinder(points: Points, towards: Points) -> Axis:
    """By least squares of the distances, from several starts. Source: the parametrisation of an axis by two angles and the two
    coordinates at which it passes the centroid's plane (Forbes 1991, NPL report DITC 140/89)."""
    centroid = points.mean(axis=0)
    local = points - centroid
    frame = np.linalg.svd(local, full_matrices=False)[2]
    best = None
    for first in range(3):
        axes = np.roll(frame, -first, axis=0)
        at = local @ axes.T
        size = float(np.abs(at).max())
        for side in (-1.0, 1.0):
            for along in (1, 2):
                start = np.zeros(5)
                start[2 + along - 1], start[4] = side * size, size
                found = least_squares(_off_cylinder, start, args=(at,), x_scale=[0.3, 0.3, size, size, size])
                if best is None or found.cost < best[0].cost:
                    best = (found, axes)
    assert best is not None
    found, axes = best
    direction = _direction(found.x) @ axes
    if abs(direction @ towards) < UNCERTAIN * np.linalg.norm(towards):
        raise Problem("the fitted axis is nearly at right angles to axis_towards, which does not tell its sign; give another direction")
    direction *= np.sign(direction @ towards)
    centre = centroid + np.array([0.0, found.x[2], found.x[3]]) @ axes
    centre += ((centroid - centre) @ direction) * direction
    return Axis(direction, centre, float(abs(found.x[4])), float(np.sqrt(np.mean(found.fun**2))))


def fit_sphere(points: Points, towards: Points) -> Axis:
    """Its centre; the axis is the wanted direction itself."""
    centroid = points.mean(axis=0)
    local = points - centroid
    rows = np.column_stack([2 * local, np.ones(len(local))])
    solved = np.linalg.lstsq(rows, np.einsum("ij,ij->i", local, local), rcond=None)[0]
    radius = float(np.sqrt(solved[3] + solved[:3] @ solved[:3]))
    off = np.linalg.norm(local - solved[:3], axis=1) - radius
    return Axis(towards / np.linalg.norm(towards), centroid + solved[:3], radius, float(np.sqrt(np.mean(off**2))))


def _direction(parameters: Points) -> Points:
    found: Points = np.array([1.0, parameters[0], parameters[1]])
    return found / np.linalg.norm(found)


def _off_cylinder(parameters: Points, points: Points) -> Points:
    relative = points - np.array([0.0, parameters[2], parameters[3]])
    direction = _direction(parameters)
    across = relative - np.outer(relative @ direction, direction)
    off: Points = np.linalg.norm(across, axis=1) - parameters[4]
    return off
