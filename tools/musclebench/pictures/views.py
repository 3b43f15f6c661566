"""Where to look from: directions of a joint, found from the axis of its motion, and cameras that each scene gets of its
muscle's own shape."""

from dataclasses import dataclass

import numpy as np

from ..results.statistics import percentile
from .rendering import CutPlane, View

OVERVIEW_MARGIN = 1.15
CLOSE_UP_HALF_HEIGHT_SHARE = 0.32  # of the muscle's rest extent along the limb
CUT_MARGIN_M = 0.02
NEAR_SHARE = 0.75  # of the muscle's longest half axis: bones so near are those that it may touch
TILT = 0.6  # of the side view against the view from where the muscle lies


@dataclass
class JointDirections:
    """Unit vectors at rest: about which axis the limb turns, where it points from, and what is in front of both."""

    centre_m: np.ndarray  # on the axis, level with the muscle
    front: np.ndarray
    axis: np.ndarray
    up: np.ndarray


def joint_directions(axis: np.ndarray, centre_m: np.ndarray, moved_m: np.ndarray,
                     muscle_m: np.ndarray) -> JointDirections:
    """The bone that moves hangs down from the axis at rest; where it lies on the axis, the muscle is upright."""
    axis = axis / np.linalg.norm(axis)
    down = _across(moved_m.mean(axis=0) - centre_m, axis)
    if np.linalg.norm(down) < 1e-6:
        down = _across(-principal_axes(muscle_m)[0], axis)
    if np.linalg.norm(down) < 1e-6:
        down = _across(np.eye(3)[np.abs(axis).argmin()], axis)
    down = down / np.linalg.norm(down)
    level = centre_m + axis * ((muscle_m.mean(axis=0) - centre_m) @ axis)
    return JointDirections(level, np.cross(axis, down), axis, -down)


def principal_axes(points_m: np.ndarray) -> np.ndarray:
    """Unit vectors, the longest axis first."""
    return np.linalg.svd(points_m - points_m.mean(axis=0), full_matrices=False)[2]


def views_along_shorter_axes(points_m: np.ndarray, margin: float) -> list[View]:
    """Two, with the longest axis upright. `margin`: half the height over that of the points."""
    centre = (points_m.min(axis=0) + points_m.max(axis=0)) / 2
    axes = principal_axes(points_m)
    up = axes[0] * (np.sign(axes[0][np.abs(axes[0]).argmax()]) or 1.0)
    half = margin * float(np.abs((points_m - centre) @ up).max())
    return [View(centre, towards, up, half) for towards in (axes[1], axes[2])]


def side_of_muscle(joint: JointDirections, muscle_m: np.ndarray, bones_m: np.ndarray) -> np.ndarray:
    """The eye that sees the muscle in front of the bones it lies on, its whole length, and much of the turn: from the
    bones near the muscle towards it, turned towards the axis."""
    middle, length = muscle_m.mean(axis=0), principal_axes(muscle_m)[0]
    reach = np.abs((muscle_m - middle) @ length).max()
    near = bones_m[np.linalg.norm(bones_m - middle, axis=1) < (1 + NEAR_SHARE) * reach]
    away = _across(middle - (near if len(near) else bones_m).mean(axis=0), length)
    if np.linalg.norm(away) < 1e-9:
        away = _across(joint.front, length)
    away = away / np.linalg.norm(away)
    side = joint.axis if away @ joint.axis >= 0 else -joint.axis
    eye = away + TILT * side
    return eye / np.linalg.norm(eye)


def overview(joint: JointDirections, eye: np.ndarray, shapes_m: list[np.ndarray]) -> View:
    """The whole of every shape (n, 3), one a muscle and moment; what few nodes of one lie far away do not make it small."""
    right, up = _picture_axes(eye, joint.up)
    focus, spans = joint.centre_m, []
    for direction in (right, up):
        along = np.append([percentile(shape_m @ direction, [0.5, 99.5]) for shape_m in shapes_m],
                          joint.centre_m @ direction)
        focus = focus + direction * ((along.max() + along.min()) / 2 - focus @ direction)
        spans.append(along.max() - along.min())
    return View(focus, eye, up, OVERVIEW_MARGIN * max(spans) / 2)


def close_up(joint: JointDirections, eye: np.ndarray, rest_m: np.ndarray) -> View:
    """The joint from the other side: that of the bones."""
    extent = np.ptp(rest_m @ principal_axes(rest_m)[0])
    return View(joint.centre_m, -eye, _picture_axes(-eye, joint.up)[1], CLOSE_UP_HALF_HEIGHT_SHARE * extent)


def cut_beside(joint: JointDirections, rest_m: np.ndarray, bones_m: np.ndarray) -> CutPlane:
    """Hides what of the bones lies beside the muscle along the axis, on the side that has more of them."""
    bones, muscle = bones_m @ joint.axis, rest_m @ joint.axis
    normal = joint.axis if muscle.min() - bones.min() >= bones.max() - muscle.max() else -joint.axis
    outermost = rest_m[(rest_m @ normal).argmin()]
    return CutPlane(outermost - CUT_MARGIN_M * normal, normal)


def level_eye(direction: np.ndarray, up: np.ndarray) -> np.ndarray | None:
    """The unit vector nearest to it from which `up` is up; None along `up`."""
    eye = _across(direction, up)
    length = np.linalg.norm(eye)
    return eye / length if length > 1e-3 * np.linalg.norm(direction) else None


def _across(vector: np.ndarray, axis: np.ndarray) -> np.ndarray:
    return vector - axis * (vector @ axis)


def _picture_axes(eye: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """To the right and upwards in a picture that is seen from `eye`."""
    right = np.cross(up, eye)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross(np.eye(3)[np.abs(eye).argmin()], eye)
    right = right / np.linalg.norm(right)
    return right, np.cross(eye, right)
