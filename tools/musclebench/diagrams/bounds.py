"""The quantities that the pages of proofs are about."""

from typing import Any

import numpy as np

from .shapes import ASKED, BONE, FREE, LINE, NOTE, WRONG, Axes, Circle, Polygon, Rectangle, arrow, double_arrow


def surface_depth(axes: Axes) -> None:
    """A ridge in a muscle's triangle: its corners are outside of the bone."""
    corners = np.array([(-1.5, 0.35), (1.6, 0.25), (0.25, 1.5)])
    centre = corners.mean(axis=0)
    axes.add_patch(Polygon([(-1.7, -0.7), (-0.45, -0.45), (0.0, 0.62), (0.45, -0.45), (1.8, -0.7)], facecolor=BONE, edgecolor=LINE))
    axes.add_patch(Polygon(corners, facecolor="none", edgecolor="#A3423A", linewidth=1.2))
    axes.plot(*corners.T, "o", color="#A3423A", markersize=4)
    axes.plot(*centre, "o", color=ASKED, markersize=4)
    arrow(axes, centre, corners[0], ASKED)
    axes.text(-0.55, 0.62, "$r$", fontsize=8, color=ASKED)
    axes.text(centre[0] + 0.07, centre[1] + 0.04, "$c$", fontsize=8, color=ASKED)
    axes.plot(0.0, 0.62, "o", color=WRONG, markersize=5)
    axes.text(0.62, 0.05, "the deepest point is in the face", fontsize=8, color=WRONG)
    axes.plot([0.6, 0.03], [0.08, 0.58], color=WRONG, linewidth=0.7)
    axes.text(-1.65, -0.62, "bone", fontsize=8, color=LINE)
    axes.text(0.45, 1.45, "corners: all outside", fontsize=8, color="#A3423A")
    axes.set(xlim=(-1.8, 2.5), ylim=(-0.75, 1.7))


def signed_field(axes: Axes) -> None:
    """Along a line: the exact distance, the field, and where its side may be wrong."""
    axes.set_aspect("auto")
    x = np.linspace(-1.6, 1.6, 300)
    sigma, at = 0.38, 1.2

    def error(x: Any) -> Any:
        return 0.24 * np.sin(4.2 * x + 2.2) * np.exp(-0.4 * x * x)

    axes.axvspan(-sigma, sigma, color=WRONG, alpha=0.12, linewidth=0)
    axes.axhline(0, color=NOTE, linewidth=0.7)
    axes.plot(x, x, color=LINE, linewidth=1.2)
    axes.plot(x, x + error(x), color=ASKED, linewidth=1.2)
    axes.text(-1.6, 1.25, "exact distance $d$", fontsize=8, color=LINE)
    axes.text(-1.6, 0.9, "field $f$", fontsize=8, color=ASKED)
    double_arrow(axes, (-sigma, -1.35), (sigma, -1.35), WRONG)
    axes.text(sigma + 0.05, -1.4, "within $\\sigma$ of the surface $f$ may have the wrong sign", fontsize=8, color=WRONG)
    double_arrow(axes, (at, at), (at, at + error(at)), NOTE)
    axes.text(at + 0.08, at - 0.18, "excess, at most $x$", fontsize=8, color=NOTE)
    axes.text(2.95, -0.2, "surface of the bone at 0", fontsize=8, color=NOTE, ha="right")
    axes.set(xlim=(-1.7, 3.0), ylim=(-1.6, 1.6))


def winding(axes: Axes) -> None:
    """A bone with a hole: how far a point may move before its side could change."""
    angles = np.linspace(np.radians(118), np.radians(422), 120)
    rim = np.column_stack([1.35 * np.cos(angles), np.sin(angles)])
    axes.add_patch(Polygon(rim, facecolor=BONE, edgecolor="none"))
    axes.plot(*rim.T, color=LINE, linewidth=1.4)
    for end in (rim[0], rim[-1]):
        axes.plot(*end, "o", color=WRONG, markersize=5)
    point = np.array([-0.1, 0.1])
    nearest = rim[0]
    arrow(axes, point, nearest, NOTE)
    axes.text(-0.56, 0.47, "$d$", fontsize=8, color=NOTE)
    axes.add_patch(Circle(point, 0.3, facecolor=FREE, edgecolor=FREE, alpha=0.25))
    axes.plot(*point, "o", color=FREE, markersize=4)
    axes.text(point[0] + 0.36, point[1] - 0.06, "within $s$ the side stays", fontsize=8, color=FREE)
    axes.text(0.85, 0.98, "edges of the hole", fontsize=8, color=WRONG)
    axes.text(-0.5, -0.7, "inside: $w > 0.5$", fontsize=8, color=LINE)
    axes.text(1.5, -0.7, "outside: $w < 0.5$", fontsize=8, color=LINE)
    axes.set(xlim=(-1.45, 2.7), ylim=(-1.1, 1.2))


def triangle_frame(axes: Axes) -> None:
    """A triangle as a leaf of the tree stores it, and a point in its frame."""
    left, right, top, foot = np.array([-1.2, 0.0]), np.array([1.5, 0.0]), np.array([0.2, 1.1]), np.array([0.2, 0.0])
    axes.add_patch(Polygon([left, right, top], facecolor=BONE, edgecolor=LINE, linewidth=1.2))
    axes.plot([foot[0], top[0]], [foot[1], top[1]], ":", color=LINE)
    axes.add_patch(Rectangle(foot, 0.1, 0.1, fill=False, edgecolor=LINE, linewidth=0.7))
    for start, end, words, at in ((left, foot, "before", (-0.5, -0.33)), (foot, right, "after", (0.85, -0.33))):
        double_arrow(axes, start - [0, 0.12], end - [0, 0.12], NOTE)
        axes.text(*at, words, ha="center", fontsize=8, color=NOTE)
    axes.text(0.1, 0.5, "height", fontsize=8, color=NOTE, ha="right")
    arrow(axes, foot, foot + [0.6, 0], ASKED)
    arrow(axes, foot, foot + [0, 0.6], ASKED)
    axes.text(0.62, 0.06, "along", fontsize=8, color=ASKED)
    axes.text(0.26, 0.62, "up", fontsize=8, color=ASKED)
    axes.plot(*foot, "o", color=ASKED, markersize=4)
    axes.text(foot[0] - 0.07, 0.06, "$o$", fontsize=8, color=ASKED, ha="right")
    point = np.array([1.75, 1.15])
    axes.plot(*point, "o", color=FREE, markersize=5)
    axes.text(point[0] + 0.08, point[1], "query point $(X, Y, Z)$,\nas seen from $o$", fontsize=8, color=FREE, va="center")
    arrow(axes, foot, point, FREE)
    axes.set(xlim=(-1.4, 3.5), ylim=(-0.45, 1.35))
