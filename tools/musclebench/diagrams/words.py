"""The words of the glossary, each beside what it names."""

from typing import Any

import numpy as np

from .shapes import ASKED, BONE, FREE, LINE, NOTE, WRONG, Axes, Circle, Polygon, arrow, double_arrow, outline

BOUND_NODES = 2  # at each end of the drawn muscle
SKIN = 0.22


def simulated(axes: Axes) -> None:
    """A muscle over a joint, from one bone to another."""
    outline(axes)
    axes.add_patch(Polygon([(1.25, -1.45), (1.25, -0.75), (1.5, -0.55), (1.75, -0.75), (1.75, -1.45)], facecolor=BONE, edgecolor=LINE,
                           linewidth=1.2))
    middle = np.array([(-0.95, 0.36), (-0.45, 0.62), (0.1, 0.86), (0.7, 0.97), (1.25, 0.83), (1.55, 0.4), (1.62, -0.1), (1.57, -0.62)])
    along = np.gradient(middle, axis=0)
    across = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    thick = 0.17 * np.sin(np.linspace(0.3, np.pi - 0.3, len(middle)))[:, None]
    outer, inner = middle + thick * across, middle - thick * across
    axes.add_patch(Polygon([*outer, *inner[::-1]], facecolor="#E7A6A0", edgecolor="#A3423A", linewidth=0.8, alpha=0.7))
    axes.plot(*middle.T, color="#A3423A", linewidth=0.8, linestyle="--")
    free, bound = slice(BOUND_NODES, -BOUND_NODES), [*range(BOUND_NODES), *range(-BOUND_NODES, 0)]
    for side in (outer, inner):
        axes.plot(*side[free].T, "o", color=ASKED, markersize=3)
        axes.plot(*side[bound].T, "s", color=FREE, markersize=3.5)
    axes.text(-1.0, -0.12, "bone", fontsize=8, color=LINE)
    axes.text(1.85, -1.2, "bone", fontsize=8, color=LINE)
    axes.text(-1.05, 0.72, "attachment", fontsize=8, color=FREE, ha="center")
    axes.text(0.15, 1.2, "node", fontsize=8, color=ASKED, ha="center")
    axes.text(1.85, 0.3, "fibre\n(dashed)", fontsize=8, color="#A3423A")
    axes.set(xlim=(-1.6, 2.4), ylim=(-1.5, 1.97), title="what is simulated")


def surface(x: Any) -> Any:
    return 0.16 * np.sin(1.6 * x)


def bone_below(axes: Axes, highest: float) -> Any:
    x = np.linspace(-1.7, 1.7, 200)
    axes.fill_between(x, surface(x), -1.15, color=BONE, linewidth=0)
    axes.plot(x, surface(x), color=LINE, linewidth=1.2)
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.2, highest))
    return x


def closest(point: Any) -> Any:
    x = np.linspace(-1.7, 1.7, 2000)
    points = np.column_stack([x, surface(x)])
    return points[np.argmin(np.linalg.norm(points - point, axis=1))]


def contact(axes: Axes) -> None:
    x = bone_below(axes, 1.75)
    slope = np.gradient(surface(x), x)
    axes.plot(x - SKIN * slope / np.hypot(1, slope), surface(x) + SKIN / np.hypot(1, slope), ":", color=NOTE, linewidth=1)
    free, inside = np.array([-0.85, 0.75]), np.array([0.75, -0.4])
    foot = closest(free)
    axes.add_patch(Circle(free, np.linalg.norm(free - foot), facecolor=FREE, edgecolor=FREE, alpha=0.15))
    axes.plot(*free, "o", color=FREE, markersize=5)
    arrow(axes, free, foot, FREE)
    axes.text(free[0] - 0.75, 1.55, "clearance: no bone in here", fontsize=8, color=FREE)
    axes.text(free[0] + 0.08, 0.62, "signed distance\nabove 0", fontsize=8, color=FREE, va="center")
    out = closest(inside)
    normal = (out - inside) / np.linalg.norm(out - inside)
    axes.plot(*inside, "o", color=WRONG, markersize=5)
    axes.plot(*out, "o", color=ASKED, markersize=4, zorder=3)
    axes.plot(*np.array([inside, out]).T, color=WRONG, linewidth=1.2)
    arrow(axes, out, out + 0.55 * normal, ASKED)
    axes.text(inside[0] + 0.1, inside[1] - 0.08, "depth: signed\ndistance below 0", fontsize=8, color=WRONG, va="top", ha="center")
    axes.text(out[0] + 0.03, out[1] + 0.5, "normal", fontsize=8, color=ASKED)
    axes.text(out[0] + 0.08, out[1] + 0.04, "closest point", fontsize=8, color=ASKED, va="bottom")
    axes.text(1.68, 1.3, "margin\n(dotted)", fontsize=8, color=NOTE, ha="right")
    axes.text(-1.6, -1.05, "inside the bone", fontsize=8, color=LINE)
    axes.set_title("contact of a node")


def judged(axes: Axes) -> None:
    x = bone_below(axes, 1.75)
    said = surface(x) + 0.3 * np.sin(3.1 * x + 0.4)
    axes.plot(x, said, "--", color=ASKED, linewidth=1.2)
    missed, false = np.array([-0.75, -0.29]), np.array([0.42, 0.25])
    axes.plot(*missed, "o", color=WRONG, markersize=5)
    axes.plot(*false, "o", color=WRONG, markersize=5)
    axes.text(missed[0], -0.52, "missed contact", fontsize=8, color=WRONG, va="top", ha="center")
    axes.text(false[0], 0.5, "false contact", fontsize=8, color=WRONG, ha="center")
    at = 1.33
    double_arrow(axes, (at, surface(at)), (at, surface(at) + 0.3 * np.sin(3.1 * at + 0.4)), NOTE)
    axes.text(at - 0.25, -0.42, "surface offset", fontsize=8, color=NOTE, ha="center")
    axes.text(-1.6, 1.5, "backend's surface (dashed)", fontsize=8, color=ASKED)
    axes.text(-1.6, 1.2, "true surface, by the Referee", fontsize=8, color=LINE)
    axes.set_title("error of a backend")
