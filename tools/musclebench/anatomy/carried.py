"""Places that a map tells were read off one body. Of another one they are carried along, bone by bone, from the left to the right
side, too."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..program.cli import Problem
from .anatomy_map import UNITS, AnatomyMap, JointWords
from .joint_axis import Axis
from .joints import fitted_axis
from .mesh_file import read_mesh
from .surface import Points, Surface, sample_points

SAME_MM = 0.5  # a bone whose middle is nearer than that to the reference's is the reference's own
FEWEST_BONES = 4  # that tell where a body lies, and which side it is
LEAST_CLEAR = 1.5  # by which the other side has to fit worse
MOST_OFF = 0.15  # RMS of the middles of bones over how far they are spread: more is another part of the body
STEPS, MOST_POINTS, KEPT = 400, 2000, 0.9  # of the search for closest points; the farthest tenth may be another shape
STILL_MM = 1e-3  # a step that moves points by less is the last


@dataclass
class Place:
    """p' = matrix p + shift; the matrix turns, scales and, from side to side, mirrors. In millimetres."""

    matrix: Points
    shift: Points

    def __call__(self, points: Points) -> Points:
        found: Points = points @ self.matrix.T + self.shift
        return found

    @property
    def is_mirrored(self) -> bool:
        return bool(np.linalg.det(self.matrix) < 0)

    @property
    def scale(self) -> float:
        return float(abs(np.linalg.det(self.matrix)) ** (1 / 3))

    def axis(self, direction: Points) -> Points:
        """Of a rotation: a mirror turns its sense round."""
        found: Points = np.sign(np.linalg.det(self.matrix)) * self.matrix @ direction
        return found / np.linalg.norm(found)


@dataclass
class Carried:
    anatomy: AnatomyMap
    words: str  # what was done


def carried(anatomy: AnatomyMap, solids: dict[str, Surface], unit: str) -> Carried | None:
    """The map with the places of this body; nothing where it has no reference, or this is the reference. `solids`: bones, in
    millimetres. Raises Problem where the two are no such bodies."""
    if anatomy.reference is None:
        return None
    reference = _reference(anatomy.reference)
    known = {name: surface for name, surface in reference.items() if name in solids}
    if len(known) < FEWEST_BONES:
        raise Problem(f"{anatomy.path}: {len(known)} bones of its reference ({anatomy.reference}) are in the folder, and it takes {FEWEST_BONES} to find "
                      "out how the two lie; are the bones called alike?")
    middles = np.array([[_middle(known[name]), _middle(solids[name])] for name in known])
    if np.linalg.norm(middles[:, 0] - middles[:, 1], axis=1).max() < SAME_MM:
        here = Place(np.eye(3), np.zeros(3))
        if unit == anatomy.reference_unit:
            return None
        return Carried(_with_places(anatomy, reference, dict.fromkeys(known, here), here, unit), "in another unit")
    body = _body_place(middles[:, 0], middles[:, 1], anatomy)
    bones = {name: _bone_place(surface, solids[name], body) for name, surface in known.items()}
    words = (f"{'mirrored and ' if body.is_mirrored else ''}scaled by {body.scale:.3f}; bones then fit to "
             f"{max(_off(known[name], solids[name], place) for name, place in bones.items()):.1f} mm (RMS) or better")
    return Carried(_with_places(anatomy, reference, bones, body, unit), words)


def _reference(folder: Path) -> dict[str, Surface]:
    if not (files := sorted(folder.glob("*.ply"))):
        raise Problem(f"{folder}: has no meshes (*.ply); name the folder `meshes` of an import")
    surfaces = {}
    for path in files:
        surface = read_mesh(path)
        surfaces[path.stem] = Surface(surface.vertices * UNITS["m"], surface.triangles)
    return surfaces


def _middle(surface: Surface) -> Points:
    middle: Points = np.average(surface.corners.mean(axis=1), axis=0, weights=surface.areas)
    return middle


def fitted(source: Points, target: Points, mirrors: bool, scale: float | None = None) -> Place:
    """That brings points best onto others, which correspond; the scale is found, or given. Source: Umeyama 1991, IEEE Trans. Pattern Anal. 13, 376."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    u, sizes, v = np.linalg.svd(b.T @ a)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ v)) * (-1 if mirrors else 1)])
    matrix = (scale or (sizes @ signs) / (a * a).sum()) * (u * signs) @ v
    return Place(matrix, target.mean(axis=0) - matrix @ source.mean(axis=0))


def _body_place(source: Points, target: Points, anatomy: AnatomyMap) -> Place:
    def off(place: Place) -> float:
        return float(np.sqrt(((place(source) - target) ** 2).sum(axis=1).mean()))
    best, other = sorted((fitted(source, target, mirrors) for mirrors in (False, True)), key=off)
    spread = float(np.sqrt(((target - target.mean(axis=0)) ** 2).sum(axis=1).mean()))
    if off(best) > MOST_OFF * spread:
        raise Problem(f"{anatomy.path}: the bones lie otherwise than in its reference ({anatomy.reference}), by {off(best):.0f} mm (RMS); is it the same part "
                      "of the body in such a pose?")
    if off(other) < LEAST_CLEAR * off(best):
        raise Problem(f"{anatomy.path}: the bones do not tell whether this is the side of its reference ({anatomy.reference}) or the other one; "
                      "import more bones")
    return best


def _bone_place(source: Surface, target: Surface, start: Place) -> Place:
    """By closest points (Besl and McKay 1992), from where the body lies. With the body's scale: half a bone would shrink the whole one."""
    points = source.vertices[:: max(1, len(source.vertices) // MOST_POINTS)]
    others = sample_points(target)
    tree, place, there = cKDTree(others), start, start(points)
    for _ in range(STEPS):
        distances, nearest = tree.query(there)
        near = distances <= np.quantile(distances, KEPT)
        place = fitted(points[near], others[nearest[near]], start.is_mirrored, start.scale)
        before, there = there, place(points)
        if np.abs(there - before).max() < STILL_MM:
            break
    return place


def _off(source: Surface, target: Surface, place: Place) -> float:
    return float(np.sqrt((target.distance(place(source.vertices)) ** 2).mean()))


def _with_places(anatomy: AnatomyMap, reference: dict[str, Surface], bones: dict[str, Place], body: Place, unit: str) -> AnatomyMap:
    result = deepcopy(anatomy)
    into_mm, into_file = UNITS[anatomy.reference_unit], 1 / UNITS[unit]
    fields = {name: reference[name].distance for name in bones}

    def near(point: Points) -> str:
        return min(fields, key=lambda name: abs(float(fields[name]((point * into_mm)[None])[0])))

    def place_of(bone: str, point: Points) -> Points:
        """With that bone, or with the nearest."""
        moved: Points = bones[bone if bone in bones else near(point)]((point * into_mm)[None])[0] * into_file
        return moved

    for joint in result.joints:
        if joint.fit:
            joint.otherwise = _carried_axis(joint, reference, lambda centre_mm: bones[near(centre_mm / into_mm)])
        if joint.axis_towards is not None:
            joint.axis_towards = bones.get(joint.surface, body).axis(joint.axis_towards)
        if joint.axis is not None and joint.centre is not None:
            joint.axis, joint.centre = bones[near(joint.centre)].axis(joint.axis), place_of("", joint.centre)
    for muscle in result.muscles:
        if (tendon := muscle.tendon) is not None:
            tendon.at = place_of(tendon.to, tendon.at)
            tendon.through = np.array([place_of("", point) for point in tendon.through]).reshape(-1, 3)
            tendon.rings = [(bone, place_of(bone, at), room) for bone, at, room in tendon.rings]
    return result


def _carried_axis(words: JointWords, reference: dict[str, Surface], place_at: Callable[[Points], Place]) -> Axis | None:
    """What is fitted to the reference; nothing where that has no such surface either."""
    try:
        axis = fitted_axis(words, reference)
    except Problem:
        return None
    place = place_at(axis.centre)
    return Axis(place.axis(axis.direction), place(axis.centre[None])[0])
