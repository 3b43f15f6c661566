"""Where to look from: directions of the body, found from the axis of flexion, and cameras for each muscle."""

from dataclasses import dataclass

import numpy as np

from .rendering import CutPlane, View

OVERVIEW_MARGIN = 1.15
CLOSE_UP_HALF_HEIGHT_SHARE = 0.32  # of the muscle's rest extent along the thigh
CUT_MARGIN_M = 0.02

# Eye directions as (anterior, lateral, superior): each shows the whole muscle and where it crosses the joint.
OVERVIEW_FROM = {
    "adductor_brevis": (1.0, -0.35, 0.0),
    "gluteus_maximus": (-1.0, 0.7, 0.1),
    "gluteus_medius": (-0.35, 1.0, 0.15),
    "iliacus": (1.0, -0.8, 0.0),
}
# The side of the bones, for pictures with see-through bones.
CONTACT_SIDE_FROM = {
    "adductor_brevis": (-0.6, 1.0, 0.0),
    "gluteus_maximus": (1.0, -0.3, 0.0),
    "gluteus_medius": (0.5, -1.0, 0.0),
    "iliacus": (-1.0, 1.2, 0.2),
}


@dataclass
class BodyDirections:
    """Of a right leg: unit vectors and the centre of the hip joint, in the frame of the rest pose."""

    hip_centre_m: np.ndarray
    anterior: np.ndarray
    lateral: np.ndarray
    superior: np.ndarray

    def combine(self, anterior: float, lateral: float, superior: float) -> np.ndarray:
        vector = anterior * self.anterior + lateral * self.lateral + superior * self.superior
        return vector / np.linalg.norm(vector)


def body_directions(flexion_axis: np.ndarray, hip_centre_m: np.ndarray, femur_m: np.ndarray) -> BodyDirections:
    """The axis about which flexion turns right-handed points to the side; the femur at rest points down."""
    axis = flexion_axis / np.linalg.norm(flexion_axis)
    down = femur_m.mean(axis=0) - hip_centre_m
    down -= axis * (down @ axis)
    down /= np.linalg.norm(down)
    return BodyDirections(hip_centre_m, np.cross(axis, down), axis, -down)


def overview(body: BodyDirections, muscle: str, shapes_m: np.ndarray) -> View:
    """The whole muscle in all the given shapes (n, 3); what few nodes lie far away do not make it small."""
    eye = body.combine(*OVERVIEW_FROM.get(muscle, (1.0, -0.5, 0.0)))
    right = np.cross(body.superior, eye)
    right /= np.linalg.norm(right)
    up = np.cross(eye, right)
    focus, spans = body.hip_centre_m, []
    for direction in (right, up):
        along = np.append(np.percentile(shapes_m @ direction, [0.5, 99.5]), body.hip_centre_m @ direction)
        focus = focus + direction * ((along.max() + along.min()) / 2 - focus @ direction)
        spans.append(along.max() - along.min())
    return View(focus, eye, up, OVERVIEW_MARGIN * max(spans) / 2)


def close_up(body: BodyDirections, muscle: str, rest_m: np.ndarray) -> View:
    """The hip joint from the side of the bones."""
    eye = body.combine(*CONTACT_SIDE_FROM.get(muscle, (-1.0, 1.0, 0.0)))
    extent = np.ptp(rest_m @ body.superior)
    focus = body.hip_centre_m + 0.01 * body.anterior
    return View(focus, eye, body.superior, CLOSE_UP_HALF_HEIGHT_SHARE * extent)


def cut_beside(body: BodyDirections, rest_m: np.ndarray) -> CutPlane:
    """Hides what of the bones lies further to the other side of the body than the muscle."""
    most_medial = rest_m[(rest_m @ body.lateral).argmin()]
    return CutPlane(most_medial - CUT_MARGIN_M * body.lateral, body.lateral)
