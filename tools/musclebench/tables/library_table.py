"""Backends side by side, whosever code they run: their answers, times and memory in one replay, and the hard cases that they hold."""

import pandas as pd

from ..results.disturbance import MARK
from .table_formats import Column, as_ratio

HARD = "hard"
COLUMNS = [
    Column("configuration", "configuration"), Column("p99_offset_mm", "surface offset, p99 mm", 3),
    Column("missed", "missed contacts"), Column("deepest_mm", "deepest missed mm", 3), Column("false", "false contacts", 0),
    Column("ms", "ms a frame (95 % interval)"), Column("times_unit", "x {unit}", 2, "", True), Column("frames", "frames", 0),
    Column("build_s", "build s", 2), Column("structure_mb", "MB", 1),
]


def library_table(study: pd.DataFrame, cells: pd.DataFrame) -> tuple[list[Column], pd.DataFrame]:
    """A row a replayed configuration of `study`. `cells` are those of the hard cases, which defaults ran: what is held is counted
    over the cases that were asked of all of these backends."""
    rows = study[study["mode"] == "replay"]
    defaults = rows[(rows["parameters"] == "{}") & (rows["threads"] == 1) & rows["backend"].isin(cells["backend"])]
    asked = cells[cells["backend"].isin(defaults["backend"]) & (cells["verdict"] != "not applicable")]
    common = asked.groupby("case")["backend"].nunique()
    asked = asked[asked["case"].isin(common.index[common == defaults["backend"].nunique()])]
    held = asked[asked["verdict"] == "holds"].groupby("backend").size()
    title = f"held of {asked['case'].nunique()} hard cases"
    table = pd.DataFrame({
        "configuration": rows["configuration"].map("`{}`".format), "p99_offset_mm": 1e3 * rows["p99_offset_m"],
        "missed": [_of(row.missed_contacts, row.true_contacts) for row in rows.itertuples()],
        "deepest_mm": 1e3 * rows["max_missed_depth_m"], "false": rows["false_contacts"],
        "ms": [_time(row) for row in rows.itertuples()], "times_unit": rows["times_unit"], "frames": rows["frames"],
        "build_s": rows["build_s"], "structure_mb": rows["structure_bytes"] / 1e6,
        HARD: [f"{held.get(row.backend, 0)}" if index in defaults.index else "" for index, row in zip(rows.index, rows.itertuples())]})
    return [*COLUMNS, Column(HARD, title)], table


def _of(count: float, whole: float) -> str:
    return "" if pd.isna(count) or pd.isna(whole) else f"{count:.0f} of {whole:.0f}"


def _time(row) -> str:
    if pd.isna(row.collision_ms):
        return "not run: too long" if row.status == "timeout" else str(row.status)
    interval = f" ({as_ratio(row.collision_ms_low)} to {as_ratio(row.collision_ms_high)})" if pd.notna(row.collision_ms_low) else ""
    return f"{as_ratio(row.collision_ms)}{interval}{MARK if row.is_disturbed else ''}"
