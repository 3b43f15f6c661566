"""How many nodes the tunnelling guard's rules keep from passing through bones, in whole motions of large steps."""

from pathlib import Path

import pandas as pd

from ..experiments.swept_case import SweptCase
from ..results.run_folder import Run, read_all
from ..tables.table_formats import Column, Table
from .effect_runs import NAN

NO_GUARD = "none"
RULES = ("angle", "crossing")

GUARD_COLUMNS = [
    Column("muscle", "muscle"), Column("frames", "frames of the motion", 0), Column("step_deg", "degrees a frame", 1),
    Column("without", "tunnelled nodes without a guard", 0, "without"), Column("angle", "left by the rule of 135 degrees", 0, "angle"),
    Column("angle_recall", "recall %", 0, "recall\n%"), Column("crossing", "left by the path", 0, "crossing"),
    Column("crossing_recall", "recall %", 0, "recall\n%"),
]
CAPTION = (
    "Nodes on the wrong side of a bone, the most in a frame, where the whole motion is made in few steps (preset `paper`, bones "
    "jump, one substep a frame): without a guard, with the paper's rule of 135 degrees and with the crossing of a node's path. "
    "Recall: the share of those without a guard that is kept."
)


def guard_table(folders: dict[SweptCase, Path]) -> Table:
    """`folders`: of the complete cases."""
    runs = dict(zip(folders, read_all(list(folders.values()))))
    groups: dict[tuple, dict[str, Run]] = {}
    for case, run in runs.items():
        groups.setdefault((case.scene.name, int(case.at("frames").value)), {})[case.at("rule").value] = run
    rows = [_row(of_rules, frames) for (_, frames), of_rules in groups.items()]
    keys = [column.key for column in GUARD_COLUMNS]
    return Table("guards", CAPTION, GUARD_COLUMNS, pd.DataFrame(rows, columns=keys), [key for key in keys if key != "muscle"])


def _row(runs: dict[str, Run], frames: int) -> dict:
    some = next(iter(runs.values()))
    row: dict = {"muscle": some.muscle, "frames": frames, "step_deg": _largest_step_deg(some), "without": _tunnelled(runs.get(NO_GUARD))}
    for rule in RULES:
        kept = _tunnelled(runs.get(rule))
        row[rule] = kept
        row[f"{rule}_recall"] = 100 * (1 - kept / row["without"]) if row["without"] else NAN
    return row


def _tunnelled(run: Run | None) -> float:
    value = ((run.record if run else {}).get("outcome") or {}).get("tunnelled_nodes")
    return NAN if value is None else float(value)


def _largest_step_deg(run: Run) -> float:
    if run.frames.empty:
        return NAN
    return float(pd.concat([pd.Series([0.0]), run.frames["angle_deg"]]).diff().abs().max())
