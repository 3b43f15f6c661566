"""Where a muscle is attached: connected areas of its nodes that are near bones, told apart into origin and insertion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..program.cli import Problem
from .surface import Points, SignedDistance, Surface, Triangles, Values

FEWEST_NODES = 4  # of an area; fewer are where a muscle passes by
END_SHARE = 1 / 3  # of a muscle's length that counts as its end
CLEAR_MM = 0.15  # that a free node keeps from a bone
PUSHES = 10
MOST_LIFTED_MM = 1.0  # that a corner moves for its faces: more does not help where the other corners are held in the bone
TENDON_END_RADII = 3.0  # how far around its end a tendon is attached


@dataclass
class Area:
    bone: str
    role: str  # origin, insertion
    nodes: NDArray[np.int64]
    mean_gap: float  # millimetres from the bone

    @property
    def name(self) -> str:
        return f"{self.role}_{self.bone}"


def distances_to(muscle: Surface, bones: dict[str, Surface], reach: float) -> dict[str, Values]:
    """{bone: signed distance of each node, negative inside}; infinite where it is farther than `reach` from the bone's box."""
    return {name: bone.distance.within(muscle.vertices, reach) for name, bone in bones.items()}


def areas_near_bones(muscle: Surface, distances: dict[str, Values], near: float, roles: dict[str, str], allowed: NDArray[np.bool_]) -> list[Area]:
    """`roles`: {bone: origin or insertion}; empty: every bone that is near, and roles by `split_by_ends`. `allowed`: nodes that may be
    attached. A node belongs to the nearest bone."""
    names = [name for name in distances if not roles or name in roles]
    if not names:
        return []
    table = np.array([distances[name] for name in names])
    nearest = table.argmin(axis=0)
    areas = []
    for index, name in enumerate(names):
        is_near = allowed & (nearest == index) & (table[index] <= near)
        areas += [Area(name, roles.get(name, ""), nodes, float(np.maximum(table[index][nodes], 0).mean())) for nodes in _large_areas(muscle, is_near)]
    return joined(areas if roles else split_by_ends(muscle, areas))


def joined(areas: list[Area]) -> list[Area]:
    """One of each bone and role."""
    found: dict[tuple[str, str], Area] = {}
    for area in areas:
        old = found.setdefault((area.bone, area.role), area)
        if old is not area:
            sizes = len(old.nodes), len(area.nodes)
            found[area.bone, area.role] = Area(area.bone, area.role, np.concatenate([old.nodes, area.nodes]),
                                               float(np.average([old.mean_gap, area.mean_gap], weights=sizes)))
    return list(found.values())


def split_by_ends(muscle: Surface, areas: list[Area]) -> list[Area]:
    """Along its longest axis a muscle has two ends; the one with the larger area is the origin. A bone belongs to the end that most of
    its area is at. At the insertion only areas at the end count: elsewhere the muscle glides over that bone."""
    if not areas:
        return []
    along = (muscle.vertices - muscle.vertices.mean(axis=0)) @ long_axis(muscle)
    middle = (along.max() + along.min()) / 2
    of_bones = {area.bone: np.concatenate([other.nodes for other in areas if other.bone == area.bone]) for area in areas}
    is_high = {bone: bool(along[nodes].mean() > middle) for bone, nodes in of_bones.items()}
    sizes = {end: sum(len(nodes) for bone, nodes in of_bones.items() if is_high[bone] == end) for end in (True, False)}
    origin = sizes[True] >= sizes[False]
    end = along.min() if origin else along.max()
    found = []
    for area in areas:
        is_origin = is_high[area.bone] == origin
        glides = not is_origin and abs(along[area.nodes].mean() - end) > END_SHARE * np.ptp(along)
        if not glides:
            found.append(Area(area.bone, "origin" if is_origin else "insertion", area.nodes, area.mean_gap))
    return found


def end_of_tendon(muscle: Surface, bone: str, distance: Values, end: Points, radius: float) -> Area:
    """The nodes around a tendon's end that are as near to the bone as the tendon is thick."""
    near_end = np.linalg.norm(muscle.vertices - end, axis=1) < TENDON_END_RADII * radius
    nodes = np.flatnonzero(near_end & (distance <= radius))
    return Area(bone, "insertion", nodes, float(np.maximum(distance[nodes], 0).mean()) if len(nodes) else np.inf)


def moved_out(muscle: Surface, bones: dict[str, Surface], areas: list[Area]) -> tuple[Surface, list[str]]:
    """With the nodes that nothing holds moved out of bones; in words, how many they are and how far they moved, and whether some are
    still inside: between two bones there may be no room."""
    fields = [bone.distance for bone in bones.values()]
    is_free = np.ones(len(muscle.vertices), dtype=bool)
    for area in areas:
        is_free[area.nodes] = False
    vertices = muscle.vertices.copy()
    lifted = np.zeros_like(vertices)
    for _ in range(PUSHES):
        for field in fields:
            lacking = CLEAR_MM - field.within(vertices, CLEAR_MM)
            deep = np.flatnonzero(is_free & (lacking > 0))
            if len(deep):
                vertices[deep] += lacking[deep, None] * field.gradients(vertices[deep])
            before = vertices.copy()
            _lift_faces(vertices, muscle.triangles, field, is_free)
            lifts = lifted + vertices - before
            far = np.flatnonzero(np.linalg.norm(lifts, axis=1) > MOST_LIFTED_MM)
            lifts[far] *= MOST_LIFTED_MM / np.linalg.norm(lifts[far], axis=1)[:, None]
            vertices[far] = before[far] + lifts[far] - lifted[far]
            lifted = lifts
    moves = np.linalg.norm(vertices - muscle.vertices, axis=1)
    told = [f"{np.count_nonzero(moves)} free nodes moved out of bones, by up to {moves.max():.2f} mm"] if moves.any() else []
    inside = is_free & (np.min([field.within(vertices, 0.0) for field in fields], axis=0) < 0) if fields else is_free & False
    return Surface(vertices, muscle.triangles), told + ([f"{np.count_nonzero(inside)} free nodes stay in bones"] if inside.any() else [])


def _lift_faces(vertices: Points, triangles: Triangles, field: SignedDistance, is_free: NDArray[np.bool_]) -> None:
    """Moves the free corners of triangles whose middles, or the middles of whose edges, are in the bone, or nearly, though the corners are not."""
    corners = vertices[triangles]
    for places in (corners.mean(axis=1), *((corners[:, k] + corners[:, k - 1]) / 2 for k in range(3))):
        near = field.within(places, CLEAR_MM)
        deep = np.flatnonzero((near < CLEAR_MM / 3) & is_free[triangles].any(axis=1))
        if len(deep):
            lift = (CLEAR_MM / 2 - near[deep])[:, None] * field.gradients(places[deep])
            for k in range(3):
                nodes = triangles[deep, k]
                vertices[nodes[is_free[nodes]]] += lift[is_free[nodes]]


def check_muscle(name: str, muscle: Surface, distances: dict[str, Values], areas: list[Area], near: float) -> None:
    """Raises Problem where it can't be simulated."""
    for bone, values in distances.items():
        if (share := float(np.mean(values < 0))) > 0.5:
            raise Problem(f"{share:.0%} of its nodes are inside {bone}; is the mesh in another frame, or another side's?")
    if len({area.bone for area in areas}) == 0:
        bone, values = min(distances.items(), key=lambda one: float(one[1].min()), default=("", np.array([np.inf])))
        where = f"the nearest is {bone}, {values.min():.1f} mm away" if np.isfinite(values.min()) else "none is within reach"
        raise Problem(f"touches no bone within {near:g} mm: {where}; give [[muscle]] name = \"{name}\" a near_mm, or a tendon")


def long_axis(surface: Surface) -> Points:
    found: Points = np.linalg.svd(surface.vertices - surface.vertices.mean(axis=0), full_matrices=False)[2][0]
    return found


def _large_areas(muscle: Surface, chosen: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    ends = muscle.triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    ends = ends[chosen[ends].all(axis=1)]
    size = len(muscle.vertices)
    _, labels = connected_components(coo_matrix((np.ones(len(ends)), ends.T), shape=(size, size)), directed=False)
    counts = np.bincount(labels)
    return [np.flatnonzero(labels == label) for label in np.unique(labels[chosen]) if counts[label] >= FEWEST_NODES]
