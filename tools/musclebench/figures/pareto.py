"""The Pareto picture: collision time a frame against error, both log, one panel a muscle and one for all."""

import math
import textwrap
from collections.abc import Callable
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
BAND_SHARE = 0.16  # of the axis' height, below its break, for what is exact
MOST_LABELS = 8  # of a panel; the page names every point
LEGEND_BYTES = (1e4, 1e6, 1e8)
FRONT_COLOUR = "#555555"
WRONG_GROWS = 1.3  # the cross beyond its marker
EXACT_LETTERS = 6  # in a line of the words at the axis
CONTROL_AREA = 50.0
STROKE_POINTS = 7.0
UNKNOWN_BELOW_EDGE = 1.5
BREAK_POINTS = 4.0  # between the strokes that break the axis


@dataclass
class Axis:
    """The range of errors that all panels share."""

    low_mm: float  # end of the log axis, a power of ten
    bottom_mm: float  # end of the band of what is exact, below it; `low_mm` where nothing is
    high_mm: float
    exact_below_mm: float = EXACT_MM

    @property
    def has_band(self) -> bool:
        return self.bottom_mm < self.low_mm

    @property
    def exact_mm(self) -> float:
        """The one height of all that is exact."""
        return math.sqrt(self.low_mm * self.bottom_mm)

    def height(self, error_mm: float) -> float:
        """Of an error that isn't known (infinite) the upper edge."""
        if error_mm < self.exact_below_mm:
            return self.exact_mm
        return min(error_mm, self.high_mm / UNKNOWN_BELOW_EDGE)


def chosen_labels(points: pd.DataFrame) -> list:
    """Index of the points that have a name beside them: of each backend in turn its default, its best, its ends."""
    picks = [_picks(points[points["backend"] == backend]) for backend in looks.backends_in_order(points["backend"])]
    return [mine[turn] for turn in range(max(map(len, picks), default=0)) for mine in picks if turn < len(mine)]


def _picks(points: pd.DataFrame) -> list:
    right = points[~points["is_wrong"]]
    front = points[points["on_front"]].sort_values("error_mm")
    curve = points[points["series"].isin(looks.series_of(points["backend"].iloc[0])[:1])].sort_values("fineness")
    fastest = right[right["series"].isna()].sort_values("time_ms")
    found = [*points.index[points["is_default"]], *front.index[:1], *fastest.index[:1], *curve.index[-1:], *curve.index[:1]]
    return list(dict.fromkeys(found)) or list(points.index[:1])


@dataclass
class Emphasis:
    """What a picture calls exact, and which points it names."""

    nothing: str  # what an error below `exact_mm` is called
    exact_mm: float = EXACT_MM
    has_intervals: bool = True  # of times
    names_curves: bool = True  # in the key, where a backend has several; else backends alone
    named: Callable[[pd.DataFrame], list] = chosen_labels  # index of points, those that matter most first


def draw_pareto(points: pd.DataFrame, stem: Path, title: str, error_title: str, emphasis: Emphasis) -> list[Path]:
    """PNG, SVG, PDF and CSV; nothing without points."""
    if points.empty or points["is_control"].all():
        return []
    style.apply_style()
    panels = list(dict.fromkeys(points["panel"]))
    columns = min(COLUMNS, len(panels) + 1)
    rows = math.ceil((len(panels) + 1) / columns)
    shares = [1.0, 0.6] if len(panels) == 1 else [1.0] * columns
    figure, cells = plt.subplots(rows, columns, figsize=(style.PAGE_INCHES, PANEL_HEIGHT_INCHES * rows), squeeze=False,
                                 width_ratios=shares)
    cells = list(cells.flat)
    axis = error_axis(points["error_mm"], emphasis.exact_mm)
    for cell, panel in zip(cells, panels):
        cell.set(xlabel="collision time a frame (ms)", ylabel=error_title)
        cell.set_title(panel_title(panel, panels), loc="left")
        _scale(cell, points[points["panel"] == panel], axis, emphasis.nothing)
    for cell in cells[len(panels):]:
        cell.axis("off")
    figure.suptitle(title, x=0.01, ha="left")
    # Labels are laid out in pixels: the panels must have their final size before.
    figure.tight_layout(rect=(0, 0, 1, 0.99), w_pad=1.0, h_pad=1.0)
    for cell, panel in zip(cells, panels):
        _draw_panel(cell, points[points["panel"] == panel], axis, emphasis)
    _draw_key(cells[len(panels)], points, emphasis)
    table = stem.with_suffix(".csv")
    points.replace(math.inf, math.nan).to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def panel_title(panel: str, panels: list[str]) -> str:
    if panel == ALL_MUSCLES:
        return "all muscles: sum of times, largest error"
    data_sets = {name.split("/")[0] for name in panels if name != ALL_MUSCLES}
    data_set, muscle = panel.split("/")[0], style.muscle_label(panel.split("/")[-1])
    return f"{muscle} ({data_set})" if len(data_sets) > 1 else muscle


def error_axis(errors_mm: pd.Series, exact_mm: float = EXACT_MM) -> Axis:
    """Of the errors that are not exact, whole powers of ten; without any such errors from 0.001 to 1 mm."""
    measured = errors_mm[(errors_mm >= exact_mm) & np.isfinite(errors_mm)]
    low, high = (measured.min(), measured.max()) if len(measured) else (1e-3, 1.0)
    low = 10.0 ** math.floor(math.log10(low) - 1e-9)
    high = max(high * 2.5, low * 10)
    band = BAND_SHARE if (errors_mm < exact_mm).any() else 0.0
    decades = math.log10(high / low) * band / (1 - band)
    return Axis(low, low / 10**decades, high, exact_mm)


def _scale(axes, points: pd.DataFrame, axis: Axis, nothing: str) -> None:
    """Limits and ticks, which say how much room the panel has."""
    axes.set(xscale="log", yscale="log", xlim=_time_limits(points), ylim=(axis.bottom_mm, axis.high_mm))
    decades = np.arange(round(math.log10(axis.low_mm)), math.floor(math.log10(axis.high_mm)) + 1)
    ticks = {10.0**decade: f"{10.0**decade:g}" for decade in decades}
    if axis.has_band:
        ticks[axis.exact_mm] = textwrap.fill(nothing, EXACT_LETTERS)
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_yticks([], minor=True)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}".replace(",", "\u2009")))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _draw_panel(axes, points: pd.DataFrame, axis: Axis, emphasis: Emphasis) -> None:
    points = points.sort_values("time_ms").reset_index(drop=True)
    heights = points["error_mm"].map(axis.height)
    marks = _mark_exact(axes, axis) if axis.has_band else []
    _draw_front(axes, points, axis)
    for series, curve in points[points["series"].notna()].groupby("series", sort=False):
        curve = curve.sort_values("fineness")
        backend = curve["backend"].iloc[0]
        _, dashes = looks.series_style(backend, series)
        axes.plot(curve["time_ms"], heights[curve.index], linestyle=dashes, linewidth=0.8, zorder=2,
                  color=looks.colour(backend))
    levels = [axis.low_mm, axis.exact_mm] if axis.has_band else []
    for index, point in points.iterrows():
        if point["is_control"]:
            marks += _draw_control(axes, point, heights[index])
            levels.append(heights[index])
        else:
            _draw_point(axes, point, heights[index], emphasis)
    shown = points[~points["is_control"]]
    named = emphasis.named(shown)[:MOST_LABELS]
    labels = marks + [_label(shown.loc[index], heights[index], index in named, emphasis) for index in
              [*named, *(index for index in shown.index if index not in named)]]
    place_labels(axes, labels, style.SMALLEST_POINTS, levels)


def _label(point, height: float, is_named: bool, emphasis: Emphasis) -> Label:
    radius = math.sqrt(marker_area(point["structure_bytes"])) / 2 * (WRONG_GROWS if point["is_wrong"] else 1)
    return Label(point["time_ms"], height, point["spoken"] if is_named else "", looks.colour(point["backend"]), radius,
                 _side(point), (point["time_ms_low"], point["time_ms_high"]) if emphasis.has_intervals else None)


def _mark_exact(axes, axis: Axis) -> list[Label]:
    """A band under a broken axis; the room that the strokes of the break take."""
    axes.axhspan(axis.bottom_mm, axis.low_mm, facecolor="#eef2f5", edgecolor="none", zorder=0)
    axes.axhline(axis.low_mm, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
    (left, _), step = axes.get_xlim(), BREAK_POINTS * axes.figure.dpi / 72
    start = axes.transData.transform((left, axis.low_mm))
    ends = [axes.transData.inverted().transform(start - (0, down * step))[1] for down in (1, 2)]
    axes.plot([left, left], ends, color="white", linewidth=2.5, clip_on=False, zorder=7,
              solid_capstyle="butt")
    axes.plot([left, left], ends, linestyle="none", marker=[(-1, -0.5), (1, 0.5)], markersize=STROKE_POINTS, color="black",
              markeredgewidth=0.7, clip_on=False, zorder=8)
    return [Label(left, end, "", "black", STROKE_POINTS / 2) for end in ends]


def _draw_front(axes, points: pd.DataFrame, axis: Axis) -> None:
    front = points[points["on_front"]].sort_values("time_ms")
    if front.empty:
        return
    heights = [max(axis.height(error), axis.low_mm) if error >= axis.exact_below_mm else axis.exact_mm for error in front["error_mm"]]
    axes.step(front["time_ms"], heights, where="post", color=FRONT_COLOUR, linewidth=2.6, alpha=0.25, zorder=1.2,
              solid_joinstyle="miter")


def _draw_point(axes, point, height: float, emphasis: Emphasis) -> None:
    colour, area = looks.colour(point["backend"]), marker_area(point["structure_bytes"])
    if emphasis.has_intervals:
        axes.plot([point["time_ms_low"], point["time_ms_high"]], [height, height], color=colour, linewidth=1.0, alpha=0.8,
                  zorder=3, solid_capstyle="butt")
    shape = _marker(point)
    wrong, hollow = point["is_wrong"], point["is_substitute"]
    edge = "black" if point["on_front"] else colour if wrong or hollow else "white"
    axes.scatter([point["time_ms"]], [height], s=area, marker=shape, facecolor="none" if wrong else "white" if hollow else colour,
                 edgecolor=edge, linewidth=0.9 if point["on_front"] else 0.4, zorder=5 if point["on_front"] else 4)
    if wrong:
        axes.scatter([point["time_ms"]], [height], s=WRONG_GROWS**2 * area, marker="x", color=colour, linewidth=0.7, zorder=5)


def _marker(point) -> str:
    series = point["series"]
    return looks.series_style(point["backend"], series)[0] if series else looks.marker(point["backend"])


def _side(point) -> tuple[int, int]:
    """Where the label goes first: curves of every second backend have theirs on the left; they lie side by side."""
    curved = looks.curved_backends()
    is_left = point["backend"] in curved and curved.index(point["backend"]) % 2
    return (-1, 0) if is_left else (1, 0)


def _draw_control(axes, point, height: float) -> list[Label]:
    """The name of its line, and the room that its mark takes."""
    colour = looks.colour(point["backend"])
    left, right = axes.get_xlim()
    axes.axhline(height, color=colour, linestyle=looks.dash(point["backend"]), linewidth=1.0, zorder=1)
    axes.scatter([left], [height], marker="<", s=CONTROL_AREA, color=colour, clip_on=False, zorder=5)
    return [Label(right, height, looks.title(point["backend"]), colour, 0.0, (-1, 1)),
            Label(left, height, "", colour, math.sqrt(CONTROL_AREA) / 2)]


def _time_limits(points: pd.DataFrame) -> tuple[float, float]:
    times = points.loc[~points["is_control"], ["time_ms", "time_ms_low", "time_ms_high"]]
    return 0.3 * float(times.min().min()), 2.2 * float(times.max().max())


def marker_area(structure_bytes: float) -> float:
    """Points squared; grows by a step a decade of bytes."""
    decades = math.log10(structure_bytes / 1e3) if structure_bytes > 1e3 else 0.0
    return 5.0 + 6.0 * decades


def _draw_key(axes, points: pd.DataFrame, emphasis: Emphasis) -> None:
    """What signs mean, in a cell of the grid of panels."""
    handles = []
    curves = points[points["series"].notna()]
    backend_of = dict(zip(curves["series"], curves["backend"]))
    for series in style.in_order(backend_of, looks.all_series()):
        backend = backend_of[series]
        shape, dashes = looks.series_style(backend, series)
        label = looks.series_title(backend, series) if emphasis.names_curves else looks.title_and_name(backend)
        handles.append(Line2D([], [], marker=shape, linestyle=dashes, markersize=5, label=label, color=looks.colour(backend)))
    for backend in looks.backends_in_order(points.loc[points["series"].isna() & ~points["is_control"], "backend"]):
        handles.append(_dot(looks.marker(backend), looks.colour(backend), looks.title_and_name(backend)))
    if points["is_wrong"].any():
        handles.append(Line2D([], [], marker="x", linestyle="", markersize=6, color="#333333",
                              label="wrong (caption: why)"))
    if points["is_substitute"].any():
        handles.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="white", markeredgecolor="#333333", markersize=6,
                              label="can't be asked about points"))
    handles.append(Line2D([], [], color=FRONT_COLOUR, linewidth=3.2, alpha=0.25, label="Pareto front"))
    handles.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="white", markeredgecolor="black",
                          markeredgewidth=1.3, markersize=6, label="on the front"))
    if emphasis.has_intervals:
        handles.append(Line2D([], [], marker="|", linestyle="-", markersize=0, color="#333333", label="95 % interval"))
    for count in LEGEND_BYTES:
        handles.append(Line2D([], [], marker="o", linestyle="", color="#999999",
                              markersize=math.sqrt(marker_area(count)), label=f"{_bytes(count)} of structures"))
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, 1.06), frameon=False, fontsize=7,
                handlelength=2.2, labelspacing=0.3)


def _dot(shape: str, colour: str, label: str) -> Line2D:
    return Line2D([], [], marker=shape, linestyle="", color=colour, markersize=6, label=label)


def _bytes(count: float) -> str:
    return f"{count / 1e6:g} MB" if count >= 1e6 else f"{count / 1e3:g} kB"
