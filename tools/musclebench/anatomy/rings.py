"""Where retinacula hold a tendon: rings around it that bones carry."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..program.cli import Problem
from .surface import Points, Surface

ROOM_MM = 1.5  # between a tendon and its ring: a band of tissue gives way
FARTHEST_MM = 15.0  # that a ring's place, which is read off by eye, may be from the tendon
SLIDE_MM = 50.0  # how far a tendon slides: an arm of 50 mm over a radian


@dataclass
class Ring:
    """Millimetres, in the frame of the meshes."""

    bone: str
    centre: Points
    axis: Points  # along the tendon
    radius: float
    half_width: float


def ring_around(surface: Surface, path: Points, bone: str, near: Points, room: float = ROOM_MM) -> Ring:
    """Around the tendon at the point of its path that is nearest. Raises Problem."""
    distances = np.linalg.norm(path - near, axis=1)
    at = int(distances[1:-1].argmin()) + 1
    if distances[at] > FARTHEST_MM:
        raise Problem(f"a ring is {distances[at]:.0f} mm from its tendon; correct its `at`")
    axis = path[at + 1] - path[at - 1]
    axis /= np.linalg.norm(axis)
    heights = (surface.vertices - path[at]) @ axis
    edges = np.unique(np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    edges = edges[(heights[edges[:, 0]] < 0) != (heights[edges[:, 1]] < 0)]
    ends, low, high = surface.vertices[edges], heights[edges[:, 0]], heights[edges[:, 1]]
    section = ends[:, 0] + (low / (low - high))[:, None] * (ends[:, 1] - ends[:, 0])
    own = _parts(surface, edges)
    nearest = np.linalg.norm(section - path[at], axis=1).argmin()
    section, lengths = section[own == own[nearest]], np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[own == own[nearest]]
    centre = (section.min(axis=0) + section.max(axis=0)) / 2
    centre -= ((centre - path[at]) @ axis) * axis
    across = section - centre
    radius = room + float(np.linalg.norm(across - np.outer(across @ axis, axis), axis=1).max())
    return Ring(bone, centre, axis, radius, max(radius, 0.6 * float(lengths.max())))


def _parts(surface: Surface, edges: Points) -> Points:
    """Of edges that a plane cuts, which belong to one outline: those of one triangle do."""
    index = {(int(a), int(b)): i for i, (a, b) in enumerate(edges)}
    pairs = []
    for corners in surface.triangles[np.isin(surface.triangles, edges).sum(axis=1) >= 2]:
        ends = [(int(corners[k]), int(corners[(k + 1) % 3])) for k in range(3)]
        cut = [index[min(end), max(end)] for end in ends if (min(end), max(end)) in index]
        pairs += [cut] if len(cut) == 2 else []
    found: Points = connected_components(coo_matrix((np.ones(len(pairs)), np.transpose(pairs)), shape=(len(edges), len(edges))), directed=False)[1]
    return found
