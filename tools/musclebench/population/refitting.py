"""Joint axes of a member, from the articular surfaces that its bones have. Lengths in metres."""

from dataclasses import dataclass

import numpy as np

from ..anatomy.joint_axis import Axis, articulating_points, fit_cylinder, fit_sphere
from ..anatomy.surface import Points, Surface, merged
from ..program.cli import Problem
from .base_scene import BaseScene, listed, motions_of
from .deformation import Deformation, jacobian

MM = 1000.0
FEWEST_POINTS = 50
NEAR_MM, NEAR_DEG = 5.0, 12.0  # of the scene's axis: a fit that is farther off is of something else
ROUND = 0.15  # of a radius: what is farther off a sphere or a cylinder (RMS) is neither
MOST_POINTS = 4000
CYLINDER_WORTH = 0.7


@dataclass
class Joint:
    """An axis about which bones turn, and the points of a bone whose shape tells it."""

    axis: Points  # of unit length
    centre: Points
    bones: list[str]
    shape: str = ""  # sphere or cylinder; empty: no articular surface explains the axis
    points: dict[str, Points] | None = None  # {bone: points}, of the articular surface at rest
    fitted: Axis | None = None  # to these, in millimetres

    @property
    def words(self) -> str:
        if self.fitted is None:
            return "carried along with the bones: no articular surface explains it"
        return f"refitted by a {self.shape} (radius {self.fitted.radius:.1f} mm, {self.fitted.rms:.2f} mm off, RMS)"


def joints_of(base: BaseScene) -> list[Joint]:
    """One for each axis that the scene has."""
    found: list[Joint] = []
    for bone in listed(base.tables, "bone"):
        for motion in motions_of(bone):
            axis, centre = np.array(motion["axis"], dtype=float), np.array(motion["centre_m"], dtype=float)
            axis = axis / np.linalg.norm(axis)
            same = next((one for one in found if np.allclose(one.axis, axis) and np.allclose(one.centre, centre)), None)
            if same is None:
                found.append(Joint(axis, centre, [bone["name"]]))
            elif bone["name"] not in same.bones:
                same.bones.append(bone["name"])
    for joint in found:
        _explain(joint, base)
    return found


def _explain(joint: Joint, base: BaseScene) -> None:
    still = [surface for name, surface in base.bones.items() if name not in joint.bones]
    if not still:
        return
    facing = _in_mm(merged(still))
    points = {name: articulating_points(_in_mm(base.bones[name]), facing) for name in joint.bones}
    points = {name: one[:: max(1, len(one) // MOST_POINTS)] for name, one in points.items() if len(one)}
    best = None
    # One bone articulates at the axis; what else comes near to the bones that stay does not count.
    for name, own in points.items():
        if len(own) < FEWEST_POINTS:
            continue
        for shape in ("sphere", "cylinder"):
            try:
                fitted = _fit(shape, own, joint.axis)
            except Problem:
                continue
            off_mm = float(np.linalg.norm(np.cross(joint.centre * MM - fitted.centre, fitted.direction)))
            off_deg = float(np.degrees(np.arccos(np.clip(abs(fitted.direction @ joint.axis), 0, 1))))
            if off_mm > NEAR_MM or off_deg > NEAR_DEG or fitted.rms is None or fitted.radius is None or fitted.rms > ROUND * fitted.radius:
                continue
            # A cylinder also tells the direction, which for a sphere is the scene's own; it may fit somewhat worse.
            worth = fitted.rms * (CYLINDER_WORTH if shape == "cylinder" else 1.0)
            if best is None or worth < best[0]:
                best = (worth, shape, name, own, fitted)
    if best is not None:
        _, joint.shape, name, own, joint.fitted = best
        joint.points = {name: own / MM}


def moved_axis(joint: Joint, deformation: Deformation, size: float) -> tuple[Points, Points]:
    """Direction and centre in a member. What the scene's axis is off the fit at rest stays as far off, carried along."""
    matrix = jacobian(deformation.of_space, joint.centre, size)  # of no bone: several may turn about it
    direction = matrix @ joint.axis
    direction /= np.linalg.norm(direction)
    carried_centre = deformation.of_space(joint.centre[None])[0]
    if joint.fitted is None or joint.points is None:
        return direction, carried_centre
    ((bone, points),) = joint.points.items()
    try:
        fitted = _fit(joint.shape, deformation.of_bone(bone, points) * MM, direction)
    except Problem:
        return direction, carried_centre
    before = joint.fitted
    # Along its own direction a cylinder's axis begins anywhere: the scene's centre is taken for its centre.
    offset = joint.centre - before.centre / MM
    centre: Points = fitted.centre / MM + matrix @ offset
    if joint.shape == "sphere":
        return direction, centre
    turned = _turn(before.direction, fitted.direction) @ joint.axis
    return turned / np.linalg.norm(turned), centre


def _turn(before: Points, after: Points) -> Points:
    """The smallest rotation (3, 3) of one direction into another, which is not opposite to it."""
    v, c = np.cross(before, after), float(before @ after)
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    found: Points = np.eye(3) + skew + skew @ skew / (1 + c)
    return found


def _fit(shape: str, points_mm: Points, towards: Points) -> Axis:
    return (fit_cylinder if shape == "cylinder" else fit_sphere)(points_mm, towards)


def _in_mm(surface: Surface) -> Surface:
    return Surface(surface.vertices * MM, surface.triangles)
