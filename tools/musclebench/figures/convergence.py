"""Figures of convergence: error against cell size by bone and region; build time and bytes against cells."""

import math
from pathlib import Path

import pandas as pd
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..accuracy.orders import REGIONS, slope
from . import looks, style
from .style import plt

LEGEND_LINE_SHARE = 0.06  # of the panel's height
LEGEND_COLUMNS, LEGEND_LINE_INCHES = 3, 0.16
ROOM_BELOW = 4.0  # of the axis, for fitted orders
ORDER_LINE_SHARE = 0.055  # of the panel's height
PLAIN = FuncFormatter(lambda value, _: f"{value:g}")
THOUSANDS = FuncFormatter(lambda value, _: f"{value / 1000:g}")


def draw_errors(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """One panel a bone and region; a curve a series with its fitted order in the legend."""
    shown = rows[rows["cell_edge_m"].notna() & (rows["p99_error_m"] > 0) & rows["region"].isin(REGIONS)]
    if shown.empty:
        return []
    style.apply_style()
    bones = list(dict.fromkeys(shown["bone"]))
    figure, panels = plt.subplots(len(bones), len(REGIONS), figsize=(style.PAGE_INCHES, 2.9 * len(bones)),
                                  squeeze=False, sharex=True, sharey=True)
    for line, bone in enumerate(bones):
        for column, region in enumerate(REGIONS):
            axes = panels[line, column]
            _tell_orders(axes, _draw_curves(axes, shown[(shown["bone"] == bone) & (shown["region"] == region)]))
            axes.set_title(f"{bone}, {region} regions", loc="left")
            axes.xaxis.set_tick_params(labelbottom=True)
            axes.yaxis.set_tick_params(labelleft=True)
        panels[line, 0].set_ylabel("depth error, 99th percentile (mm)")
    for axes in panels[-1]:
        axes.set_xlabel("edge of a cell (mm)")
    title = figure.suptitle("Error against cell size at points about the bones", x=0.01, ha="left", y=1.0, va="top")
    title.set_in_layout(False)  # it stands above the room that is left to the panels
    low, high = panels[0, 0].get_ylim()
    panels[0, 0].set_ylim(low / ROOM_BELOW, high)
    handles = {line.get_label(): line for axes in panels.flat for line in axes.get_lines()}
    legend_inches = LEGEND_LINE_INCHES * math.ceil(len(handles) / LEGEND_COLUMNS) + 0.1
    title_inches, height = 0.25, figure.get_figheight()
    figure.legend(handles.values(), handles.keys(), ncols=LEGEND_COLUMNS, loc="upper left", frameon=False,
                  bbox_to_anchor=(0.0, 1 - title_inches / height), borderaxespad=0)
    figure.tight_layout(rect=(0, 0, 1, 1 - (title_inches + legend_inches) / height), w_pad=1.5, h_pad=1.5)
    title.set_in_layout(True)
    return _save(figure, rows, stem)


def _draw_curves(axes, rows: pd.DataFrame) -> list[tuple[str, str]]:
    """The fitted order of each, in words, and its colour."""
    axes.set(xscale="log", yscale="log")
    orders = []
    for series in style.in_order(rows["series"], looks.all_series()):
        curve = rows[rows["series"] == series]
        order = curve["fitted_order"].iloc[0]
        backend = curve["backend"].iloc[0]
        _draw_curve(axes, 1e3 * curve["cell_edge_m"], 1e3 * curve["p99_error_m"], curve, looks.series_title(backend, series))
        if pd.notna(order):
            curve_name = looks.series_title(backend, series).partition(", ")[2]
            orders.append((f"{curve_name}: {order:.1f}", looks.colour(backend)))
    _draw_guides(axes, rows)
    _plain_ticks(axes)
    return orders


def _tell_orders(axes, orders: list[tuple[str, str]]) -> None:
    """In the lower right corner, which is free: curves rise to the right."""
    if not orders:
        return
    for line, (words, colour) in enumerate([*reversed(orders), ("fitted order", "black")]):
        axes.text(0.99, 0.02 + ORDER_LINE_SHARE * line, words, color=colour, ha="right", va="bottom", transform=axes.transAxes,
                  fontsize=style.SMALLEST_POINTS)


def _draw_curve(axes, x, y, curve: pd.DataFrame, label: str) -> None:
    """A backend's further curves hollow and larger: they may lie upon its first."""
    backend, series = curve["backend"].iloc[0], curve["series"].iloc[0]
    shape, dashes = looks.series_style(backend, series)
    is_first = series in looks.series_of(backend)[:1]
    axes.plot(x, y, linestyle=dashes, marker=shape, markersize=3.5 if is_first else 5.5, label=label,
              markerfacecolor=None if is_first else "none", color=looks.colour(backend))


def _draw_guides(axes, rows: pd.DataFrame) -> None:
    """Slopes 1 and 2 through the middle of the curves' coarse ends."""
    if rows.empty:
        return
    right, left = 1e3 * rows["cell_edge_m"].max(), 1e3 * rows["cell_edge_m"].min()
    top = 1e3 * rows.loc[rows["cell_edge_m"].idxmax(), "p99_error_m"]
    for order, dashes in ((1, (0, (1, 2))), (2, (0, (5, 3)))):
        axes.plot([left, right], [top * (left / right) ** order, top], color="#aaaaaa", linewidth=0.9, linestyle=dashes,
                  zorder=1, label=f"slope {order}")


def draw_costs(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """Build time and bytes against the number of cells, each with its slope."""
    if rows.empty:
        return []
    style.apply_style()
    figure, panels = plt.subplots(1, 2, figsize=(style.PAGE_INCHES, 3.1))
    for axes, key, title, unit in ((panels[0], "build_s", "build time (s)", 1.0),
                                   (panels[1], "structure_bytes", "structures (MB)", 1e-6)):
        axes.set(xscale="log", yscale="log", xlabel="cells of all bones (thousands)", ylabel=title)
        for bones, series in _curves(rows):
            curve = rows[(rows["bones"] == bones) & (rows["series"] == series) & rows[key].notna()]
            if curve.empty:
                continue
            fitted = slope(curve["cells"], curve[key])
            known = f", slope {fitted:.2f}" if pd.notna(fitted) else ""
            name = looks.series_title(curve["backend"].iloc[0], series)
            _draw_curve(axes, curve["cells"], unit * curve[key], curve, f"{name}{known}")
        _room_above(axes, len(axes.get_lines()))
        axes.xaxis.set_major_formatter(THOUSANDS)
        axes.yaxis.set_major_formatter(PLAIN)
        for one in (axes.xaxis, axes.yaxis):
            one.set_minor_formatter(NullFormatter())
        axes.legend(loc="upper left", fontsize=7, framealpha=0.85, edgecolor="none")
    figure.suptitle("What resolution costs before the first frame", x=0.01, ha="left")
    figure.tight_layout(rect=(0, 0, 1, 0.98), w_pad=1.5)
    return _save(figure, rows, stem)


def _curves(rows: pd.DataFrame) -> list[tuple[str, str]]:
    series = style.in_order(rows["series"], looks.all_series())
    return [(bones, name) for bones in dict.fromkeys(rows["bones"]) for name in series]


def _room_above(axes, lines: int) -> None:
    """For a legend of so many lines, on an axis of a decade or more, which shows a number."""
    low, high = axes.get_ylim()
    low, share = min(low, high / 10), 0.05 + LEGEND_LINE_SHARE * lines
    axes.set_ylim(low, high * (high / low) ** (share / (1 - share)))


def _plain_ticks(axes) -> None:
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    for one in (axes.xaxis, axes.yaxis):
        one.set_major_formatter(PLAIN)
        one.set_minor_formatter(NullFormatter())


def _save(figure, rows: pd.DataFrame, stem: Path) -> list[Path]:
    table = stem.with_suffix(".csv")
    rows.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]
