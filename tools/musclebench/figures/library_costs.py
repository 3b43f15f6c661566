"""What one library costs in its configurations, beside this project's own, with how far off its surface is."""

import math
import textwrap
from pathlib import Path

import pandas as pd
from matplotlib.ticker import FuncFormatter

from ..accuracy.front import EXACT_MM
from . import looks, style
from .style import plt

OTHERS_COLOUR = "#b8b8b8"
ROW_INCHES = 0.21
MOST_ROWS = 9  # of the library
NAME_LETTERS = 24  # in a line


def libraries_of(rows: pd.DataFrame) -> list[str]:
    """Backends of other projects among the rows."""
    return [name for name in dict.fromkeys(rows["backend"]) if looks.backend(name).is_external or looks.backend(name).has_many_choices]


def draw_library_costs(study: pd.DataFrame, folder: Path) -> dict[str, list[Path]]:
    """{library: files of its figure}, of what study.csv says of the first muscle's replay on one thread."""
    if study.empty:
        return {}
    rows = study[(study["mode"] == "replay") & (study["threads"] == 1) & study["collision_ms"].notna()]
    rows = rows[rows["scene"] == rows["scene"].iloc[0]] if len(rows) else rows
    style.apply_style()
    return {library: _draw(rows, library, folder / f"library_{library}") for library in libraries_of(rows)}


def _draw(rows: pd.DataFrame, library: str, stem: Path) -> list[Path]:
    ours = rows[~rows["backend"].isin(libraries_of(rows)) & (rows["parameters"] == "{}")]
    ours = ours[~ours["backend"].map(lambda name: looks.backend(name).is_control)]
    shown = pd.concat([_chosen(rows[rows["backend"] == library]), ours]).sort_values("collision_ms", ascending=False)
    figure, axes = plt.subplots(figsize=(style.COLUMN_INCHES, ROW_INCHES * len(shown) + 0.75))
    figure.subplots_adjust(left=0.44, right=0.8, top=1 - 0.3 / figure.get_figheight(), bottom=0.38 / figure.get_figheight())
    places = range(len(shown))
    axes.scatter(shown["collision_ms"], places, s=26, zorder=2,
                 c=[looks.colour(library) if name == library else OTHERS_COLOUR for name in shown["backend"]])
    axes.set_xscale("log")
    axes.set_xlim(10.0 ** math.floor(math.log10(shown["collision_ms"].min())), 1.5 * shown["collision_ms"].max())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}".replace(",", "\u2009")))
    axes.set_yticks(places, [textwrap.fill(name, NAME_LETTERS) for name in shown["configuration"]])
    axes.set_ylim(-0.6, len(shown) - 0.4)
    axes.set_xlabel("collision time a frame (ms)")
    for place, error_m in zip(places, shown["p99_offset_m"]):
        axes.text(1.02, place, _offset(1e3 * error_m), transform=axes.get_yaxis_transform(), va="center", fontsize=style.SMALLEST_POINTS)
    axes.text(1.02, len(shown) - 0.2, "off by, mm", transform=axes.get_yaxis_transform(), va="bottom", fontsize=style.SMALLEST_POINTS,
              fontweight="bold")
    figure.suptitle(f"{looks.title(library)}, {style.muscle_label(shown['muscle'].iloc[0])}", x=0.02, ha="left", y=0.995, va="top")
    table = stem.with_suffix(".csv")
    shown[["backend", "configuration", "collision_ms", "p99_offset_m"]].to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def _chosen(rows: pd.DataFrame) -> pd.DataFrame:
    """Of many the default, those that the study names, and the fastest of the rest."""
    named = [one["text"] for one in looks.backend(rows["backend"].iloc[0]).study.get("named", [])]
    is_kept = (rows["parameters"] == "{}") | rows["configuration"].str.endswith(tuple(named)) if named else rows["parameters"] == "{}"
    others = rows[~is_kept].nsmallest(max(MOST_ROWS - int(is_kept.sum()), 0), "collision_ms")
    return pd.concat([rows[is_kept], others])


def _offset(error_mm: float) -> str:
    if math.isnan(error_mm):
        return "-"
    return "exact" if error_mm < EXACT_MM else "< 0.0001" if error_mm < 1e-4 else f"{error_mm:.2g}"
