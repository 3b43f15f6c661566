"""What the answers did to the muscle: the table of coupled runs."""

import math

import pandas as pd

from ..accuracy.aggregates import Aggregate, exact_aggregate
from ..accuracy.shapes import hausdorff_distance_m
from ..program.optional_packages import is_there, left_out_without, require
from ..results.ply import PlyMesh, read_ply, rms_distance_m
from ..results.run_folder import ResultProblem, Run
from .table_formats import Column, Table

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


def outcomes_table(coupled: list[Aggregate], shapes: dict, floors: list[Aggregate]) -> Table:
    """`shapes` as `shape_distances` gives them; `floors`: exact runs from a start that
    differs by rounding, which have rows of their own."""
    told = [_row(one, shapes.get((one.scene, one.configuration), {})) for one in coupled]
    told += [_row(one, floor_of(one, coupled)) | {"configuration": f"{one.configuration.name}, start off by rounding"}
             for one in floors]
    rows = pd.DataFrame(told, columns=[column.key for column in COLUMNS])
    caption = (
        "Coupled runs: each configuration moves its own muscle. Largest true depth over the run of nodes and of the "
        "surface (a muscle triangle in a bone, a bone's vertex in the muscle), the 99th percentile over frames of the "
        "latter; RMS over nodes and symmetric Hausdorff distance (vertices to surface) to the exact run's shape; "
        "collision time summed over the whole run, median of the repetitions. Rows 'start off by rounding' are the exact run "
        "from a start that differs by 1e-12 m: what is no farther from the exact shape can't be told from it."
    )
    return Table("coupled_outcomes", caption, COLUMNS, rows, SHOWN)


def shape_distances(coupled: list[Aggregate]) -> dict:
    """{(scene, configuration): {full_rms_mm, full_hausdorff_mm, final_rms_mm, final_hausdorff_mm}}; without what the
    snapshots don't tell."""
    with left_out_without("Hausdorff distances of shapes"):
        require("vtkmodules")
    return {(e.scene, e.configuration): _distances(e, exact_aggregate(coupled, e.scene)) for e in coupled if e.is_shown}


def floor_of(floor: Aggregate, coupled: list[Aggregate]) -> dict:
    """How far rounding alone takes the exact run's shape."""
    return _distances(floor, exact_aggregate(coupled, floor.scene)) if floor.is_shown else {}


def _distances(aggregate: Aggregate, exact: Aggregate | None) -> dict:
    found = {}
    for moment in MOMENTS if exact else ():
        ours, theirs = snapshot(aggregate, moment), snapshot(exact, moment)
        if ours is None or theirs is None or ours[0] != theirs[0]:
            continue
        found[f"{moment}_rms_mm"] = 1e3 * rms_distance_m(ours[1], theirs[1])
        if is_there("vtkmodules"):
            found[f"{moment}_hausdorff_mm"] = 1e3 * hausdorff_distance_m(ours[1], theirs[1])
    return found


def snapshot(aggregate: Aggregate, moment: str) -> tuple[int, PlyMesh] | None:
    """Frame and shape at full flexion or at the end, of the first repetition that stored it."""
    for case in aggregate.ok:
        stored = [item for item in case.run.record.get("snapshots") or [] if item.get("frame", 0) > 0]
        if not stored:
            continue
        if moment == "full":
            chosen = max(stored, key=lambda item: abs(item["angle_deg"]))
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


def _row(aggregate: Aggregate, against_exact: dict) -> dict:
    return {
        "muscle": aggregate.muscle, "configuration": aggregate.configuration.name, "status": aggregate.status,
        "node_depth_mm": 1e3 * aggregate.number("outcome", "max_depth_m"),
        "surface_depth_mm": 1e3 * aggregate.number("outcome", "max_surface_depth_m"),
        "p99_surface_depth_mm": 1e3 * aggregate.number("outcome", "p99_surface_depth_m"),
        "max_volume_percent": 100 * aggregate.number("outcome", "max_volume_error"),
        "final_volume_percent": 100 * aggregate.number("outcome", "final_volume_error"),
        **against_exact, "tunnelled": _most(aggregate, "tunnelled_nodes"),
        "stuck": aggregate.number("outcome", "stuck_nodes"), "collision_s": total_collision_seconds(aggregate),
        "detail": aggregate.detail,
    }


def _most(aggregate: Aggregate, column: str) -> float:
    """The largest number at the end of a frame; unknown where no run was judged."""
    columns = [case.run.frames[column] for case in aggregate.ok if column in case.run.frames]
    return float(pd.concat(columns).max()) if columns else math.nan


def total_collision_seconds(aggregate: Aggregate) -> float:
    """All frames, warm-up as well; median of the repetitions."""
    sums = [case.run.frames["collision_ns"].sum(min_count=1) / 1e9 for case in aggregate.ok]
    return float(pd.Series(sums).median()) if sums else math.nan
