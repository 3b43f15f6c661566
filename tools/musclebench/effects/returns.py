"""Whether a muscle comes back: the scene's motion with the effects that it calls for, and a rest after it."""

from pathlib import Path

import numpy as np
import pandas as pd

from ..experiments.swept_case import SweptCase
from ..results.ply import PlyMesh, read_ply
from ..results.run_folder import Run, read_all
from ..tables.table_formats import Column, Table
from .effect_runs import NAN, rms_mm

MOST_NODES = 400  # of the attached ones, between which lengths are measured

RETURN_COLUMNS = [
    Column("muscle", "muscle"), Column("status", "status"), Column("added", "effects added"),
    Column("rms_mm", "RMS to rest mm", 3, "RMS\nmm"), Column("largest_mm", "largest distance to rest mm", 2, "largest\nmm"),
    Column("surface_depth_mm", "largest depth of the surface mm", 3, "surface\nmm"),
    Column("surface_depth_p99_mm", "p99 of it over the frames mm", 3, "surface\np99 mm"),
    Column("tunnelled", "tunnelled nodes", 0, "tun-\nnelled"), Column("volume_percent", "largest volume error %", 3, "volume\n%"),
    Column("folded_percent", "triangles through others at full flexion %", 3, "folded\n%"),
    Column("folded_at_end", "at the end", 0, "at\nend"),
    Column("stretch", "edge stretch, p99", 3, "edge\nstretch"),
    Column("own_stretch", "most stretched line between attached nodes", 3, "own\nstretch"),
    Column("fibre_stretch", "most stretched fibre", 3, "fibre\nstretch"),
]
CAPTION = (
    "Whether a muscle comes back: the scene's motion with `effects = \"auto\"` and half a second of rest after it. Distances "
    "of the nodes at the end from where they were at rest; depths, volume error and stretch are the largest of the run. Own "
    "stretch: of all lines between two attached nodes the one that is stretched most at full flexion; fibre stretch: of "
    "100 fibres through the muscle, from its origin to its insertion."
)


def return_table(folders: dict[SweptCase, Path]) -> Table:
    """`folders`: of the complete cases."""
    rows = [_row(case, run) for case, run in zip(folders, read_all(list(folders.values())))]
    keys = [column.key for column in RETURN_COLUMNS]
    return Table("returns", CAPTION, RETURN_COLUMNS, pd.DataFrame(rows, columns=keys), [key for key in keys if key != "muscle"])


def _row(case: SweptCase, run: Run) -> dict:
    shapes = {shot["frame"]: read_ply(run.folder / shot["file"]) for shot in run.record.get("snapshots") or []}
    rest, full = shapes.get(0), shapes.get(case.scene.full_flexion_frame)
    end = shapes.get(case.scene.frames + case.rest_frames)
    folded = {} if run.frames.empty else run.frames.set_index("frame")["self_intersecting_triangles"]
    added = [one["effect"] for one in run.record.get("added_effects") or []]
    return {
        "muscle": run.muscle, "status": run.status, "added": ", ".join(added) or "none",
        "rms_mm": rms_mm(end.vertices_m, rest.vertices_m) if end and rest else NAN,
        "largest_mm": _largest_mm(end, rest) if end and rest else NAN,
        "surface_depth_mm": 1e3 * _outcome(run, "max_surface_depth_m"),
        "surface_depth_p99_mm": 1e3 * _outcome(run, "p99_surface_depth_m"),
        "tunnelled": _outcome(run, "tunnelled_nodes"), "volume_percent": 100 * _outcome(run, "max_volume_error"),
        "folded_percent": 100 * folded.get(case.scene.full_flexion_frame, NAN) / len(full.triangles) if full else NAN,
        "folded_at_end": folded.get(case.scene.frames + case.rest_frames, NAN),
        "stretch": _outcome(run, "p99_edge_stretch"),
        "own_stretch": own_stretch(rest, full) if rest and full else NAN,
        "fibre_stretch": NAN if run.fibres.empty else float(run.fibres["max_stretch"].max()),
    }


def _outcome(run: Run, key: str) -> float:
    value = (run.record.get("outcome") or {}).get(key)
    return NAN if value is None else float(value)


def _largest_mm(shape: PlyMesh, rest: PlyMesh) -> float:
    return float(1e3 * np.linalg.norm(shape.vertices_m - rest.vertices_m, axis=1).max())


def own_stretch(rest: PlyMesh, full: PlyMesh) -> float:
    """1 where no two attached nodes move apart; NaN where fewer than two are attached."""
    attached = np.flatnonzero(rest.extra.get("attached", np.zeros(0)))
    nodes = attached[::len(attached) // MOST_NODES + 1]
    if len(nodes) < 2:
        return NAN
    upper = np.triu_indices(len(nodes), 1)
    before, after = (_distances(mesh.vertices_m[nodes])[upper] for mesh in (rest, full))
    far = before > 0
    return float((after[far] / before[far]).max()) if far.any() else NAN


def _distances(points_m: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points_m[:, None] - points_m[None], axis=2)
