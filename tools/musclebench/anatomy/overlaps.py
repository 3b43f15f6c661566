"""Muscles that overlap in the pose of the meshes: which, and moved apart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .self_crossings import crossing_triangles
from .surface import Points, SignedDistance, Surface, Triangles, merged

ROUNDS = 40
CLEAR_MM = 0.1  # between muscles that were moved apart
BESIDE_MM = 1.0  # of a place that overlaps: triangles that may pass through


@dataclass
class Overlap:
    """Of two muscles that pass through each other, or one of which has nodes in the other."""

    muscle: str
    other: str
    triangles: int  # of both that pass through each other
    nodes: int  # of either in the other
    deepest: float  # of them, millimetres


def overlaps_of(muscles: dict[str, Surface]) -> list[Overlap]:
    found = []
    fields = {name: SignedDistance(surface) for name, surface in muscles.items()}
    names = list(muscles)
    for i, one in enumerate(names):
        for other in names[i + 1:]:
            near = _near(muscles[one], muscles[other]), _near(muscles[other], muscles[one])
            if not len(near[0].triangles) or not len(near[1].triangles):
                continue
            triangles = crossing_triangles(merged(list(near))) - sum(crossing_triangles(part) for part in near)
            depths = [-fields[to].within(muscles[of].vertices, BESIDE_MM) for of, to in ((one, other), (other, one))]
            nodes = sum(int(np.count_nonzero(each > 0)) for each in depths)
            if triangles > 0 or nodes:
                found.append(Overlap(one, other, max(triangles, 0), nodes, max(0.0, *(float(each.max()) for each in depths))))
    return found


def moved_apart(muscles: dict[str, Surface], held: dict[str, NDArray[np.bool_]], bones: dict[str, Surface], overlaps: list[Overlap]) -> dict[str, float]:
    """Moves the nodes of muscles that overlap, both by half, and out of bones again; `held`: nodes that stay. Only nodes that overlap, and
    those beside them, move. {muscle: how far its farthest node went (mm)}"""
    pairs = [(one.muscle, one.other) for one in overlaps]
    names = sorted({name for pair in pairs for name in pair})
    before = {name: muscles[name].vertices.copy() for name in names}
    fields = {name: SignedDistance(bone) for name, bone in bones.items()}
    for _ in range(ROUNDS):
        if not any([_pushed(muscles, held, one, other) for pair in pairs for one, other in (pair, pair[::-1])]):
            break
        for name in names:
            moved = np.flatnonzero((muscles[name].vertices != before[name]).any(axis=1) & ~held[name])
            for field in fields.values():
                lacking = CLEAR_MM - field.within(muscles[name].vertices[moved], CLEAR_MM)
                deep = lacking > 0
                if deep.any():
                    muscles[name].vertices[moved[deep]] += lacking[deep, None] * field.gradients(muscles[name].vertices[moved[deep]])
    return {name: float(np.linalg.norm(muscles[name].vertices - before[name], axis=1).max()) for name in names}


def _pushed(muscles: dict[str, Surface], held: dict[str, NDArray[np.bool_]], one: str, other: str) -> bool:
    """Out of the other by half of what is lacking; corners with the middles of their edges and triangles."""
    surface, field = muscles[one], SignedDistance(muscles[other])
    vertices, triangles = surface.vertices, surface.triangles
    near = _triangles_near(surface, muscles[other])
    if not len(near):
        return False
    lift = np.zeros_like(vertices)
    for places, corners in _places(vertices, triangles[near]):
        lacking = CLEAR_MM - field(places)
        deep = np.flatnonzero(lacking > 0)
        if not len(deep):
            continue
        push = 0.5 * lacking[deep, None] * field.gradients(places[deep])
        for k in corners:
            nodes = triangles[near][deep, k]
            longer = (push**2).sum(axis=1) > (lift[nodes] ** 2).sum(axis=1)
            lift[nodes[longer]] = push[longer]
    lift[held[one]] = 0.0
    surface.vertices = vertices + lift
    return bool((lift**2).sum(axis=1).max() > (0.05 * CLEAR_MM) ** 2)


def _places(vertices: Points, triangles: Triangles) -> list[tuple[Points, tuple[int, ...]]]:
    corners = vertices[triangles]
    at_corners: list[tuple[Points, tuple[int, ...]]] = [(corners[:, k], (k,)) for k in range(3)]
    at_edges: list[tuple[Points, tuple[int, ...]]] = [((corners[:, k] + corners[:, (k + 1) % 3]) / 2, (k, (k + 1) % 3)) for k in range(3)]
    return [*at_corners, *at_edges, (corners.mean(axis=1), (0, 1, 2))]


def _triangles_near(surface: Surface, other: Surface) -> NDArray[np.int64]:
    corners = surface.corners
    low, high = other.vertices.min(axis=0) - BESIDE_MM, other.vertices.max(axis=0) + BESIDE_MM
    return np.flatnonzero(((corners.max(axis=1) > low) & (corners.min(axis=1) < high)).all(axis=1))


def _near(surface: Surface, other: Surface) -> Surface:
    return Surface(surface.vertices, surface.triangles[_triangles_near(surface, other)])
