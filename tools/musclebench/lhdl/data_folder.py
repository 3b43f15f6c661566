"""Everything that the data folder holds, computed from the upstream files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import attachments, upstream
from .decimate import decimate
from .hip_joint import read_hip_joint
from .landmarks import THIGH_CLOUD, read_landmark_clouds
from .legacy_vtk import read_legacy_vtk
from .mesh_quality import mesh_quality
from .motions import read_motion

LICENCE = "CC BY-NC-SA 2.0 BE"
NOTICE = (
    "Geometry, landmarks and files derived from them: (c) Istituto Ortopedico Rizzoli and Universite Libre de "
    "Bruxelles, LHDL consortium (Living Human Digital Library), under Creative Commons "
    "Attribution-NonCommercial-ShareAlike 2.0 Belgium. Not for commercial use; derived files carry the same licence."
)
CITATIONS = [
    "Viceconti M, Clapworthy G, Van Sint Jan S (2008). The Virtual Physiological Human - a European initiative for in "
    "silico human modelling. Journal of Physiological Sciences 58:441-446.",
    "Modenese L, Kohout J (2020). Automated generation of three-dimensional complex muscle geometries for use in "
    "personalised musculoskeletal models. Annals of Biomedical Engineering. doi:10.1007/s10439-020-02490-4",
    "Cervenka M, Kohout J (2020). Fast and realistic approach to virtual muscle deformation. SciTePress.",
]

PELVIS_PARTS = [
    ("sacrum", upstream.SACRUM),
    ("hip_bone_l", upstream.HIP_BONE_LEFT),
    ("hip_bone_r", upstream.HIP_BONE_RIGHT),
]
MUSCLES = [  # name, upstream file, vertex count in the paper
    ("adductor_brevis_r", upstream.ADDUCTOR_BREVIS, 502),
    ("gluteus_maximus_r", upstream.GLUTEUS_MAXIMUS, 9878),
    ("gluteus_medius_r", upstream.GLUTEUS_MEDIUS, 5313),
    ("iliacus_r", upstream.ILIACUS, 6931),
    ("psoas_r", upstream.PSOAS, None),
]
DECIMATED_TRIANGLES = 1000  # closed and of genus 0, so 502 vertices


@dataclass
class Surface:
    vertices_m: np.ndarray
    triangles: np.ndarray
    entry: dict


def load_surfaces(upstream_dir: Path, say=lambda text: None) -> dict[str, Surface]:
    """{name: Surface} of the seven published surfaces and the decimated adductor brevis."""
    surfaces = {"pelvis": _pelvis(upstream_dir)}
    surfaces["femur_r"] = _published(upstream_dir, "femur_r", upstream.FEMUR, "bone", body="femur_r")
    for name, file_name, in_paper in MUSCLES:
        say(f"reading {name}")
        extra = {"vertices_in_paper": in_paper} if in_paper else {}
        surfaces[name] = _published(upstream_dir, name, file_name, "muscle", **extra)
    surfaces["adductor_brevis_r_502"] = _decimated(surfaces["adductor_brevis_r"])
    return surfaces


def describe(upstream_dir: Path, surfaces: dict[str, Surface], say=lambda text: None) -> dict:
    """The content of lhdl.json."""
    say("reading landmarks, joint and motions")
    clouds = read_landmark_clouds(upstream_dir / upstream.LANDMARKS)
    return {
        "name": "lhdl",
        "title": "LHDL right hip: pelvis, femur and hip muscles of one cadaveric specimen",
        "units": {"length": "metre", "angle": "degree", "upstream_length": "millimetre"},
        "frame": {
            "description": "Computed-tomography scanner frame, shared by every file; only divided by 1000.",
            "x": "towards the left of the subject", "y": "posterior", "z": "superior", "handedness": "right",
        },
        "licence": LICENCE,
        "notice": NOTICE,
        "changes": "Converted from legacy VTK to PLY, millimetre to metre; the three pelvic surfaces concatenated; "
        "adductor_brevis_r_502 decimated; nothing else cleaned, merged or resampled.",
        "citations": CITATIONS,
        "sources": upstream.SOURCES,
        "meshes": [surface.entry for surface in surfaces.values()],
        "hip_joint": read_hip_joint(upstream_dir / upstream.OPENSIM_MODEL),
        "attachments": attachments.digitised_attachments(clouds) + _adductor_attachments(surfaces),
        "landmarks_m": clouds[THIGH_CLOUD],
        "fibres": [_fibres(upstream_dir)],
        "motions": {
            name: read_motion(upstream_dir / file_name, f"upstream/{file_name}")
            for name, file_name in upstream.MOTIONS.items()
        },
    }


def _read_metres(path: Path):
    data = read_legacy_vtk(path)
    return data.points.astype(np.float64) / 1000.0, data.cells


def _surface(name: str, vertices_m, triangles, kind: str, files: list[str], extra: dict) -> Surface:
    corners = vertices_m.min(axis=0), vertices_m.max(axis=0)
    entry = {
        "name": name, "file": f"meshes/{name}.ply", "kind": kind, "set": "primary",
        "vertices": len(vertices_m), "triangles": len(triangles),
        "bbox_m": [np.round(corner, 6).tolist() for corner in corners],
        "upstream_files": [f"upstream/{f}" for f in files],
        "quality": mesh_quality(vertices_m, triangles), **extra,
    }
    return Surface(vertices_m, triangles, entry)


def _published(upstream_dir: Path, name: str, file_name: str, kind: str, **extra) -> Surface:
    vertices_m, triangles = _read_metres(upstream_dir / file_name)
    return _surface(name, vertices_m, triangles, kind, [file_name], extra)


def _pelvis(upstream_dir: Path) -> Surface:
    all_vertices, all_triangles, parts = [], [], []
    first_vertex = first_triangle = 0
    for name, file_name in PELVIS_PARTS:
        vertices_m, triangles = _read_metres(upstream_dir / file_name)
        parts.append({
            "name": name, "upstream_file": f"upstream/{file_name}",
            "first_vertex": first_vertex, "vertices": len(vertices_m),
            "first_triangle": first_triangle, "triangles": len(triangles),
            "quality": mesh_quality(vertices_m, triangles),
        })
        all_vertices.append(vertices_m)
        all_triangles.append(triangles + first_vertex)
        first_vertex += len(vertices_m)
        first_triangle += len(triangles)
    files = [file_name for _, file_name in PELVIS_PARTS]
    extra = {"body": "pelvis", "parts": parts}
    return _surface("pelvis", np.concatenate(all_vertices), np.concatenate(all_triangles), "bone", files, extra)


def _decimated(adductor: Surface) -> Surface:
    vertices_m, triangles = decimate(adductor.vertices_m, adductor.triangles, DECIMATED_TRIANGLES)
    if len(vertices_m) != 502 or len(triangles) != DECIMATED_TRIANGLES:
        raise upstream.ImportProblem(
            f"adductor_brevis_r_502: VTK's decimation gave {len(vertices_m)} vertices where 502 are expected; "
            "VTK 9.1 of Debian 12 is known to work"
        )
    extra = {
        "set": "resampled", "vertices_in_paper": 502,
        "derived_from": "meshes/adductor_brevis_r.ply by quadric edge-collapse decimation to 1000 triangles",
    }
    surface = _surface("adductor_brevis_r_502", vertices_m, triangles, "muscle", [], extra)
    del surface.entry["upstream_files"]
    return surface


def _adductor_attachments(surfaces: dict[str, Surface]) -> list[dict]:
    muscle, pelvis, femur = (surfaces[name] for name in ("adductor_brevis_r", "pelvis", "femur_r"))
    right = next(part for part in pelvis.entry["parts"] if part["name"] == "hip_bone_r")
    first = right["first_triangle"]
    right_triangles = pelvis.triangles[first : first + right["triangles"]]
    areas = [
        ("origin", attachments.PELVIS_RIGHT, pelvis.vertices_m, right_triangles),
        ("insertion", attachments.FEMUR, femur.vertices_m, femur.triangles),
    ]
    return [
        attachments.contact_attachment("adductor_brevis_r", role, bone_part, muscle.vertices_m, vertices, triangles)
        for role, bone_part, vertices, triangles in areas
    ]


def _fibres(upstream_dir: Path) -> dict:
    """Upstream cuts each polyline into segments; a segment that starts where the last one ended carries it on."""
    points_m, segments = _read_metres(upstream_dir / upstream.FIBRES)
    lines: list[list[int]] = []
    for start, end in segments.tolist():
        if lines and lines[-1][-1] == start:
            lines[-1].append(end)
        else:
            lines.append([start, end])
    polylines = [np.round(points_m[line], 7).tolist() for line in lines]
    return {"muscle": "gluteus_maximus_r", "file": f"upstream/{upstream.FIBRES}", "polylines_m": polylines}
