"""Whether the surface offset tells what a run will leave: p99 inward offset against the depth of contacts in a coupled run."""

import math
from pathlib import Path

import pandas as pd
from matplotlib.ticker import FuncFormatter

from ..accuracy.aggregates import Aggregate
from . import looks, style
from .style import muscle_label, plt

EXACT_MM = 1e-3  # what is smaller is drawn here
FACTOR = 2.0
MOST_NAMES = 10
COLUMNS = ["scene", "muscle", "backend", "configuration", "inward_mm", "depth_mm", "agrees"]


def offset_rows(replays: list[Aggregate]) -> pd.DataFrame:
    """Of configurations that were asked about points and moved their own muscle, too."""
    rows = []
    for one in replays:
        inward = 1e3 * one.number("surface_offset", "p99_inward_m")
        depth = one.left_mm
        if one.is_shown and not math.isnan(inward) and not math.isnan(depth):
            low, high = sorted((max(inward, EXACT_MM), max(depth, EXACT_MM)))
            rows.append([one.scene, one.muscle, one.backend, one.configuration.name, inward, depth, high <= FACTOR * low])
    return pd.DataFrame(rows, columns=COLUMNS)


def draw_offsets(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """PNG, SVG, PDF and CSV; nothing without rows."""
    if rows.empty:
        return []
    style.apply_style()
    figure, axes = plt.subplots(figsize=(style.COLUMN_INCHES, style.COLUMN_INCHES))
    shown = rows.assign(x=rows["inward_mm"].clip(lower=EXACT_MM), y=rows["depth_mm"].clip(lower=EXACT_MM))
    low, high = EXACT_MM / 1.6, 2.5 * float(shown[["x", "y"]].max().max())
    axes.set(xscale="log", yscale="log", xlim=(low, high), ylim=(low, high),
             xlabel="surface offset inwards, p99 (mm)", ylabel="depth its own run leaves, p99 (mm)")
    for side in (axes.xaxis, axes.yaxis):
        side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.fill_between([low, high], [low / FACTOR, high / FACTOR], [low * FACTOR, high * FACTOR], color="#eef2f5", zorder=0)
    for backend in looks.backends_in_order(shown["backend"].unique()):
        own = shown[shown["backend"] == backend]
        axes.scatter(own["x"], own["y"], s=18, color=looks.colour(backend), marker=looks.marker(backend), zorder=3,
                     linewidth=0, alpha=0.8, label=looks.title(backend))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=style.SMALLEST_POINTS)
    figure.tight_layout()
    table = stem.with_suffix(".csv")
    rows.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def told(rows: pd.DataFrame) -> str:
    """Which configurations are outside of the band."""
    outside = rows[~rows["agrees"]]
    names = [f"{muscle_label(row.muscle)} with {row.configuration}" for row in outside.itertuples()]
    if len(names) > MOST_NAMES:
        names[MOST_NAMES:] = [f"{len(names) - MOST_NAMES} more (in the CSV)"]
    agreed = f"{len(rows) - len(outside)} of {len(rows)} agree within a factor of {FACTOR:g}"
    return f"{agreed}; outside: {', '.join(names)}." if names else f"{agreed}."
