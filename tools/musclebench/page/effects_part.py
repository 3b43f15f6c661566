"""What each effect costs and changes."""

from pathlib import Path


from .parts import Axis, Chart, Section
from .written import read_rows, written_table

TABLES = (
    ("effect_costs", "What each effect costs"),
    ("effect_prices", "What a wanted property costs"),
    ("effect_changes", "What each effect changes"),
    ("returns", "Does a muscle return to its shape?"),
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
    chart = Chart("effect_costs_chart", "Time of each effect in a frame",
                  "Mean time of the effect in a frame, the slowest effect on top. Hover over a bar: what the frame gains when the "
                  "scene adds the effect, and saves when it leaves the effect out. The table also lists effects that are not timed alone.",
                  "bars", rows, Axis("own_ms", "ms a frame"), Axis("effect", "effect"),
                  {"share_percent": "share of the frame (%)", "added_ms": "more time when added to the scene's effects (ms)",
                   "saved_ms": "less time when left out of all effects (ms)"})
    return Section("effects", "What each effect costs", what, [], [chart, *made], {}, folder)
