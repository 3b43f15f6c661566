"""What the answers did to the muscle: the table of coupled runs."""

import math

import pandas as pd

from ..results.ply import PlyMesh, read_ply
from ..results.run_folder import ResultProblem, Run
from .table_formats import Column, Table
from ..accuracy.aggregates import Entry, exact_entry
from ..accuracy.shapes import hausdorff_distance_m, rms_distance_m

MOMENTS = ("full", "final")  # full flexion, last frame
COLUMNS = [
    Column("muscle", "muscle"), Column("configuration", "configuration"), Column("status", "status"),
    Column("node_depth_mm", "largest depth of nodes mm", 3, "nodes\nmm"),
    Column("surface_depth_mm", "largest depth of the surface mm", 3, "surface\nmm"),
    Column("p99_surface_depth_mm", "p99 depth of the surface mm", 3, "p99\nmm"),
    Column("max_volume_percent", "largest volume error %", 2, "volume\n%"),
    Column("final_volume_percent", "final volume error %", 2),
    Column("full_rms_mm", "RMS to exact, full flexion mm", 3, "RMS\nfull"),
    Column("full_hausdorff_mm", "Hausdorff to exact, full flexion mm", 3, "Hausd.\nfull"),
    Column("final_rms_mm", "RMS to exact, final mm", 3, "RMS\nfinal"),
    Column("final_hausdorff_mm", "Hausdorff to exact, final mm", 3, "Hausd.\nfinal"),
    Column("tunnelled", "tunnelled nodes", 0, "tun-\nnelled"), Column("stuck", "stuck nodes", 0, "stuck"),
    Column("collision_s", "collision time of the run s", 3, "total\ns"), Column("detail", "detail"),
]
SHOWN = ["configuration", "node_depth_mm", "p99_surface_depth_mm", "max_volume_percent", "full_rms_mm",
         "full_hausdorff_mm", "final_rms_mm", "tunnelled", "stuck", "collision_s"]


def outcomes_table(coupled: list[Entry], shapes: dict) -> Table:
    """`shapes` as `shape_distances` gives them."""
    rows = pd.DataFrame([_row(entry, shapes) for entry in coupled], columns=[column.key for column in COLUMNS])
    caption = (
        "Coupled runs: each configuration moves its own muscle. Largest true depth over the run of nodes and of the "
        "surface (a muscle triangle in a bone, a bone's vertex in the muscle), the 99th percentile over frames of the "
        "latter; RMS over nodes and symmetric Hausdorff distance (vertices to surface) to the exact run's shape; "
        "collision time summed over the whole run, median of the repetitions."
    )
    return Table("coupled_outcomes", caption, COLUMNS, rows, SHOWN)


def shape_distances(coupled: list[Entry]) -> dict:
    """{(scene, configuration): {full_rms_mm, full_hausdorff_mm, final_rms_mm, final_hausdorff_mm}}; without what the
    snapshots don't tell."""
    return {(e.scene, e.configuration): _distances(e, exact_entry(coupled, e.scene)) for e in coupled if e.is_shown}


def _distances(entry: Entry, exact: Entry | None) -> dict:
    found = {}
    for moment in MOMENTS if exact else ():
        ours, theirs = snapshot(entry, moment), snapshot(exact, moment)
        if ours is None or theirs is None or ours[0] != theirs[0]:
            continue
        found[f"{moment}_rms_mm"] = 1e3 * rms_distance_m(ours[1], theirs[1])
        found[f"{moment}_hausdorff_mm"] = 1e3 * hausdorff_distance_m(ours[1], theirs[1])
    return found


def snapshot(entry: Entry, moment: str) -> tuple[int, PlyMesh] | None:
    """Frame and shape at full flexion or at the end, of the first repetition that stored it."""
    for case in entry.ok:
        stored = [item for item in case.run.record.get("snapshots") or [] if item.get("frame", 0) > 0]
        if not stored:
            continue
        if moment == "full":
            chosen = max(stored, key=lambda item: item["angle_deg"])
        else:
            chosen = max(stored, key=lambda item: item["frame"])
            if chosen["frame"] != _last_frame(case.run):
                continue
        try:
            return chosen["frame"], read_ply(case.run.folder / chosen["file"])
        except ResultProblem:
            continue  # a snapshot that is gone is unknown; the row keeps its other numbers
    return None


def _last_frame(run: Run) -> int:
    return int(run.frames["frame"].max()) if len(run.frames) else -1


def _row(entry: Entry, shapes: dict) -> dict:
    return {
        "muscle": entry.muscle, "configuration": entry.configuration.name, "status": entry.status,
        "node_depth_mm": 1e3 * entry.number("outcome", "max_depth_m"),
        "surface_depth_mm": 1e3 * entry.number("outcome", "max_surface_depth_m"),
        "p99_surface_depth_mm": 1e3 * entry.number("outcome", "p99_surface_depth_m"),
        "max_volume_percent": 100 * entry.number("outcome", "max_volume_error"),
        "final_volume_percent": 100 * entry.number("outcome", "final_volume_error"),
        **shapes.get((entry.scene, entry.configuration), {}), "tunnelled": _most(entry, "tunnelled_nodes"),
        "stuck": entry.number("outcome", "stuck_nodes"), "collision_s": total_collision_seconds(entry),
        "detail": entry.detail,
    }


def _most(entry: Entry, column: str) -> float:
    """The largest number at the end of a frame; unknown where no run was judged."""
    columns = [case.run.frames[column] for case in entry.ok if column in case.run.frames]
    return float(pd.concat(columns).max()) if columns else math.nan


def total_collision_seconds(entry: Entry) -> float:
    """All frames, warm-up as well; median of the repetitions."""
    sums = [case.run.frames["collision_ns"].sum(min_count=1) / 1e9 for case in entry.ok]
    return float(pd.Series(sums).median()) if sums else math.nan
