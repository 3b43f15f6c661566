"""Muscles that overlap in the pose of the meshes: which, and moved apart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .self_crossings import crossing_triangles
from .surface import Points, Surface, Triangles, merged

ROUNDS = 40
CLEAR_MM = 0.1  # between muscles that were moved apart
BESIDE_MM = 1.0  # of the other's box: triangles that may pass through it
PLACES = 7  # of a triangle that are looked at: its corners, and the middles of its edges and of itself
ROUNDING_MM = 1e-6  # of how far both moved


@dataclass
class Overlap:
    """Of two muscles that pass through each other, or one of which has nodes in the other."""

    muscle: str
    other: str
    triangles: int  # of both that pass through each other
    nodes: int  # of either in the other
    deepest: float  # of them, millimetres
    at: Points | None  # (3,) about where triangles pass


def overlaps_of(muscles: dict[str, Surface]) -> list[Overlap]:
    found = []
    fields = {name: surface.distance for name, surface in muscles.items()}
    names = list(muscles)
    for i, one in enumerate(names):
        for other in names[i + 1:]:
            near = _near(muscles[one], muscles[other]), _near(muscles[other], muscles[one])
            if not len(near[0].triangles) and not len(near[1].triangles):
                continue  # with triangles of one only, that one may be inside the other
            both = merged(list(near))
            own = [crossing_triangles(near[0]), crossing_triangles(near[1]) + len(near[0].triangles)]
            passing = np.setdiff1d(crossing_triangles(both), np.concatenate(own))
            at = np.median(both.corners[passing].mean(axis=1), axis=0) if len(passing) else None
            depths = [-fields[to].within(muscles[of].vertices, BESIDE_MM) for of, to in ((one, other), (other, one))]
            nodes = sum(int(np.count_nonzero(each > 0)) for each in depths)
            if len(passing) or nodes:
                found.append(Overlap(one, other, len(passing), nodes, max(0.0, *(float(each.max()) for each in depths)), at))
    return found


def moved_apart(muscles: dict[str, Surface], held: dict[str, NDArray[np.bool_]], bones: dict[str, Surface], overlaps: list[Overlap]) -> dict[str, float]:
    """Moves the nodes of muscles that overlap, both by half, and out of bones again; `held`: nodes that stay. Only nodes that overlap, and
    those beside them, move. {muscle: how far its farthest node went (mm)}"""
    pairs = [(one.muscle, one.other) for one in overlaps]
    names = sorted({name for pair in pairs for name in pair})
    before = {name: muscles[name].vertices for name in names}
    sides = [_Side(muscles[one], held[one], muscles[other]) for pair in pairs for one, other in (pair, pair[::-1])]
    for _ in range(ROUNDS):
        if not any([side.push() for side in sides]):
            break
        for name in names:
            moved = np.flatnonzero((muscles[name].vertices != before[name]).any(axis=1) & ~held[name])
            for bone in bones.values():
                lacking = CLEAR_MM - bone.distance.within(muscles[name].vertices[moved], CLEAR_MM)
                deep = lacking > 0
                if deep.any():
                    vertices = muscles[name].vertices.copy()
                    vertices[moved[deep]] += lacking[deep, None] * bone.distance.gradients(vertices[moved[deep]])
                    muscles[name].vertices = vertices
    return {name: float(np.linalg.norm(muscles[name].vertices - before[name], axis=1).max()) for name in names}


class _Side:
    """One muscle of a pair, and how far the other is at least from each of its places: a distance changes by no more than both moved. So
    only places are asked that may be too near by now."""

    def __init__(self, surface: Surface, held: NDArray[np.bool_], other: Surface):
        self._surface, self._held, self._other = surface, held, other
        self._seen = surface.vertices, other.vertices
        self._room = [np.zeros(len(surface.triangles)) for _ in range(PLACES)]

    def push(self) -> bool:
        """Out of the other by half of what is lacking; corners with the middles of their edges and triangles."""
        seen, self._seen = self._seen, (self._surface.vertices, self._other.vertices)
        moved = sum(float(np.linalg.norm(now - was, axis=1).max()) for now, was in zip(self._seen, seen))
        vertices, triangles = self._surface.vertices, self._surface.triangles
        lift = np.zeros_like(vertices)
        for (places, corners), room in zip(_places(vertices, triangles), self._room):
            room -= moved
            asked = np.flatnonzero(room <= ROUNDING_MM)
            if not len(asked):
                continue
            distances = self._other.distance.within(places[asked], BESIDE_MM)
            room[asked] = np.where(np.isfinite(distances), distances, BESIDE_MM) - CLEAR_MM
            deep = asked[room[asked] < 0]
            push = -0.5 * room[deep, None] * self._other.distance.gradients(places[deep])
            for k in corners:
                nodes = triangles[deep, k]
                longer = (push**2).sum(axis=1) > (lift[nodes] ** 2).sum(axis=1)
                lift[nodes[longer]] = push[longer]
        lift[self._held] = 0.0
        if lift.any():
            self._surface.vertices = vertices + lift
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
