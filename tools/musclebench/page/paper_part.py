"""The paper's experiment: Fig. 6 in space, Figs 7 and 8, depths, Table I and the times, beside the paper's."""

from pathlib import Path

import pandas as pd

from ..figures import looks
from ..figures.paper_figures import caption, frame_rows, muscle_of_figures
from ..figures.style import muscle_label
from ..paper.published import Published, read_published
from ..results.disturbance import note, waits
from ..results.run_folder import Run, read_runs
from ..results.status import MEASURED
from ..tables import muscle_tables, paper_tables
from ..tables.table_formats import as_ratio
from .looks_of import looks_of
from .parts import Axis, Chart, Section, table_part
from .views import views_of

MILLISECONDS, MEGABYTES, MILLIMETRES = 1e-6, 1e-6, 1e3
NAN = float("nan")
FRAME = Axis("frame", "frame")
ANGLE = {"angle_deg": "joint angle (deg)"}


def is_paper(folder: Path) -> bool:
    return (folder / "runs.csv").is_file() and (folder / "tables" / "table_1_memory.csv").is_file()


def paper_section(folder: Path) -> Section:
    runs, paper = read_runs(folder / "raw"), read_published()
    with_frames = {case: run for case, run in paper_tables.by_case(runs).items() if not run.frames.empty}
    first = muscle_of_figures(muscle for muscle, _ in with_frames) if with_frames else ""
    cases = dict(sorted(with_frames.items(), key=lambda item: item[0][0] != first))
    parts = [views_of(cases, "Fig. 6: shape and depth, in space"), time_chart(cases, paper), memory_chart(cases, paper), *depth_charts(cases),
             table_part(paper_tables.memory_table(runs, paper), "Table I: memory beside the paper's"),
             table_part(paper_tables.time_table(runs, paper), "Times and accuracy beside the paper's")]
    several = muscle_tables.of_several_muscles(runs)
    if several:
        parts += [table_part(muscle_tables.frame_time_table(several), "Where a frame's time goes"),
                  table_part(muscle_tables.depth_table(several), "Depths of several muscles"),
                  table_part(muscle_tables.pair_table(several), "Pairs of several muscles")]
    return Section("paper", "The paper's experiment", what_was_run(runs), problems_of(runs), parts, looks_of(runs), folder)


def what_was_run(runs: list[Run]) -> list[tuple[str, str]]:
    counts = pd.Series([run.status for run in runs]).value_counts()
    return [("Runs", f"{len(runs)}: " + ", ".join(f"{count} {status}" for status, count in counts.items())),
            ("What and on what", caption(runs)),
            ("Scenes", ", ".join(dict.fromkeys(run.scene for run in runs))),
            ("Backends", ", ".join(looks.backends_in_order(run.backend for run in runs))),
            ("Results schema", str(runs[0].record.get("schema_version", "unknown")))]


def problems_of(runs: list[Run]) -> list[str]:
    failed = [f"{run.scene} with {run.backend}: {run.status}, {run.record.get('status_detail')}"
              for run in runs if run.status not in MEASURED]
    busy = note(paper_tables.disturbed_runs(runs), len(runs))
    return [*failed, *([busy] if busy else [])]


def time_chart(cases: dict[tuple[str, str], Run], paper: Published) -> Chart:
    """Fig. 7. The control has no collision whose time could be shown."""
    shown = {case: run for case, run in cases.items() if not looks.backend(case[1]).is_control}
    rows = frame_rows(shown, ["update_ns", "detect_ns", "respond_ns", "collision_ns"])
    rows["waited"] = pd.concat([waits(run.frames["collision_ns"]) for run in shown.values()], ignore_index=True).astype(int)
    rows = in_units(rows, {f"{stage}_ns": (f"{stage}_ms", MILLISECONDS) for stage in ("update", "detect", "respond", "collision")})
    return Chart("fig_7_collision_time", "Fig. 7: collision time of each frame",
                 "Time of update, detection and response a frame of one thread, on a log scale. Crosses: frames in which the "
                 "process waited for the processor. The paper names ratios over the frames; they stand beside the measured ones.",
                 "lines", rows, FRAME, Axis("collision_ms", "collision time a frame (ms)", True),
                 {**ANGLE, "update_ms": "update (ms)", "detect_ms": "detect (ms)", "respond_ms": "respond (ms)"},
                 {"faint": "waited"}, ratios_beside(cases, list(shown), paper))


def ratios_beside(cases: dict[tuple[str, str], Run], shown: list[tuple[str, str]], paper: Published) -> dict:
    """A line a muscle."""
    backends = list(dict.fromkeys(backend for _, backend in shown))
    lines = []
    for muscle in dict.fromkeys(muscle for muscle, _ in shown):
        ratios = {backend: paper_tables.collision_ratio(cases, muscle, backend).value
                  for backend in backends if (muscle, backend) in cases}
        lines.append([muscle_label(muscle), *(_with_paper(ratios.get(backend, NAN), paper.time_ratio(backend)) for backend in backends)])
    return {"caption": "Collision time over that of voxel, median over the frames; in brackets the paper's ratio.",
            "heads": ["muscle", *backends], "lines": lines}


def _with_paper(ours: float, theirs: str) -> str:
    return f"{as_ratio(ours) if ours == ours else '-'} ({theirs or 'none'})"


def memory_chart(cases: dict[tuple[str, str], Run], paper: Published) -> Chart:
    """Fig. 8, with the paper's first and last memory of the same muscle as dots."""
    rows = in_units(frame_rows(cases, ["resident_bytes"]), {"resident_bytes": ("resident_mb", MEGABYTES)})
    rows["source"] = "here"
    theirs = []
    for (muscle, backend), run in cases.items():
        frames = run.frames["frame"]
        for frame, column in ((frames.iloc[0], "first_mb"), (frames.iloc[-1], "last_mb")):
            theirs.append({"muscle": muscle, "backend": backend, "frame": frame, "source": "paper",
                           "resident_mb": paper.memory(run.muscle_alone, backend, column)})
    rows = pd.concat([rows, pd.DataFrame(theirs).dropna()], ignore_index=True)
    return Chart("fig_8_memory", "Fig. 8: memory of the process",
                 "Resident memory without the Referee after each frame. Diamonds: the paper's, before the first and after the "
                 "last iteration, of its own program and build.",
                 "lines", rows, FRAME, Axis("resident_mb", "resident memory (MB)"), ANGLE, {"apart": "source", "from_zero": True})


def depth_charts(cases: dict[tuple[str, str], Run]) -> list[Chart]:
    columns = {"max_depth_m": ("max_depth_mm", MILLIMETRES), "mean_depth_m": ("mean_depth_mm", MILLIMETRES)}
    rows = in_units(frame_rows(cases, ["nodes_inside", *columns]), columns)
    return [Chart("depth_by_frame", "True depth of the nodes in the bones",
                  "The deepest node of the muscle in a bone, by the Referee's exact distance.", "lines", rows, FRAME,
                  Axis("max_depth_mm", "largest depth (mm)"),
                  {**ANGLE, "mean_depth_mm": "mean depth of nodes inside (mm)", "nodes_inside": "nodes inside"},
                  {"from_zero": True})]


def in_units(rows: pd.DataFrame, columns: dict[str, tuple[str, float]]) -> pd.DataFrame:
    """{column: (new name, factor)}"""
    return rows.assign(**{name: rows[column] * factor for column, (name, factor) in columns.items()}).drop(columns=list(columns))

