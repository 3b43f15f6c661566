"""Table I (memory) and the table of times."""

import pandas as pd

from ..paper.paper_backends import in_paper_order, name_of, starts_off_by_rounding
from ..paper.published import Published
from ..results.disturbance import MARK, disturbed
from ..results.run_folder import Run
from ..results.statistics import Estimate, median_ratio
from .table_formats import Column, Table

MEGABYTE = 1e6

MEMORY_COLUMNS = [
    Column("muscle", "muscle"), Column("backend", "backend"), Column("status", "status"),
    Column("first_mb", "first", 1, "process\nfirst"), Column("last_mb", "last", 1, "process\nlast"),
    Column("first_offset_mb", "first - voxel", 1, "- voxel\nfirst"),
    Column("last_offset_mb", "last - voxel", 1, "- voxel\nlast"),
    Column("structure_mb", "structures", 2, "struc-\ntures"),
    Column("paper_first_mb", "paper first", 0, "paper\nfirst"), Column("paper_last_mb", "paper last", 0, "paper\nlast"),
    Column("paper_first_offset_mb", "paper first - voxel", 0, "- voxel\nfirst"),
    Column("paper_last_offset_mb", "paper last - voxel", 0, "- voxel\nlast"),
]

TIME_COLUMNS = [
    Column("muscle", "muscle"), Column("backend", "backend"), Column("status", "status"), Column("frames", "frames", 0),
    Column("collision_ms", "collision ms", 3, "collision\nms"), Column("update_ms", "update ms", 3),
    Column("detect_ms", "detect ms", 3), Column("respond_ms", "respond ms", 3),
    Column("ratio", "x voxel", 2, "x\nvoxel", True), Column("ratio_low", "95 % low", 2, "95 %\nlow", True),
    Column("ratio_high", "95 % high", 2, "95 %\nhigh", True), Column("paper_ratio", "paper x voxel", None, "paper"),
    Column("fps", "frames/s", 1, "frames\n/s"), Column("fps_without", "frames/s without collision", 1),
    Column("missed_contacts", "missed contacts", 0, "missed"), Column("false_contacts", "false contacts", 0, "false"),
    Column("largest_depth_mm", "largest depth mm", 3, "depth\nmm"), Column("mean_depth_mm", "mean depth mm", 3),
    Column("build_s", "build s", 2), Column("structure_mb", "structures MB", 1),
]
TIME_COLUMNS_SHOWN = [
    "backend", "status", "collision_ms", "ratio", "ratio_low", "ratio_high", "paper_ratio", "fps",
    "missed_contacts", "false_contacts", "largest_depth_mm",
]


def by_case(runs: list[Run]) -> dict[tuple[str, str], Run]:
    """{(muscle, backend, or backend and its choices): run}, in the order in which figures and tables list them."""
    cases = {(run.muscle, name_of(run)): run for run in runs if not starts_off_by_rounding(run)}
    muscles = sorted({muscle for muscle, _ in cases})
    backends = in_paper_order(backend for _, backend in cases)
    return {(m, b): cases[m, b] for m in muscles for b in backends if (m, b) in cases}


def memory_table(runs: list[Run], published: Published) -> Table:
    cases = by_case(runs)
    rows = pd.DataFrame([_memory_row(cases, m, b, published) for m, b in cases], columns=_keys(MEMORY_COLUMNS))
    caption = (
        "Table I. Memory in MB (1e6 bytes) before the first and after the last iteration: resident memory of the process "
        "without the Referee, its offset against voxel, and the counted bytes of the backend's structures; the paper's "
        "beside them."
    )
    shown = [key for key in _keys(MEMORY_COLUMNS) if key not in ("muscle", "status")]
    return Table("table_1_memory", caption, MEMORY_COLUMNS, rows, shown)


def time_table(runs: list[Run], published: Published) -> Table:
    cases = by_case(runs)
    rows = pd.DataFrame([_time_row(cases, m, b, published) for m, b in cases], columns=_keys(TIME_COLUMNS))
    caption = (
        "Times and accuracy. Collision time is the median over frames of update + detect + respond; x voxel is the "
        "median of the ratio over the same frames, with a 95 % bootstrap interval over blocks of 10 frames; frames/s "
        "is the whole loop, without collision as the null backend runs it; contacts are summed over the frames, "
        "missed and false against the exact distance; depths are exact."
    )
    return Table("table_2_times", caption, TIME_COLUMNS, rows, TIME_COLUMNS_SHOWN)


def _memory_row(cases, muscle: str, backend: str, published: Published) -> dict:
    run, voxel = cases[muscle, backend], cases.get((muscle, "voxel"))
    row = {"muscle": muscle, "backend": backend, "status": run.status}
    row["structure_mb"] = _megabytes(run.record.get("structure_bytes"))
    for when, key in (("first", "before_first_frame_bytes"), ("last", "after_last_frame_bytes")):
        ours = _memory_mb(run, key)
        theirs = published.memory(run.muscle_alone, backend, f"{when}_mb")
        row[f"{when}_mb"], row[f"paper_{when}_mb"] = ours, theirs
        row[f"{when}_offset_mb"] = ours - _memory_mb(voxel, key)
        row[f"paper_{when}_offset_mb"] = theirs - published.memory(run.muscle_alone, "voxel", f"{when}_mb")
    return row


def _memory_mb(run: Run | None, key: str) -> float:
    return _megabytes(run.record.get("memory", {}).get(key)) if run is not None else float("nan")


def _megabytes(count) -> float:
    return float("nan") if count is None else count / MEGABYTE


def _time_row(cases, muscle: str, backend: str, published: Published) -> dict:
    run, frames = cases[muscle, backend], cases[muscle, backend].timed_frames
    busy = MARK if run.folder.name in disturbed_runs(list(cases.values())) else ""
    ratio = collision_ratio(cases, muscle, backend)
    build_ns = run.record.get("build_ns")
    return {
        "muscle": muscle, "backend": backend, "status": f"{run.status}{busy}", "frames": len(run.frames),
        "collision_ms": frames["collision_ns"].median() / 1e6, "update_ms": frames["update_ns"].median() / 1e6,
        "detect_ms": frames["detect_ns"].median() / 1e6, "respond_ms": frames["respond_ns"].median() / 1e6,
        "ratio": ratio.value, "ratio_low": ratio.low, "ratio_high": ratio.high,
        "paper_ratio": published.time_ratio(backend), "fps": frames_per_second(run),
        "fps_without": frames_per_second(cases.get((muscle, "null"))),
        "missed_contacts": run.frames["missed_contacts"].sum(min_count=1),
        "false_contacts": run.frames["false_contacts"].sum(min_count=1),
        "largest_depth_mm": 1e3 * run.frames["max_depth_m"].max(),
        "mean_depth_mm": 1e3 * run.frames["mean_depth_m"].mean(),
        "build_s": float("nan") if build_ns is None else build_ns / 1e9,
        "structure_mb": _megabytes(run.record.get("structure_bytes")),
    }


def disturbed_runs(runs: list[Run]) -> dict[str, str]:
    """{folder's name: why}"""
    return disturbed({run.folder.name: run.record for run in runs})


def collision_ratio(cases, muscle: str, backend: str) -> Estimate:
    """Collision time of a backend over voxel's, for one muscle; null has none to compare."""
    voxel = cases.get((muscle, "voxel"))
    if voxel is None or backend == "null":
        return Estimate.unknown()
    return median_ratio(cases[muscle, backend].timed_frames["collision_ns"], voxel.timed_frames["collision_ns"])


def frames_per_second(run: Run | None) -> float:
    """Frames over the summed time of the loop; warm-up is left out."""
    if run is None:
        return float("nan")
    nanoseconds = run.timed_frames["frame_ns"].dropna()
    return len(nanoseconds) / nanoseconds.sum() * 1e9 if nanoseconds.sum() > 0 else float("nan")


def _keys(columns: list[Column]) -> list[str]:
    return [column.key for column in columns]
