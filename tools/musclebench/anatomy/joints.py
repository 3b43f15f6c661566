"""Joints: which bones turn about which axis, and how deep bones come into each other then."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..program.cli import Problem
from .anatomy_map import UNITS, JointWords
from .joint_axis import Axis, articulating_points, fit_cylinder, fit_sphere
from .opensim import opensim_axis
from .surface import Points, Surface

FEWEST_POINTS = 20  # that a shape is fitted to
ANGLES = 9  # at which a joint is looked at
MOST_DEEPER_MM = 5.0  # that bones may come into each other: joints of published legs stay below it


@dataclass
class Joint:
    """In millimetres."""

    name: str
    moves: list[str]
    axis: Axis
    from_deg: float
    to_deg: float
    deepest: dict[str, float] = field(default_factory=dict)  # {two bones: how much deeper than at rest they are in each other at most}
    carried: str = ""  # why its axis is that of the map's reference

    @property
    def problems(self) -> list[str]:
        """Bones that come so deep into each other that the axis can't be theirs."""
        cure = "this body lies otherwise than the reference" if self.carried else "look at the meshes that it was fitted to"
        return [f"joint {self.name}: {pair} by {depth:.1f} mm more than at rest: the axis or the range is wrong; {cure}"
                for pair, depth in self.deepest.items() if depth > MOST_DEEPER_MM]

    def places(self, points: Points, count: int) -> list[Points]:
        """Of points of a moved bone, at angles over the range."""
        return [turned(points, self.axis, angle) for angle in np.linspace(self.from_deg, self.to_deg, count)]


def made_joint(words: JointWords, solids: dict[str, Surface], bones: dict[str, Surface], unit: str) -> Joint:
    """`solids`: bones and cartilage. The axis of the map's reference is taken where this body has no surface to fit one to, and where
    bones come more than MOST_DEEPER_MM into each other about its own axis and not about that. Raises Problem."""
    try:
        own = _looked_at(words, _axis(words, solids, unit), bones)
        pairs = ", ".join(f"{pair} by {depth:.1f} mm" for pair, depth in own.deepest.items())
        reason = f"about the axis of its own surfaces bones come deep into each other, {pairs}" if own.problems else ""
    except Problem as problem:
        if words.otherwise is None:
            raise
        own, reason = None, str(problem).removeprefix(f"joint {words.name}: ")
    if words.otherwise is None or not reason:
        assert own is not None
        return own
    other = _looked_at(words, words.otherwise, bones)
    if own is not None and other.problems:
        return own
    other.carried = reason
    return other


def _looked_at(words: JointWords, axis: Axis, bones: dict[str, Surface]) -> Joint:
    joint = Joint(words.name, words.moves, axis, words.from_deg, words.to_deg)
    fields = {name: bone.distance for name, bone in bones.items() if name not in joint.moves}
    for name in (one for one in joint.moves if one in bones):
        for other, distance in fields.items():
            depths = [float(np.maximum(-distance.within(place, 1.0), 0).max()) for place in (bones[name].vertices, *joint.places(bones[name].vertices, ANGLES))]
            if max(depths) > depths[0]:
                joint.deepest[f"{name} in {other}"] = max(depths) - depths[0]
    return joint


def turned(points: Points, axis: Axis, angle_deg: float) -> Points:
    """About the axis, right-handed."""
    relative, k, angle = points - axis.centre, axis.direction, np.radians(angle_deg)
    moved: Points = relative * np.cos(angle) + np.cross(k, relative) * np.sin(angle) + np.outer(relative @ k, k) * (1 - np.cos(angle))
    return moved + axis.centre


def _axis(words: JointWords, solids: dict[str, Surface], unit: str) -> Axis:
    if words.opensim:
        direction, centre_m = opensim_axis(Path(words.opensim), words.coordinate)
        return Axis(direction, centre_m * UNITS["m"])
    if words.axis is not None and words.centre is not None:
        return Axis(words.axis / np.linalg.norm(words.axis), words.centre * UNITS[unit])
    return fitted_axis(words, solids)


def fitted_axis(words: JointWords, solids: dict[str, Surface]) -> Axis:
    """Raises Problem."""
    if missing := [name for name in (words.surface, words.facing) if name and name not in solids]:
        raise Problem(f"joint {words.name}: there is no {missing[0]} to fit its axis to")
    points = articulating_points(solids[words.surface], solids[words.facing] if words.facing else None)
    if len(points) < FEWEST_POINTS:
        raise Problem(f"joint {words.name}: {words.surface} faces {words.facing} nowhere within reach; name another surface, or give axis and centre")
    assert words.axis_towards is not None
    return (fit_cylinder if words.fit == "cylinder" else fit_sphere)(points, words.axis_towards)
