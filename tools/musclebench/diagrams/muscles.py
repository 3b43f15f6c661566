"""How muscles touch each other."""

import numpy as np

from .shapes import ASKED, BONE, FREE, LINE, Axes, Polygon, Rectangle, arrow


def moving_tree(axes: Axes) -> None:
    """Boxes of the last refit, the surface as it is now, and the distance that a search adds."""
    x = np.linspace(-1.5, 1.5, 13)
    then = np.column_stack([x, 0.28 * np.sin(2.1 * x)])
    now = np.column_stack([x + 0.05, 0.28 * np.sin(2.1 * x + 0.1) + 0.14])
    margin = np.linalg.norm(now - then, axis=1).max()
    for first in range(0, 12, 3):
        low, high = then[first:first + 4].min(axis=0), then[first:first + 4].max(axis=0)
        axes.add_patch(Rectangle(low, *(high - low), facecolor=ASKED, alpha=0.25, edgecolor=ASKED))
        axes.add_patch(Rectangle(low - margin, *(high - low + 2 * margin), fill=False, linestyle=":", edgecolor=ASKED))
    axes.plot(*then.T, "--", color="#999999", linewidth=1)
    axes.plot(*now.T, "-", color=LINE, linewidth=1.4, marker="|", markersize=4)
    query = np.array([0.25, 1.05])
    axes.plot(*query, "o", color=ASKED, markersize=5)
    arrow(axes, query, now[np.argmin(np.linalg.norm(now - query, axis=1))], ASKED)
    axes.text(-1.65, 1.25, "distances: to the surface as it is", fontsize=8, color=LINE)
    axes.text(-1.65, -0.85, "boxes: of the last refit, looked at as if", fontsize=8, color=ASKED)
    axes.text(-1.65, -1.07, "grown by the largest displacement since", fontsize=8, color=ASKED)
    axes.set(xlim=(-1.75, 1.75), ylim=(-1.3, 1.45), title="a tree between two refits")


def both_sides(axes: Axes) -> None:
    """A node below a face of the other muscle: all move, each by its weight."""
    corners = np.array([(-1.5, -0.05), (-0.75, 0.12), (0.55, 0.12), (1.4, -0.1)])
    node, weight = np.array([0.1, -0.3]), (0.1 + 0.75) / 1.3
    other = np.array([(-1.3, 1.0), (-0.6, 0.35), node, (0.75, 0.45), (1.35, 1.0)])
    axes.add_patch(Polygon([*corners, (1.4, -0.8), (-1.5, -0.8)], facecolor=BONE, linewidth=0))
    axes.plot(*corners.T, "-o", color=LINE, linewidth=1.4, markersize=3)
    axes.plot(*other.T, "-o", color=FREE, linewidth=1.4, markersize=3)
    axes.plot(*node, "o", color=ASKED, markersize=6, zorder=3)
    arrow(axes, node, node + [0, 0.3], ASKED)
    for corner, share, name in ((corners[1], 1 - weight, "$q_1$"), (corners[2], weight, "$q_2$")):
        arrow(axes, corner, corner - [0, 0.55 * share], ASKED)
        axes.text(corner[0] + (0.15 if corner[0] > 0 else 0), corner[1] + 0.07, name, fontsize=8, ha="center")
    axes.text(node[0] + 0.09, node[1] - 0.13, "$p$", fontsize=8)
    axes.text(-1.55, 1.25, "one muscle", fontsize=8, color=FREE)
    axes.text(-1.4, -0.68, "the other", fontsize=8, color=LINE)
    axes.text(-1.55, -1.0, "the node moves out, the corners give way,", fontsize=8, color=ASKED)
    axes.text(-1.55, -1.22, "each by its inverse mass and weight", fontsize=8, color=ASKED)
    axes.set(xlim=(-1.75, 1.75), ylim=(-1.3, 1.45), title="correction of both sides")
