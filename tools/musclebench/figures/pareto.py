"""The Pareto picture: collision time a frame against error, both log, one panel a muscle and one for all."""

import math
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..accuracy.front import ALL_MUSCLES, EXACT_MM
from . import looks, style
from .labels import Label, place_labels
from .style import plt

PANEL_HEIGHT_INCHES = 3.1
COLUMNS = 2
BAND_SHARE = 0.30  # of the axis' height for what is exact
LANES = 5  # in that band, so that points of about the same time stand apart
KEY_LETTERS = 23  # in a line of the names of numbers
LEGEND_BYTES = (1e4, 1e6, 1e8)
FRONT_COLOUR = "#555555"


@dataclass
class Axis:
    """The range of errors that all panels share."""

    low_mm: float  # end of the log axis, a power of ten
    bottom_mm: float  # end of the band of what is exact, below it; `low_mm` where nothing is
    high_mm: float

    def height(self, error_mm: float, lane: int) -> float:
        """Where a point is drawn: inside of the band the height means nothing."""
        if error_mm >= EXACT_MM:
            return error_mm
        share = (lane % LANES + 0.7) / (LANES + 0.4)
        return self.low_mm * (self.bottom_mm / self.low_mm) ** share


def draw_pareto(points: pd.DataFrame, stem: Path, title: str, error_title: str, nothing: str) -> list[Path]:
    """PNG, SVG, PDF and CSV; nothing without points. `nothing`: what an error below a nanometre is called."""
    if points.empty or points["is_control"].all():
        return []
    style.apply_style()
    panels = list(dict.fromkeys(points["panel"]))
    columns = min(COLUMNS, len(panels) + 1)
    rows = math.ceil((len(panels) + 1) / columns)
    shares = [1.0, 0.8] if len(panels) == 1 else [1.0] * columns
    figure, cells = plt.subplots(rows, columns, figsize=(style.PAGE_INCHES, PANEL_HEIGHT_INCHES * rows), squeeze=False,
                                 width_ratios=shares)
    cells = list(cells.flat)
    numbers = _numbers(points)
    for cell, panel in zip(cells, panels):
        cell.set(xlabel="collision time a frame (ms)", ylabel=error_title)
        cell.set_title(panel_title(panel, panels), loc="left")
    for cell in cells[len(panels):]:
        cell.axis("off")
    figure.suptitle(title, x=0.01, ha="left")
    axis = error_axis(points["error_mm"])
    # Labels are laid out in pixels: the panels must have their final size before, with room for the numbers at their axes.
    digits = max(0.0, -math.log10(axis.low_mm) - 2)
    figure.tight_layout(rect=(0.012 * digits, 0, 1, 0.99), w_pad=1.0 + digits, h_pad=1.0)
    for cell, panel in zip(cells, panels):
        _draw_panel(cell, points[points["panel"] == panel], axis, numbers, nothing)
    # Below a panel the key may have the room of its axis' words.
    _draw_key(cells[len(panels)], points, numbers, left=-0.12 if len(panels) >= columns else 0.0)
    table = stem.with_suffix(".csv")
    points.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def panel_title(panel: str, panels: list[str]) -> str:
    if panel == ALL_MUSCLES:
        return "all muscles: sum of times, largest error"
    data_sets = {name.split("/")[0] for name in panels if name != ALL_MUSCLES}
    data_set, muscle = panel.split("/")[0], style.muscle_label(panel.split("/")[-1])
    return f"{muscle} ({data_set})" if len(data_sets) > 1 else muscle


def error_axis(errors_mm: pd.Series) -> Axis:
    """Of the errors that are not exact, whole powers of ten; without any such errors from 0.001 to 1 mm."""
    measured = errors_mm[errors_mm >= EXACT_MM]
    low, high = (measured.min(), measured.max()) if len(measured) else (1e-3, 1.0)
    low = 10.0 ** math.floor(math.log10(low) - 1e-9)
    high = max(high * 2.5, low * 10)
    band = BAND_SHARE if (errors_mm < EXACT_MM).any() else 0.0
    decades = math.log10(high / low) * band / (1 - band)
    return Axis(low, low / 10**decades, high)


def _draw_panel(axes, points: pd.DataFrame, axis: Axis, numbers: dict[str, int], nothing: str) -> None:
    times = _time_limits(points)
    axes.set(xscale="log", yscale="log", xlim=times, ylim=(axis.bottom_mm, axis.high_mm))
    _mark_exact(axes, axis, nothing)
    points = points.sort_values("time_ms").reset_index(drop=True)
    exact = points["error_mm"] < EXACT_MM
    lanes = exact.cumsum() - 1
    heights = pd.Series([axis.height(e, lane) for e, lane in zip(points["error_mm"], lanes)], index=points.index)
    _draw_front(axes, points, axis)
    labels = []
    for series, curve in points[points["series"].notna()].groupby("series", sort=False):
        curve = curve.sort_values("fineness")
        backend = curve["backend"].iloc[0]
        _, dashes = looks.series_style(backend, series)
        axes.plot(curve["time_ms"], heights[curve.index], linestyle=dashes, linewidth=0.8, zorder=2,
                  color=looks.colour(backend))
    for index, point in points.iterrows():
        if point["is_control"]:
            _draw_control(axes, point, heights[index], times)
            continue
        _draw_point(axes, point, heights[index])
        text = _label_text(point, points, numbers)
        radius = math.sqrt(marker_area(point["structure_bytes"])) / 2
        side, bar = _side(point), (point["time_ms_low"], point["time_ms_high"])
        colour = looks.colour(point["backend"])
        labels.append(Label(point["time_ms"], heights[index], text, colour, radius, side, bar))
    place_labels(axes, labels, size=style.SMALLEST_POINTS)


def _mark_exact(axes, axis: Axis, nothing: str) -> None:
    if axis.bottom_mm < axis.low_mm:
        axes.axhspan(axis.bottom_mm, axis.low_mm, facecolor="#eef2f5", edgecolor="none", zorder=0)
        axes.axhline(axis.low_mm, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        axes.text(0.012, 0.012, f"{nothing} (below 1 nm)", transform=axes.transAxes, fontsize=7,
                  color=style.NOTE_COLOUR, va="bottom")
    # Ticks only where the axis is one: not in the band.
    decades = np.arange(round(math.log10(axis.low_mm)), math.floor(math.log10(axis.high_mm)) + 1)
    axes.set_yticks([10.0**decade for decade in decades])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_yticks([], minor=True)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}".replace(",", "\u2009")))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _draw_front(axes, points: pd.DataFrame, axis: Axis) -> None:
    front = points[points["on_front"]].sort_values("time_ms")
    if front.empty:
        return
    heights = [max(error, axis.low_mm) if error >= EXACT_MM else axis.low_mm for error in front["error_mm"]]
    x = [*front["time_ms"], axes.get_xlim()[1]]
    axes.step(x, [*heights, heights[-1]], where="post", color=FRONT_COLOUR, linewidth=2.6, alpha=0.25, zorder=1.2,
              solid_joinstyle="miter")


def _draw_point(axes, point, height: float) -> None:
    colour, area = looks.colour(point["backend"]), marker_area(point["structure_bytes"])
    axes.plot([point["time_ms_low"], point["time_ms_high"]], [height, height], color=colour, linewidth=1.0, alpha=0.8,
              zorder=3, solid_capstyle="butt")
    shape = _marker(point)
    wrong = point["is_wrong"]
    edge = "black" if point["on_front"] else colour if wrong else "white"
    axes.scatter([point["time_ms"]], [height], s=area, marker=shape, facecolor="none" if wrong else colour,
                 edgecolor=edge, linewidth=0.9 if point["on_front"] else 0.4, zorder=5 if point["on_front"] else 4)
    if wrong:
        axes.scatter([point["time_ms"]], [height], s=1.6 * area, marker="x", color=colour, linewidth=0.7, zorder=5)


def _marker(point) -> str:
    series = point["series"]
    return looks.series_style(point["backend"], series)[0] if series else looks.marker(point["backend"])


def _side(point) -> tuple[int, int]:
    """Where the label goes first: curves of every second backend have theirs on the left; they lie side by side."""
    curved = looks.curved_backends()
    is_left = point["backend"] in curved and curved.index(point["backend"]) % 2
    return (-1, 0) if is_left else (1, 0)


def _draw_control(axes, point, height: float, times: tuple[float, float]) -> None:
    colour = looks.colour(point["backend"])
    axes.axhline(height, color=colour, linestyle=looks.dash(point["backend"]), linewidth=1.0, zorder=1)
    axes.scatter([times[0]], [height], marker="<", s=50, color=colour, clip_on=False, zorder=5)
    label = looks.backend(point["backend"]).label
    axes.annotate(f"{label}: no collision", (times[1], height), xytext=(-2, 3), textcoords="offset points", fontsize=7,
                  color=colour, ha="right")


def _label_text(point, points: pd.DataFrame, numbers: dict[str, int]) -> str:
    """All of a backend's first curve are named, of the others the coarsest and the finest."""
    if point["configuration"] in numbers:
        return str(numbers[point["configuration"]])
    if point["series"]:
        alike = points.loc[points["series"] == point["series"], "fineness"]
        is_inner = alike.min() < point["fineness"] < alike.max()
        return "" if is_inner and point["series"] not in looks.series_of(point["backend"])[:1] else point["label"]
    return point["configuration"]


def _numbers(points: pd.DataFrame) -> dict[str, int]:
    """Of the configurations of backends that have many choices: their names have no room beside the points."""
    crowded = points["backend"].map(lambda name: looks.backend(name).has_many_choices)
    return {name: number for number, name in enumerate(dict.fromkeys(points.loc[crowded, "configuration"]), 1)}


def _time_limits(points: pd.DataFrame) -> tuple[float, float]:
    times = points.loc[~points["is_control"], ["time_ms", "time_ms_low", "time_ms_high"]]
    return 0.3 * float(times.min().min()), 2.2 * float(times.max().max())


def marker_area(structure_bytes: float) -> float:
    """Points squared; grows by a step a decade of bytes."""
    decades = math.log10(structure_bytes / 1e3) if structure_bytes > 1e3 else 0.0
    return 5.0 + 6.0 * decades


def _draw_key(axes, points: pd.DataFrame, numbers: dict[str, int], left: float) -> None:
    """What signs mean, in a cell of the grid of panels."""
    handles = []
    curves = points[points["series"].notna()]
    backend_of = dict(zip(curves["series"], curves["backend"]))
    for series in style.in_order(backend_of, looks.all_series()):
        shape, dashes = looks.series_style(backend_of[series], series)
        handles.append(Line2D([], [], marker=shape, linestyle=dashes, markersize=5, label=series,
                              color=looks.colour(backend_of[series])))
    for backend in looks.backends_in_order(points.loc[points["series"].isna() & ~points["is_control"], "backend"]):
        handles.append(_dot(looks.marker(backend), looks.colour(backend), looks.backend(backend).label))
    if points["is_wrong"].any():
        handles.append(Line2D([], [], marker="x", linestyle="", markersize=6, color="#333333",
                              label="wrong (caption: why)"))
    handles.append(Line2D([], [], color=FRONT_COLOUR, linewidth=3.2, alpha=0.25, label="Pareto front"))
    handles.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="white", markeredgecolor="black",
                          markeredgewidth=1.3, markersize=6, label="on the front"))
    handles.append(Line2D([], [], marker="|", linestyle="-", markersize=0, color="#333333",
                          label="95 % interval"))
    for count in LEGEND_BYTES:
        handles.append(Line2D([], [], marker="o", linestyle="", color="#999999",
                              markersize=math.sqrt(marker_area(count)), label=f"{_bytes(count)} of structures"))
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(left, 1.06), frameon=False, fontsize=7,
                handlelength=2.2, labelspacing=0.3)
    words = [textwrap.fill(f"{number}  {name}", KEY_LETTERS, subsequent_indent="     ")
             for name, number in numbers.items()]
    if words:
        colours = {looks.colour(name) for name in points.loc[points["configuration"].isin(list(numbers)), "backend"]}
        axes.text(0.56, 1.02, "\n".join(["numbers: configurations", *words]), transform=axes.transAxes, fontsize=7.0,
                  va="top", color=colours.pop() if len(colours) == 1 else "black", linespacing=1.15)


def _dot(shape: str, colour: str, label: str) -> Line2D:
    return Line2D([], [], marker=shape, linestyle="", color=colour, markersize=6, label=label)


def _bytes(count: float) -> str:
    return f"{count / 1e6:g} MB" if count >= 1e6 else f"{count / 1e3:g} kB"
