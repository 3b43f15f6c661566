"""Backends side by side, whosever code they run: their answers, times and memory in one replay, and the hard cases that they hold."""

import pandas as pd

from .table_formats import Column

COLUMNS = [
    Column("configuration", "configuration"), Column("p99_offset_mm", "surface offset, p99 mm", 3),
    Column("missed", "missed contacts", 0), Column("false", "false contacts", 0), Column("collision_ms", "ms a frame", 3),
    Column("times_unit", "x {unit}", 2, "", True), Column("build_s", "build s", 2), Column("structure_mb", "MB", 1),
    Column("hard", "hard cases held"),
]


def library_rows(study: pd.DataFrame, cells: pd.DataFrame) -> pd.DataFrame:
    """A row a replayed configuration of `study`; `cells` are those of the hard cases, which defaults ran: other configurations
    have none."""
    rows = study[(study["mode"] == "replay") & study["collision_ms"].notna()]
    return pd.DataFrame({
        "configuration": rows["configuration"].map("`{}`".format), "p99_offset_mm": 1e3 * rows["p99_offset_m"],
        "missed": rows["missed_contacts"], "false": rows["false_contacts"], "collision_ms": rows["collision_ms"],
        "times_unit": rows["times_unit"], "build_s": rows["build_s"], "structure_mb": rows["structure_bytes"] / 1e6,
        "hard": [held(cells, row) for row in rows.itertuples()]})


def held(cells: pd.DataFrame, row) -> str:
    asked = cells[(cells["backend"] == row.backend) & (cells["verdict"] != "not applicable")]
    is_default = row.parameters == "{}" and row.threads == 1
    return f"{(asked['verdict'] == 'holds').sum()} of {len(asked)}" if is_default and len(asked) else ""
