"""Attachment points: which landmark cloud belongs to which muscle end, and a rule for the muscle without one."""

import numpy as np

from .closest_point import closest_on_mesh

PELVIS_RIGHT = {"bone": "pelvis", "part": "hip_bone_r"}
SACRUM = {"bone": "pelvis", "part": "sacrum"}
FEMUR = {"bone": "femur_r"}
TIBIA = {"bone": None, "site": "right tibia (iliotibial tract); bone not in this dataset"}
SPINE = {"bone": None, "site": "lumbar spine; bone not in this dataset"}

DIGITISED = [
    ("gluteus_maximus_r", "origin", "LC_SET_Ori_1_R_M081_Glut_Max", PELVIS_RIGHT),
    ("gluteus_maximus_r", "origin", "LC_SET_Ori_2_R_M081_Glut_Max", SACRUM),
    ("gluteus_maximus_r", "insertion", "LC_SET_Ins_1_R_M081_Glut_Max", FEMUR),
    ("gluteus_maximus_r", "insertion", "LC_SET_Ins_2_R_M081_Glut_Max", TIBIA),
    ("gluteus_medius_r", "origin", "LC_SET_Ori_1_R_M082_Glut_Med", PELVIS_RIGHT),
    ("gluteus_medius_r", "insertion", "LC_SET_Ins_1_R_M082_Glut_Med", FEMUR),
    ("iliacus_r", "origin", "LC_SET_Ori_1_R_M091_Iliacus", PELVIS_RIGHT),
    ("iliacus_r", "insertion", "LC_SET_Ins_1_R_M091_Iliacus", FEMUR),
    ("psoas_r", "origin", "LC_SET_Ori_1_R_M090_Psoas_maj", SPINE),
    ("psoas_r", "origin", "LC_SET_Ori_2_R_M090_Psoas_maj", SPINE),
    ("psoas_r", "origin", "LC_SET_Ori_3_R_M090_Psoas_maj", SPINE),
    ("psoas_r", "origin", "LC_SET_Ori_4_R_M090_Psoas_maj", SPINE),
    ("psoas_r", "insertion", "LC_SET_Ins_1_R_M090_Psoas_maj", FEMUR),
]

CONTACT_DISTANCE_M = 3e-3
CONTACT_POINTS = 20


def digitised_attachments(clouds: dict) -> list[dict]:
    entries = []
    for muscle, role, cloud, bone_part in DIGITISED:
        points = list(clouds[cloud].values())
        entries.append({
            "muscle": muscle, "role": role, "bone": bone_part["bone"], "upstream_name": cloud,
            "provenance": "digitised, from the .nms landmark cloud, in numeric landmark order",
            "count": len(points), "points_m": points, **bone_part,
        })
    return entries


def contact_attachment(muscle: str, role: str, bone_part: dict, muscle_vertices_m, bone_vertices_m,
                       bone_triangles) -> dict:
    """Points of the bone's surface closest to the muscle vertices within 3 mm, thinned to 20 that are far apart."""
    gaps, closest = closest_on_mesh(muscle_vertices_m, bone_vertices_m, bone_triangles, CONTACT_DISTANCE_M)
    near = closest[np.isfinite(gaps)]
    points = near[_farthest_points(near, CONTACT_POINTS)]
    return {
        "muscle": muscle, "role": role, "bone": bone_part["bone"], "upstream_name": None,
        "provenance": "derived here, no upstream landmark cloud exists: bone-surface points closest to the muscle "
        "vertices lying within 3 mm of the bone, thinned to 20 by farthest-point sampling",
        "count": len(points), "points_m": np.round(points, 9).tolist(),
        "muscle_vertices_within_3mm": len(near), **bone_part,
    }


def _farthest_points(points: np.ndarray, count: int) -> list[int]:
    """Greedy sampling that starts with the point farthest from the centroid."""
    chosen = [int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())]
    gap = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return chosen
