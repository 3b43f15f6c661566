"""Maps of space that make one anatomy into another. Lengths in metres."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import RBFInterpolator

from ..anatomy.surface import Points, Surface

Map = Callable[[Points], Points]  # of points (n, 3)

SAMPLES = 1600  # of all bones, through which a muscle is carried along
STEP = 1e-5  # of a difference quotient, over the diagonal of what is mapped


@dataclass(frozen=True)
class Frame:
    """Of what a shape acts on."""

    centre: Points  # stays where it is
    along: Points  # its longest direction, of unit length
    length: float  # in that direction
    diagonal: float

    @property
    def across(self) -> tuple[Points, Points]:
        """Two directions at right angles to it."""
        helper = np.eye(3)[int(np.abs(self.along).argmin())]
        first = np.cross(self.along, helper)
        first /= np.linalg.norm(first)
        return first, np.cross(self.along, first)


def frame_of(surfaces: list[Surface], centre: Points | None = None) -> Frame:
    """`centre`: what stays in place (default: the middle of the box)."""
    points = np.concatenate([one.vertices[np.unique(one.triangles)] for one in surfaces])  # a file may have stray vertices
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    along = np.linalg.svd(points[:: max(1, len(points) // 20_000)] - points.mean(axis=0), full_matrices=False)[2][0]
    along *= np.sign(along[int(np.abs(along).argmax())])
    return Frame(middle if centre is None else centre, along, float(np.ptp(points @ along)), float(np.linalg.norm(np.ptp(points, axis=0))))


def scaled(factors: list[float], frame: Frame) -> Map:
    """Along the scene's axes; one factor is for all."""
    def apply(points: Points) -> Points:
        moved: Points = (points - frame.centre) * np.array(factors) + frame.centre
        return moved
    return apply


def twisted(angle_deg: float, frame: Frame) -> Map:
    """About the long axis, by so much from one end to the other."""
    first, second = frame.across

    def apply(points: Points) -> Points:
        relative = points - frame.centre
        s, u, v = relative @ frame.along, relative @ first, relative @ second
        angle = np.radians(angle_deg) * s / frame.length
        cos, sin = np.cos(angle), np.sin(angle)
        moved: Points = np.outer(s, frame.along) + np.outer(u * cos - v * sin, first) + np.outer(u * sin + v * cos, second) + frame.centre
        return moved
    return apply


def bent(angle_deg: float, towards_deg: float, frame: Frame) -> Map:
    """The long axis becomes an arc of a circle, of so many degrees from one end to the other."""
    first, second = frame.across
    towards = np.cos(np.radians(towards_deg)) * first + np.sin(np.radians(towards_deg)) * second
    aside = np.cross(frame.along, towards)
    curvature = np.radians(angle_deg) / frame.length

    def apply(points: Points) -> Points:
        relative = points - frame.centre
        s, h, w = relative @ frame.along, relative @ towards, relative @ aside
        angle = curvature * s
        # np.sinc(x) is sin(pi x) / (pi x): nothing is divided by a curvature that may vanish.
        along = s * np.sinc(angle / np.pi) - h * np.sin(angle)
        up = h * np.cos(angle) + s * np.sin(angle / 2) * np.sinc(angle / 2 / np.pi)
        moved: Points = np.outer(along, frame.along) + np.outer(up, towards) + np.outer(w, aside) + frame.centre
        return moved
    return apply


def carried(samples: Points, displacements: Points) -> Map:
    """A smooth map that moves the samples by their displacements, and an affine one exactly. Source: biharmonic splines, whose
    kernel in space is the distance (Sandwell 1987, Geophys. Res. Lett. 14, 139)."""
    if not len(samples) or not np.abs(displacements).any():
        return lambda points: points.copy()
    middle, size = samples.mean(axis=0), float(np.linalg.norm(np.ptp(samples, axis=0)))
    spline = RBFInterpolator((samples - middle) / size, displacements / size, kernel="linear", degree=1)

    def apply(points: Points) -> Points:
        moved: Points = points + size * spline((points - middle) / size)
        return moved
    return apply


def samples_of(surface: Surface, count: int) -> Points:
    """Vertices of it, evenly over its list; the same each time."""
    picked = np.unique(np.linspace(0, len(surface.vertices) - 1, min(count, len(surface.vertices))).astype(int))
    points: Points = surface.vertices[picked]
    return points


@dataclass
class Deformation:
    """Of a whole anatomy. Bones change each for itself first, and muscles are carried along; then everything changes together."""

    whole: list[Map] = field(default_factory=list)
    own: dict[str, list[Map]] = field(default_factory=dict)  # of bones
    carry: Map = lambda points: points

    @property
    def is_none(self) -> bool:
        return not self.whole and not self.own

    def of_bone(self, name: str, points: Points) -> Points:
        for one in self.own.get(name, []):
            points = one(points)
        return self._together(points)

    def of_space(self, points: Points) -> Points:
        """Muscles, and what belongs to no bone."""
        return self._together(self.carry(points))

    def _together(self, points: Points) -> Points:
        for one in self.whole:
            points = one(points)
        return points


def with_carry(deformation: Deformation, bones: dict[str, Surface]) -> Deformation:
    """Muscles follow the bones."""
    if not deformation.own:
        return deformation
    each = max(50, SAMPLES // len(bones))
    before = {name: samples_of(bone, each) for name, bone in bones.items()}
    moved = []
    for name, points in before.items():
        after = points
        for one in deformation.own.get(name, []):
            after = one(after)
        moved.append(after - points)
    samples, displacements = np.concatenate(list(before.values())), np.concatenate(moved)
    _, first = np.unique(samples, axis=0, return_index=True)  # bones may share a vertex, which would make the spline singular
    deformation.carry = carried(samples[first], displacements[first])
    return deformation


def jacobian(apply: Map, point: Points, size: float) -> Points:
    """(3, 3) of a map at a point (3,), by central differences. `size`: length over which the map changes."""
    step = STEP * size
    ends = apply(np.concatenate([point + step * np.eye(3), point - step * np.eye(3)]))
    found: Points = (ends[:3] - ends[3:]).T / (2 * step)
    return found


def stretches(matrix: Points) -> tuple[float, float]:
    """The smallest and the largest of a Jacobian."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[-1]), float(values[0])
