"""Charts over the frames of coupled runs: collision time, memory, depth."""

import pandas as pd

from ..figures import looks
from ..figures.paper_figures import frame_rows
from ..results.disturbance import waits
from ..results.run_folder import Run
from .parts import Axis, Chart

MILLISECONDS, MEGABYTES, MILLIMETRES = 1e-6, 1e-6, 1e3
LEAST_DEPTH_MM = 1e-3  # of the log axis; no depth at all is drawn there
FRAME = Axis("frame", "frame")
ANGLE = {"angle_deg": "joint angle (deg)"}
STAGES = ("update", "detect", "respond", "collision")

Cases = dict[tuple[str, str], Run]  # {(muscle, backend or what else tells runs apart): run}, each with frames


def time_charts(cases: Cases) -> list[Chart]:
    """The control has no collision whose time could be shown; nothing where there is no other."""
    shown = {case: run for case, run in cases.items() if not looks.backend(case[1]).is_control}
    if not shown:
        return []
    rows = frame_rows(shown, [f"{stage}_ns" for stage in STAGES])
    rows["waited"] = pd.concat([waits(run.frames["collision_ns"]) for run in shown.values()], ignore_index=True).astype(int)
    rows = in_units(rows, {f"{stage}_ns": (f"{stage}_ms", MILLISECONDS) for stage in STAGES})
    return [Chart("collision_time", "Collision time of each frame",
                  "Time of update, detection and response in a frame, one thread, log scale. Crosses: frames in which the "
                  "process waited for the processor.", "lines", rows, FRAME, Axis("collision_ms", "collision time a frame (ms)", True),
                  {**ANGLE, **{f"{stage}_ms": f"{stage} (ms)" for stage in STAGES[:3]}}, {"faint": "waited"})]


def memory_chart(cases: Cases) -> Chart:
    rows = in_units(frame_rows(cases, ["resident_bytes"]), {"resident_bytes": ("resident_mb", MEGABYTES)})
    return Chart("memory", "Memory of the process", "Resident memory after each frame, without the Referee (the code that judges the run).",
                 "lines", rows, FRAME, Axis("resident_mb", "resident memory (MB)"), ANGLE, {"from_zero": True})


def depth_chart(cases: Cases) -> Chart:
    columns = {"max_depth_m": ("max_depth_mm", MILLIMETRES), "mean_depth_m": ("mean_depth_mm", MILLIMETRES)}
    rows = in_units(frame_rows(cases, ["nodes_inside", *columns]), columns)
    return Chart("depth_by_frame", "True depth of the nodes in the bones",
                 "Depth of the deepest node in a bone, by the Referee's exact distance, log scale. Depths below 0.001 mm are drawn at the "
                 "lower end.", "lines", rows, FRAME, Axis("max_depth_mm", "largest depth (mm)", True),
                 {**ANGLE, "mean_depth_mm": "mean depth of nodes inside (mm)", "nodes_inside": "nodes inside"}, {"floor": LEAST_DEPTH_MM})


def in_units(rows: pd.DataFrame, columns: dict[str, tuple[str, float]]) -> pd.DataFrame:
    """{column: (new name, factor)}"""
    return rows.assign(**{name: rows[column] * factor for column, (name, factor) in columns.items()}).drop(columns=list(columns))
