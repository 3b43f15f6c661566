"""How smooth each backend leaves the muscle on the bones, against the exact run."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..figures import looks
from ..paper.paper_backends import name_of, starts_off_by_rounding
from ..results.ply import rms_distance_m
from ..results.roughness import free_nodes_near, roughness_deg
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones, read_snapshots
from .paper_tables import by_case
from .table_formats import Column, Table

NEAR_M = 0.01
COLUMNS = [
    Column("muscle", "muscle"), Column("backend", "backend"), Column("angle_deg", "joint angle deg", 0, "angle\ndeg"),
    Column("nodes", "nodes near bones", 0, "nodes"), Column("rest_deg", "roughness at rest deg", 2, "rest\ndeg"),
    Column("roughness_deg", "roughness deg", 2, "rough\ndeg"), Column("over_exact", "x exact", 3, "x\nexact"),
    Column("floor_percent", "rounding alone %", 1, "round-\ning %"), Column("rms_mm", "RMS to exact mm", 3, "RMS\nmm"),
]


@dataclass
class Exact:
    """The exact run's shape of one muscle where it is turned farthest, and which of its nodes are looked at."""

    shape: Snapshot
    nodes: np.ndarray
    roughness_deg: float
    floor_percent: float


def smoothness_table(runs: list[Run]) -> Table | None:
    """`runs`: with the exact one, and the exact one that starts off by rounding, which has no row. Nothing without shapes of
    an exact run."""
    floors = {run.muscle: run for run in runs if starts_off_by_rounding(run)}
    cases = by_case(runs)
    exact = {muscle: _exact(run, floors.get(muscle)) for (muscle, _), run in cases.items() if looks.backend(run.backend).is_exact}
    rows = [row for (muscle, _), run in cases.items() if exact.get(muscle) for row in _rows(run, exact[muscle])]
    if not rows:
        return None
    caption = (
        f"Smoothness at the joint, where it is turned farthest. Roughness is the root of the mean square angle between the normals "
        f"of neighbouring triangles, over the edges between free nodes that the exact run has within {1e3 * NEAR_M:.0f} mm of a "
        "bone: the same edges for every backend. Rounding alone: how much the exact run's roughness changes if it starts off by "
        "1e-12 m; smaller differences mean nothing."
    )
    return Table("smoothness", caption, COLUMNS, pd.DataFrame(rows, columns=[column.key for column in COLUMNS]),
                 [column.key for column in COLUMNS[1:]])


def _exact(run: Run, floor: Run | None) -> Exact | None:
    kept = run.record.get("snapshots", [])
    if len(kept) < 2:
        return None
    farthest = max(kept, key=lambda entry: abs(entry["angle_deg"] - kept[0]["angle_deg"]))
    shape = _at(run, farthest["frame"])
    if shape is None:
        return None
    bones_m = np.vstack([bone.vertices_m @ rotation.T + translation_m
                         for bone, (rotation, translation_m) in zip(read_bones(run).values(), shape.poses)])
    nodes = free_nodes_near(shape.mesh, bones_m, NEAR_M)
    roughness = roughness_deg(shape.mesh, nodes)
    other = _at(floor, shape.frame) if floor else None
    floor_percent = 100 * abs(roughness_deg(other.mesh, nodes) / roughness - 1) if other else float("nan")
    return Exact(shape, nodes, roughness, floor_percent)


def _at(run: Run, frame: int) -> Snapshot | None:
    """A run that did not end well has no such shape, or one that is no shape."""
    entries = [entry for entry in run.record.get("snapshots", []) if entry["frame"] == frame]
    return next(iter(read_snapshots(run, entries)), None)


def _rows(run: Run, exact: Exact) -> list[dict]:
    kept = run.record.get("snapshots", [])
    rest, shape = _at(run, kept[0]["frame"]) if kept else None, _at(run, exact.shape.frame)
    if rest is None or shape is None or len(shape.mesh.vertices_m) != len(exact.nodes):
        return []
    roughness = roughness_deg(shape.mesh, exact.nodes)
    return [{"muscle": run.muscle, "backend": name_of(run), "angle_deg": shape.angle_deg, "nodes": np.count_nonzero(exact.nodes),
             "rest_deg": roughness_deg(rest.mesh, exact.nodes), "roughness_deg": roughness,
             "over_exact": roughness / exact.roughness_deg, "floor_percent": exact.floor_percent,
             "rms_mm": 1e3 * rms_distance_m(shape.mesh, exact.shape.mesh)}]
