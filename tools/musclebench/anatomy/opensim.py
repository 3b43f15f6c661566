"""The axis of a joint in an OpenSim model, of versions 3 and 4."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..lhdl.hip_joint import axes_from_body_fixed_xyz
from ..program.cli import Problem
from .surface import Points

PIN_AXIS = (0.0, 0.0, 1.0)  # of a PinJoint, in its own frame


def opensim_axis(path: Path, coordinate: str) -> tuple[Points, Points]:
    """(direction, centre in metres) in the frame of the joint's parent body, of the rotation that a coordinate stands for. Raises
    Problem."""
    try:
        # Models say nothing of their encoding, or are not in the one that they name.
        root = ElementTree.fromstring(path.read_bytes().decode("latin-1"))
    except (OSError, ElementTree.ParseError) as error:
        raise Problem(f"{path}: is no OpenSim model ({error})") from None
    joints = {one.get("name"): joint for joint in root.iter() if joint.tag.endswith("Joint") for one in joint.iter("Coordinate")}
    joint = joints.get(coordinate)
    if joint is None:
        raise Problem(f"{path}: has no coordinate '{coordinate}'; there are {', '.join(sorted(name for name in joints if name)) or 'none'}")
    centre, angles = _parent_frame(joint)
    axis = np.array(PIN_AXIS) if joint.tag == "PinJoint" else _rotation_axis(joint, coordinate)
    if axis is None:
        raise Problem(f"{path}: coordinate '{coordinate}' turns about no axis of its own; give axis and centre")
    if not np.linalg.norm(axis) > 0:
        raise Problem(f"{path}: the axis of coordinate '{coordinate}' has no length; give axis and centre")
    direction: Points = axes_from_body_fixed_xyz(angles) @ axis
    return direction / np.linalg.norm(direction), centre


def _parent_frame(joint: ElementTree.Element) -> tuple[Points, Points]:
    """Where the joint is in its parent, and the angles of its axes there: body-fixed rotations about X, then Y, then Z."""
    if joint.find("location_in_parent") is not None:
        return _vector(joint, "location_in_parent"), _vector(joint, "orientation_in_parent")
    name = (joint.findtext("socket_parent_frame") or "").strip()
    frame = next((one for one in joint.iter("PhysicalOffsetFrame") if one.get("name") == name), joint)
    return _vector(frame, "translation"), _vector(frame, "orientation")


def _rotation_axis(joint: ElementTree.Element, coordinate: str) -> Points | None:
    for axis in joint.iter("TransformAxis"):
        if (axis.get("name") or "").startswith("rotation") and (axis.findtext("coordinates") or "").split() == [coordinate]:
            return _vector(axis, "axis")
    return None


def _vector(element: ElementTree.Element, tag: str) -> Points:
    text = element.findtext(tag) or "0 0 0"
    try:
        found: Points = np.array([float(word) for word in text.split()]).reshape(3)
    except ValueError:
        raise Problem(f"an OpenSim model has {tag} '{text}', which is no vector of three numbers") from None
    return found
