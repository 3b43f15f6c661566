"""The right hip of the OpenSim model: centre, axes, and the joint angles of the pose in which the meshes are stored."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

from .upstream import ImportProblem


def axes_from_body_fixed_xyz(angles_rad: np.ndarray) -> np.ndarray:
    """Columns are the joint's x, y, z axes; OpenSim orientations are body-fixed rotations about X, then Y, then Z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles_rad), np.sin(angles_rad)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_x @ about_y @ about_z


def read_hip_joint(path: Path) -> dict:
    # The file says nothing of its encoding and is not UTF-8, which the XML parser would assume.
    text = path.read_bytes().decode("latin-1")
    joint = ElementTree.fromstring(text).find(".//CustomJoint[@name='hip_r']")
    if joint is None:
        raise ImportProblem(f"{path}: has no CustomJoint named hip_r; fetch the file again")
    parent = axes_from_body_fixed_xyz(_vector(joint, "orientation_in_parent"))
    child = axes_from_body_fixed_xyz(_vector(joint, "orientation"))
    return {
        "description": "Ball-and-socket joint of the OpenSim model LHDL_hip_r.osim, in the frame of the meshes.",
        "centre_m": _vector(joint, "location_in_parent").tolist(),
        "centre_m_child": _vector(joint, "location").tolist(),
        "centre_note": "centre_m is the place in the pelvis, centre_m_child the place in the femur.",
        "axes": {
            "flexion": _rounded(parent[:, 2]),
            "adduction": _rounded(parent[:, 0]),
            "rotation": _rounded(parent[:, 1]),
            "note": "Unit vectors fixed in the pelvis; a positive angle is a right-handed turn about the vector: "
            "flexion, adduction, internal rotation of the right hip.",
        },
        "parent_axes_columns_xyz": [_rounded(row) for row in parent],
        "child_axes_columns_xyz": [_rounded(row) for row in child],
        "scan_pose_coordinates_deg": _scan_pose_deg(parent, child),
        "transforms": {
            "relative_to_scan": "p = c + Rot(flexion_axis, angle) (x - c); angle 0 is the mesh as published.",
            "opensim": "p = centre_m + A Rz(flexion) Rx(adduction) Ry(rotation) B^T (x - centre_m_child) with "
            "A = parent_axes_columns_xyz and B = child_axes_columns_xyz; all angles zero is not the mesh as published.",
        },
    }


def _scan_pose_deg(parent: np.ndarray, child: np.ndarray) -> dict:
    """Angles at which Rz(flexion) Rx(adduction) Ry(rotation) = A^T B, so that the femur stays where it was scanned."""
    turn = parent.T @ child
    adduction = np.arcsin(turn[2, 1])
    flexion = np.arctan2(-turn[0, 1], turn[1, 1])
    rotation = np.arctan2(-turn[2, 0], turn[2, 2])
    names = ("hip_flexion_r", "hip_adduction_r", "hip_rotation_r")
    return {name: round(float(np.degrees(a)), 6) for name, a in zip(names, (flexion, adduction, rotation))}


def _vector(joint, tag: str) -> np.ndarray:
    return np.array([float(word) for word in joint.find(tag).text.split()])


def _rounded(values) -> list[float]:
    return [round(float(v), 12) for v in values]
