"""What scenes of several muscles are asked: where a frame's time goes, and how deep muscles are in bones and each other."""

import pandas as pd

from ..paper.paper_backends import name_of, starts_off_by_rounding
from ..results.run_folder import NOT_OF_THE_LOOP, Run
from .table_formats import Column, Table

TOTALS = ("frame_ns",)
DEPTH_COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("backend", "backend"),
    Column("bone_depth_mm", "deepest in a bone mm", 3, "in bone\nmm"),
    Column("bone_nodes", "most nodes in bones", 0, "nodes\nin bones"),
    Column("muscle_depth_mm", "deepest in a muscle mm", 3, "in muscle\nmm"),
    Column("muscle_nodes", "most nodes in muscles", 0, "nodes in\nmuscles"),
    Column("volume_change_percent", "largest change of the volume %", 2, "volume\n%"),
    Column("edge_stretch", "longest edge over rest", 2, "edge"),
]
PAIR_COLUMNS = [
    Column("muscle", "muscle and what it touches"), Column("scene", "scene"), Column("backend", "backend"),
    Column("detect_ms", "asking a frame ms", 3, "asking\nms"), Column("contacts", "most contacts", 0, "contacts"),
]


def of_several_muscles(runs: list[Run]) -> list[Run]:
    return [run for run in runs if not run.muscles.empty and not starts_off_by_rounding(run)]


def frame_time_table(runs: list[Run]) -> Table:
    """Medians over the frames, by effect and contact stage."""
    stages = list(dict.fromkeys(name for run in runs for name in run.frames.columns
                                if name.endswith("_ns") and name not in (*NOT_OF_THE_LOOP, *TOTALS)))
    columns = [Column("muscle", "scene"), Column("backend", "backend")]
    timed = {name: name.removesuffix("_ns") for name in [*stages, *TOTALS]}
    columns += stage_columns(list(timed.values()))
    rows = pd.DataFrame([{"muscle": run.muscle, "backend": name_of(run),
                          **{f"{stage}_ms": run.timed_frames[name].median() / 1e6 if name in run.frames else float("nan")
                             for name, stage in timed.items()}} for run in runs],
                        columns=[column.key for column in columns])
    caption = ("Table 3. Where a frame's time goes: medians over the frames in ms, by effect and stage of the collision; update, "
               "detect and respond are those of the backend with all bones, muscle_contact is that of all pairs of muscles.")
    return Table("table_3_frame_times", caption, columns, rows, [column.key for column in columns[1:]])


def stage_columns(stages: list[str]) -> list[Column]:
    return [Column(f"{stage}_ms", f"{stage} ms", 3, stage.replace("_", "\n")) for stage in stages]


def depth_table(runs: list[Run]) -> Table:
    rows = pd.DataFrame([_depth_row(run, name, rows) for run in runs for name, rows in run.muscles.groupby("muscle")],
                        columns=[column.key for column in DEPTH_COLUMNS])
    rows = rows.sort_values(["muscle", "scene"], kind="stable", ignore_index=True)
    caption = ("Table 4. How deep muscles are in bones and in each other over the whole motion (true depths of nodes), and what "
               "became of their shape. The change of volume is against the first frame.")
    return Table("table_4_depths", caption, DEPTH_COLUMNS, rows, [column.key for column in DEPTH_COLUMNS[1:]])


def pair_table(runs: list[Run]) -> Table:
    """Of each muscle with each bone and each muscle that it touches: medians over the frames, the most contacts of a frame."""
    rows = pd.DataFrame([_pair_row(run, f"{muscle}, {other}", rows) for run in runs
                         for (muscle, other), rows in run.pairs.groupby(["muscle", "other"])],
                        columns=[column.key for column in PAIR_COLUMNS])
    rows = rows.sort_values("muscle", kind="stable", ignore_index=True)
    caption = ("Table 5. Detection by pair: the time of asking the nodes of a muscle about a bone, or of either muscle about the "
               "other, medians over the frames in ms, summed over threads. What serves all pairs (refitting, clearances) is in none.")
    return Table("table_5_pairs", caption, PAIR_COLUMNS, rows, [column.key for column in PAIR_COLUMNS[1:]])


def _pair_row(run: Run, pair: str, rows: pd.DataFrame) -> dict:
    timed = rows[rows["frame"].isin(run.timed_frames["frame"])]
    return {"muscle": pair, "scene": run.muscle, "backend": name_of(run), "detect_ms": timed["detect_ns"].median() / 1e6,
            "contacts": rows["contacts"].max()}


def _depth_row(run: Run, muscle: str, rows: pd.DataFrame) -> dict:
    volumes = rows["volume_m3"]
    return {
        "muscle": muscle, "scene": run.muscle, "backend": name_of(run), "bone_depth_mm": 1e3 * rows["max_depth_m"].max(),
        "bone_nodes": rows["nodes_inside"].max(), "muscle_depth_mm": 1e3 * rows["max_muscle_depth_m"].max(),
        "muscle_nodes": rows["nodes_inside_muscles"].max(),
        "volume_change_percent": 100 * (volumes / volumes.iloc[0] - 1).abs().max(),
        "edge_stretch": rows["max_edge_stretch"].max(),
    }
