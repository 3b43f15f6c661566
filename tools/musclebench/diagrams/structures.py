"""How the tree, the cache and the fields answer a query."""

import numpy as np

from .shapes import ASKED, BONE, FREE, LINE, NOTE, Axes, Circle, Polygon, Rectangle, arrow, bone_distance, outline

FIELD_LEVELS = 5


def triangle_bvh(axes: Axes) -> None:
    points = np.array([(x, 0.35 * np.sin(1.4 * x)) for x in np.linspace(-2.4, 2.4, 25)])
    axes.plot(*points.T, "-", color=LINE, linewidth=1.2, marker="|", markersize=4)
    query = np.array([-0.35, 1.25])
    dense = np.array([(x, 0.35 * np.sin(1.4 * x)) for x in np.linspace(-2.4, 2.4, 500)])
    closest = dense[np.argmin(np.linalg.norm(dense - query, axis=1))]
    radius = np.linalg.norm(closest - query)
    for first in range(0, 24, 3):
        part = points[first:first + 4]
        middle, along = part.mean(axis=0), part[-1] - part[0]
        angle, length = np.degrees(np.arctan2(along[1], along[0])), np.linalg.norm(along)
        near = np.min(np.linalg.norm(part - query, axis=1)) <= radius * 1.12
        box = Rectangle(middle - [length / 2, 0.11], length, 0.22, angle=angle, rotation_point="center", fill=True,
                        facecolor=ASKED if near else "#dddddd", alpha=0.35, edgecolor=ASKED if near else "#999999")
        axes.add_patch(box)
    axes.add_patch(Circle(query, radius, fill=False, linestyle="--", color=ASKED))
    axes.plot(*query, "o", color=ASKED, markersize=5)
    arrow(axes, query, closest, ASKED)
    axes.text(query[0] - 0.08, query[1] + 0.1, "query", fontsize=8, ha="right")
    axes.text(2.5, -0.75, "pruned: farther than the closest so far", fontsize=8, ha="right", color=NOTE)
    axes.set(xlim=(-2.7, 2.7), ylim=(-0.95, 2.9))


def safe_sphere(axes: Axes) -> None:
    outline(axes)
    node = np.array([-0.6, 0.95])
    axes.add_patch(Circle(node, 0.62, fill=True, facecolor=FREE, alpha=0.18, edgecolor=FREE))
    path = np.array([node, node + [0.2, -0.1], node + [0.33, -0.28], node + [0.52, -0.3]])
    axes.plot(*path.T, "-o", color=FREE, markersize=3, linewidth=1)
    axes.plot(*(path[-1] + [0.16, -0.08]), "o", color=ASKED, markersize=5)
    axes.text(-1.65, 1.7, "free without a query", fontsize=8, color=FREE)
    axes.text(0.2, 0.78, "asked again", fontsize=8, color=ASKED)
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="safe sphere")


def candidate_list(axes: Axes) -> None:
    outline(axes)
    node = np.array([-0.35, 0.3])
    axes.add_patch(Circle(node, 0.32, fill=False, linestyle="--", color=ASKED))
    for x in np.linspace(-0.85, 0.15, 4):
        axes.add_patch(Rectangle((x, 0.1 + 0.1 * np.sin(2 * x)), 0.26, 0.22, color=ASKED, alpha=0.35))
    axes.plot(*node, "o", color=ASKED, markersize=5)
    axes.text(-1.65, 1.7, "listed leaves answer", fontsize=8, color=ASKED)
    axes.text(-1.65, 1.4, "while the node stays within reach", fontsize=8, color=NOTE)
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="candidate list")


def order_of_questions(axes: Axes) -> None:
    steps = ["safe sphere", "candidate list", "clearance grid", "search of the BVH"]
    for row, words in enumerate(steps):
        axes.add_patch(Rectangle((-1.2, 1.2 - 0.72 * row), 2.4, 0.42, facecolor=FREE if row == 0 else ASKED,
                                 alpha=0.15 + 0.12 * row, edgecolor="none"))
        axes.text(0, 1.41 - 0.72 * row, words, ha="center", va="center", fontsize=8)
        if row:
            arrow(axes, (0, 1.19 - 0.72 * (row - 1)), (0, 1.63 - 0.72 * row))
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="from cheap to dear")


def distance_field(axes: Axes) -> None:
    step = 0.25
    for x in np.arange(-1.6, 1.6, step):
        for y in np.arange(-1.0, 1.0, step):
            near = np.array([bone_distance(x + dx, y + dy) for dx in (0, step) for dy in (0, step)])
            colour = ASKED if near.min() < 0 < near.max() else BONE if near.max() <= 0 else "white"
            alpha = 0.35 if colour == ASKED else 1.0
            axes.add_patch(Rectangle((x, y), step, step, facecolor=colour, alpha=alpha, edgecolor="#bbbbbb",
                                     linewidth=0.5))
    x, y = np.meshgrid(np.linspace(-1.6, 1.6, 160), np.linspace(-1.0, 1.0, 110))
    axes.contour(x, y, bone_distance(x, y), levels=[0], colors=[LINE], linewidths=1.2)
    cell = np.array([2.2, -0.55])
    axes.add_patch(Rectangle(cell, 1.1, 1.1, fill=False, edgecolor=ASKED, linewidth=1.2))
    nodes = [(i / 3, j) for i in range(4) for j in (0, 1)] + [(j, i / 3) for i in (1, 2) for j in (0, 1)]
    axes.plot(*(cell + 1.1 * np.array(nodes)).T, "o", color=ASKED, markersize=4)
    axes.text(2.2, 0.68, "a cell: corners and\ntwo nodes on each edge", fontsize=8)
    axes.text(-1.6, -1.28, "white: never negative, one bit says so", fontsize=8, color=NOTE)
    axes.set(xlim=(-1.7, 3.9), ylim=(-1.35, 1.15))


def adaptive_field(axes: Axes) -> None:
    def divide(x: float, y: float, size: float, level: int) -> None:
        middle = abs(bone_distance(x + size / 2, y + size / 2))
        if level < FIELD_LEVELS and middle < 0.75 * size:
            for dx in (0, size / 2):
                for dy in (0, size / 2):
                    divide(x + dx, y + dy, size / 2, level + 1)
            return
        axes.add_patch(Rectangle((x, y), size, size, fill=False, edgecolor="#9bb8cc", linewidth=0.6))

    divide(-1.7, -1.7, 3.4, 0)
    outline(axes)
    axes.set(xlim=(-1.75, 1.75), ylim=(-1.3, 1.3))


def batched_points(axes: Axes) -> None:
    """A block of nodes, the list of leaves that they share, and what single nodes look at."""
    axes.add_patch(Polygon([(-1.5, -0.6), (1.6, -0.6), (1.6, 0.05), (0.6, 0.3), (-0.4, 0.15), (-1.5, 0.35)],
                           facecolor=BONE, edgecolor=LINE))
    for x in np.linspace(-0.5, 0.5, 5):
        for y in np.linspace(0.65, 1.4, 4):
            axes.plot(x, y, "o", color=ASKED, markersize=3)
    axes.add_patch(Rectangle((-0.6, 0.55), 1.2, 0.95, fill=False, linestyle="--", edgecolor=ASKED))
    for x in np.linspace(-1.0, 0.9, 8):
        axes.add_patch(Rectangle((x, 0.02), 0.2, 0.26, color=ASKED, alpha=0.3))
    arrow(axes, (0, 0.55), (0, 0.3), ASKED)
    axes.text(0.7, 1.2, "nodes of a block share\none walk and one list", fontsize=8)
    axes.text(1.15, 0.4, "listed leaves", fontsize=8, color=ASKED)
    axes.set(xlim=(-1.7, 2.6), ylim=(-0.7, 1.6))
