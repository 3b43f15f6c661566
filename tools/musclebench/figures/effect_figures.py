"""What effects cost a frame, as stacked bars a muscle; what they change, a row a set of effects."""

import math
from collections.abc import Mapping
from pathlib import Path

from ..effects.effect_runs import MeasuredSet
from ..effects.effect_sets import ALL, OWN
from ..effects.effect_tables import change_rows
from . import style
from .style import plt

SPARE_COLOURS = ("#4A3B66", "#8F7DB0", "#CBC0DF")
BONES, REST = "contact with bones", "the rest of the loop"
PART_COLOURS = {BONES: "#f4c7b0", REST: "#e6e6e6"}
BAR_INCHES, LEGEND_COLUMNS, LEGEND_LINE_INCHES = 0.24, 5, 0.17
# Of a row of changes, its title, and what the axis reaches at least: what is smaller is no change.
CHANGES = (("node_depth_mm", "depth of nodes\n(mm)", 0.01), ("surface_depth_mm", "depth of the\nsurface (mm)", 0.01),
           ("volume_percent", "volume error\n(%)", 0.01), ("folded", "triangles\nthrough others", 10),
           ("shape_mm", "RMS to all\neffects (mm)", 0.1))
MARKERS = ("o", "s", "D", "^", "v", "P")
MUSCLE_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")


def draw_costs(measured: list[MeasuredSet], stem: Path, colours: Mapping[str, str]) -> list[Path]:
    """Two bars a muscle: the scene's own effects, and all; over the frame with its own, so that small muscles show. `colours`: by
    effect; the loop is light."""
    shown = [one for one in measured if one.chosen.name in (OWN, ALL) and one.is_measured]
    if not shown:
        return []
    style.apply_style()
    parts = {id(one): _parts(one) for one in shown}
    names = list(dict.fromkeys(name for one in reversed(shown) for name in parts[id(one)]))
    names = [name for name in names if name not in PART_COLOURS] + list(PART_COLOURS)
    legend_inches = LEGEND_LINE_INCHES * math.ceil(len(names) / LEGEND_COLUMNS) + 0.1
    height = BAR_INCHES * len(shown) + legend_inches + 0.5
    figure, axes = plt.subplots(figsize=(style.PAGE_INCHES, height))
    own_ms = {one.scene: one.mean_frame_ms for one in reversed(shown)}  # of own where it is there: it comes first
    for row, one in enumerate(shown):
        left = 0.0
        for name in names:
            width = parts[id(one)].get(name, 0.0) / own_ms[one.scene]
            axes.barh(row, width, left=left, height=0.74, color=_colour(name, colours), edgecolor="white", linewidth=0.4)
            left += width
        axes.text(left, row, f" {one.mean_frame_ms:.3g} ms", va="center", fontsize=7)
    axes.set_yticks(range(len(shown)), [f"{style.muscle_label(one.muscle)}, {one.chosen.name}" for one in shown])
    axes.set(ylim=(len(shown) - 0.45, -0.55), xlabel="mean time of a frame, over that with the muscle's own effects")
    axes.margins(x=0.12)
    axes.grid(axis="y", visible=False)
    figure.tight_layout(rect=(0, 0, 1, 1 - legend_inches / height))
    handles = [plt.Rectangle((0, 0), 1, 1, color=_colour(name, colours)) for name in names]
    figure.legend(handles, [name.replace("_", " ") for name in names], ncols=LEGEND_COLUMNS, loc="upper left",
                  bbox_to_anchor=(0.0, 1.0), frameon=False)
    return style.save_figure(figure, stem)


def _parts(one: MeasuredSet) -> dict[str, float]:
    """Milliseconds by effect, of contact with bones, and what is left of the frame."""
    effects = {name: one.effect_ms(name) for name in one.chosen.effects}
    found = {name: value for name, value in effects.items() if not math.isnan(value)} | {BONES: one.collision_ms}
    return found | {REST: max(0.0, one.mean_frame_ms - sum(found.values()))}


def _colour(name: str, colours: Mapping[str, str]) -> str:
    if name in PART_COLOURS:
        return PART_COLOURS[name]
    return colours.get(name, SPARE_COLOURS[sum(map(ord, name)) % len(SPARE_COLOURS)])


def draw_changes(measured: list[MeasuredSet], stem: Path) -> list[Path]:
    """A panel a quantity, a row a set, a point a muscle."""
    rows = [row for row, one in zip(change_rows(measured), measured) if one.is_measured and not one.chosen.is_loaded]
    if not rows:
        return []
    style.apply_style()
    sets, muscles = list(dict.fromkeys(row["set"] for row in rows)), list(dict.fromkeys(row["muscle"] for row in rows))
    height = 0.19 * len(sets) + 1.1
    figure, panels = plt.subplots(1, len(CHANGES), figsize=(style.PAGE_INCHES, height), sharey=True)
    for axes, (key, title, least) in zip(panels, CHANGES):
        for number, muscle in enumerate(muscles):
            mine = [row for row in rows if row["muscle"] == muscle and not math.isnan(row[key])]
            axes.plot([row[key] for row in mine], [sets.index(row["set"]) for row in mine], linestyle="none",
                      marker=MARKERS[number % len(MARKERS)], markersize=3.6, alpha=0.85, markeredgewidth=0,
                      color=MUSCLE_COLOURS[number % len(MUSCLE_COLOURS)], label=style.muscle_label(muscle))
        axes.set_title(title, loc="left", fontsize=7.5)
        axes.set_xlim(0, 1.1 * max(least, *(row[key] for row in rows if not math.isnan(row[key]))))
        axes.locator_params(axis="x", nbins=3)
        axes.tick_params(axis="y", length=0)
    panels[0].set_yticks(range(len(sets)), [name.replace("_", " ") for name in sets])
    panels[0].set_ylim(len(sets) - 0.4, -0.6)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.25 / height), w_pad=0.6)
    figure.legend(*panels[0].get_legend_handles_labels(), ncols=6, loc="upper left", bbox_to_anchor=(0.0, 1.0),
                  frameon=False)
    return style.save_figure(figure, stem)
