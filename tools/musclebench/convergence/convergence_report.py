"""The table and the figure of the convergence study: how far each shape is from that of the most substeps."""

from pathlib import Path

import numpy as np
import pandas as pd

from ..experiments.caveats import caveats
from ..figures.convergence import draw_substeps
from ..program.optional_packages import left_out_without
from ..results.ply import read_ply
from ..results.run_folder import Run, read_run
from ..results.statistics import percentile
from ..tables.table_formats import Column, Table, write_table

COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("backend", "backend"),
    Column("substeps", "substeps", 0), Column("status", "status"),
    Column("rms_mm", "RMS mm", 3), Column("p99_mm", "p99 mm", 3), Column("largest_mm", "largest mm", 3),
    Column("volume_error_percent", "volume error %", 4), Column("largest_depth_mm", "largest depth mm", 3),
]
SHOWN = [column.key for column in COLUMNS if column.key != "muscle"]
CAPTION = (
    "Distance of the muscle's shape at full flexion to that of the run with the most substeps, over the nodes; largest "
    "error of the volume and largest depth of a node over all frames. The time of a frame is the same in all runs."
)


def write_report(folders: list[Path], out_dir: Path) -> tuple[Table, list[Path]]:
    """`folders`: of the runs, those of a scene with its number of substeps ascending."""
    runs = [read_run(folder) for folder in folders]
    rows = [row for scene in dict.fromkeys(run.scene for run in runs)
            for row in _rows([run for run in runs if run.scene == scene])]
    table = Table("substeps", CAPTION, COLUMNS, pd.DataFrame(rows, columns=[column.key for column in COLUMNS]), SHOWN)
    table = table.with_sentence(caveats(out_dir.parent))
    figures = out_dir.parent / "figures"
    for folder in (out_dir, figures):
        folder.mkdir(parents=True, exist_ok=True)
    files = write_table(table, out_dir)
    with left_out_without("the figure"):
        files += draw_substeps(table.rows, figures / "substeps")
    return table, files


def _rows(runs: list[Run]) -> list[dict]:
    runs = sorted(runs, key=_substeps)
    finest = _flexed(runs[-1])
    return [_row(run, finest) for run in runs]


def _row(run: Run, finest: np.ndarray | None) -> dict:
    row = {"muscle": run.muscle, "scene": run.scene, "backend": run.backend, "substeps": _substeps(run), "status": run.status}
    shape = _flexed(run)
    if shape is not None and finest is not None:
        distances = 1e3 * np.linalg.norm(shape - finest, axis=1)
        row |= {"rms_mm": float(np.sqrt(np.mean(distances**2))), "p99_mm": float(percentile(distances, 99)),
                "largest_mm": float(distances.max())}
    rest_m3 = (run.record.get("muscle") or {}).get("rest_volume_m3")
    if rest_m3 and "volume_m3" in run.frames:
        row["volume_error_percent"] = float(100 * (run.frames["volume_m3"] / rest_m3 - 1).abs().max())
    return row | {"largest_depth_mm": float(1e3 * run.frames["max_depth_m"].max())}


def _substeps(run: Run) -> int:
    return int(run.record["case"]["loop"]["substeps"])


def _flexed(run: Run) -> np.ndarray | None:
    """Vertices in the first snapshot: that of full flexion. None where the run came to an end before."""
    stored = sorted(run.record.get("snapshots") or [], key=lambda shot: shot["frame"])
    return read_ply(run.folder / stored[0]["file"]).vertices_m if stored else None
