"""Figures of the budget: what each source of error moves, and the shape against the number of substeps."""

from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..budget.sources import with_rest
from . import style
from .style import plt

PLAIN = FuncFormatter(lambda value, _: f"{value:g}")
ROW_INCHES = 0.2
FLOOR = "rounding"
BAR, NO_MORE_THAN_ROUNDING = "#0072B2", "#b5c6d1"
LEAST_MM = 1e-6
QUIET = ("ok", "nan", "None")  # statuses that need no word


def draw_budget(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """A panel a scene, a bar a source: how far the shape moves (RMS, log axis), with what rounding alone does (dashed) and, as a thin
    line, what the finest setting is itself off by. Pale: no more than rounding."""
    scenes = [(scene, part[part["shape_mm"] > LEAST_MM]) for scene, part in rows.groupby("scene", sort=False)]
    scenes = [(scene, part) for scene, part in scenes if len(part)]
    if not scenes:
        return []
    style.apply_style()
    lines = max(len(part) for _, part in scenes)
    every = pd.concat([part["shape_mm"] + part["left_mm"].fillna(0) for _, part in scenes])
    figure, panels = plt.subplots(len(scenes), 1, squeeze=False, sharex=True, figsize=(style.PAGE_INCHES, (ROW_INCHES * lines + 0.45) * len(scenes) + 0.3))
    for axes, (scene, part) in zip(panels[:, 0], scenes):
        most = part["shape_mm"] + part["left_mm"].fillna(0)
        _draw_bars(axes, part.assign(most_mm=most).sort_values("most_mm", ascending=False))
        axes.set_title(style.muscle_label(str(scene).replace("/", ", ")), loc="left")
        axes.xaxis.set_tick_params(labelbottom=True)
    panels[-1, 0].set_xlim(min(0.3 * min(part["shape_mm"].min() for _, part in scenes), 0.1), 12 * every.max())
    panels[-1, 0].set_xlabel("how far the shape at full flexion moves, RMS (mm)")
    figure.tight_layout()
    return style.save_figure(figure, stem)


def _draw_bars(axes: Axes, part: pd.DataFrame) -> None:
    known = part.loc[part["source"] == FLOOR, "shape_mm"]
    floor = float(known.iloc[0]) if len(known) else 0.0
    colours = [BAR if value > floor else NO_MORE_THAN_ROUNDING for value in part["shape_mm"]]
    axes.set(xscale="log", ylim=(len(part) - 0.4, -0.6))
    axes.barh(range(len(part)), part["shape_mm"], color=colours, height=0.75)
    for line, (value, most) in enumerate(zip(part["shape_mm"], part["most_mm"])):
        axes.plot([value, most], [line, line], color=style.NOTE_COLOUR, linewidth=1)
        axes.text(most * 1.08, line, with_rest(value, most - value), va="center", fontsize=style.SMALLEST_POINTS,
                  bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6})
    if floor:
        axes.axvline(floor, color=style.NOTE_COLOUR, linewidth=0.8, linestyle="--", zorder=0)
    axes.set_yticks(range(len(part)), [_named(row) for row in part.itertuples()])
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter(PLAIN)
    axes.xaxis.set_minor_formatter(NullFormatter())


def _named(row: Any) -> str:
    words: str = row.source if row.setting in row.source else f"{row.source}: {row.setting}"
    return words if str(row.status) in QUIET else f"{words} ({row.status})"


def draw_substeps(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """How far the shape at full flexion is from that of the most substeps; hollow where the run was not ok."""
    shown = rows[rows["rms_mm"] > 0]
    if shown.empty:
        return []
    style.apply_style()
    figure, axes = plt.subplots(figsize=(style.COLUMN_INCHES, 2.9))
    for (scene, curve), shape in zip(shown.groupby("scene", sort=False), "osD^v<>PX"):
        name = style.muscle_label(str(scene).rpartition("/")[2])
        line, = axes.plot(curve["substeps"], curve["rms_mm"], shape, linestyle="-", linewidth=1, markersize=4, label=name)
        not_ok = curve[~curve["status"].astype(str).str.startswith("ok")]
        axes.plot(not_ok["substeps"], not_ok["rms_mm"], shape, color=line.get_color(), markersize=4, markerfacecolor="white")
    axes.set(xscale="log", yscale="log", xlabel="substeps a frame", ylabel="distance from finest shape, RMS (mm)")
    axes.set_xticks(sorted(shown["substeps"].unique()))
    for one in (axes.xaxis, axes.yaxis):
        one.set_major_formatter(PLAIN)
        one.set_minor_formatter(NullFormatter())
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False, borderaxespad=0.2)
    figure.tight_layout()
    return style.save_figure(figure, stem)
