"""What each effect costs and changes."""

from pathlib import Path

import pandas as pd

from .parts import Axis, Chart, Section
from .written import read_rows, written_table

TABLES = (
    ("effect_costs", "What each effect costs"),
    ("effect_prices", "What a wanted property costs"),
    ("effect_changes", "What effects change"),
    ("returns", "Whether a muscle comes back"),
    ("guards", "Rules of the tunnelling guard"),
)


def tables_in(folder: Path) -> Path:
    """What tools/publish keeps of a study has no folder for its tables."""
    return folder / "tables" if (folder / "tables").is_dir() else folder


def is_effects(folder: Path) -> bool:
    return (tables_in(folder) / "effect_costs.csv").is_file()


def effects_section(folder: Path) -> Section:
    tables = tables_in(folder)
    made = [part for name, title in TABLES for part in written_table(tables, name, title)]
    rows = read_rows(tables / "effect_costs.csv")
    what = [("Runs", f"{len(rows['muscle'].unique())} muscles, {len(rows['effect'].unique())} effects")]
    chart = Chart("effect_costs_chart", "What each effect takes of a frame",
                  "Mean time of the effect's own part of a frame, the largest on top; hovering tells what adding it to the scene's "
                  "own effects, or leaving it out of all, changes. Effects without a part of their own are in the table.",
                  "bars", rows, Axis("own_ms", "ms a frame"), Axis("effect", "effect"),
                  {"share_percent": "share of the frame (%)", "added_ms": "added to the scene's own effects (ms)",
                   "saved_ms": "saved where it is left out of all (ms)"})
    return Section("effects", "What each effect costs", what, [], [chart, *made], {}, folder)
