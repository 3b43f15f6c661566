"""The table of substeps: how far each shape is from that of the most substeps."""

import pandas as pd

from ..results.run_folder import Run
from ..results.statistics import percentile
from ..tables.table_formats import Column, Table
from .sources import node_distances_mm, shape_mm

COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("backend", "backend"),
    Column("substeps", "substeps", 0), Column("status", "status"),
    Column("rms_mm", "RMS mm", 3), Column("p99_mm", "p99 mm", 3), Column("largest_mm", "largest mm", 3),
    Column("volume_error_percent", "volume error %", 4), Column("largest_depth_mm", "deepest node mm", 3),
]
SHOWN = [column.key for column in COLUMNS if column.key != "muscle"]
CAPTION = (
    "Distance of the muscle's shape at full flexion to that of the run with the most substeps, over the nodes; largest "
    "error of the volume and largest depth of a node over all frames. The time of a frame is the same in all runs."
)


def table(runs: list[Run]) -> Table:
    """`runs`: those of a scene with its number of substeps ascending."""
    rows = [row for scene in dict.fromkeys(run.scene for run in runs)
            for row in _rows([run for run in runs if run.scene == scene])]
    return Table("substeps", CAPTION, COLUMNS, pd.DataFrame(rows, columns=[column.key for column in COLUMNS]), SHOWN)


def _rows(runs: list[Run]) -> list[dict[str, object]]:
    runs = sorted(runs, key=_substeps)
    return [_row(run, runs[-1]) for run in runs]


def _row(run: Run, finest: Run) -> dict[str, object]:
    row: dict[str, object] = {"muscle": run.muscle, "scene": run.scene, "backend": run.backend, "substeps": _substeps(run), "status": run.status}
    distances_mm = node_distances_mm(run, finest)
    if distances_mm is not None:
        row |= {"rms_mm": shape_mm(run, finest), "p99_mm": float(percentile(distances_mm, 99)), "largest_mm": float(distances_mm.max())}
    rest_m3 = (run.record.get("muscle") or {}).get("rest_volume_m3")
    if rest_m3 and "volume_m3" in run.frames:
        row["volume_error_percent"] = float(100 * (run.frames["volume_m3"] / rest_m3 - 1).abs().max())
    return row | {"largest_depth_mm": float(1e3 * run.frames["max_depth_m"].max())}


def _substeps(run: Run) -> int:
    return int(run.record["case"]["loop"]["substeps"])
