#!/usr/bin/python3
"""Draws the schematic diagrams of reports/performance. They show no measured data."""

import argparse
import sys
from pathlib import Path

from musclebench.program.cli import run_command
from musclebench.program.optional_packages import require

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (the backend must be chosen first)
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle  # noqa: E402

FOLDER = Path(__file__).resolve().parent.parent / "reports" / "performance" / "pictures"
BONE, LINE, ASKED, FREE, NOTE = "#EDE3C7", "#6B5B3A", "#0072B2", "#009E73", "#555555"
SHOWN_COLOURS = (ASKED, FREE, "#D55E00")
FIELD_LEVELS = 5


def bone_distance(x, y):
    """Signed, of a flat shape with a round end: negative inside."""
    shaft = np.maximum(np.abs(y - 0.1 * np.sin(2 * x)) - 0.28, np.maximum(-x - 1.1, x - 0.8))
    head = np.hypot(x - 0.75, y - 0.18) - 0.48
    return np.minimum(shaft, head)


def panel(figure_width: float = 5.0, height: float = 2.8, columns: int = 1):
    figure, axes = plt.subplots(1, columns, figsize=(figure_width, height), squeeze=False)
    for one in axes[0]:
        one.set_aspect("equal")
        one.set_axis_off()
    return figure, axes[0]


def outline(axes, spread: float = 1.7) -> None:
    x, y = np.meshgrid(np.linspace(-spread, spread, 160), np.linspace(-1.1, 1.1, 110))
    axes.contourf(x, y, bone_distance(x, y), levels=[-9, 0], colors=[BONE])
    axes.contour(x, y, bone_distance(x, y), levels=[0], colors=[LINE], linewidths=1.2)


def arrow(axes, start, end, colour=NOTE) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=8, color=colour, linewidth=1))


def triangle_bvh(axes) -> None:
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


def safe_sphere(axes) -> None:
    outline(axes)
    node = np.array([-0.6, 0.95])
    axes.add_patch(Circle(node, 0.62, fill=True, facecolor=FREE, alpha=0.18, edgecolor=FREE))
    path = np.array([node, node + [0.2, -0.1], node + [0.33, -0.28], node + [0.52, -0.3]])
    axes.plot(*path.T, "-o", color=FREE, markersize=3, linewidth=1)
    axes.plot(*(path[-1] + [0.16, -0.08]), "o", color=ASKED, markersize=5)
    axes.text(-1.65, 1.7, "free without a query", fontsize=8, color=FREE)
    axes.text(0.2, 0.78, "asked again", fontsize=8, color=ASKED)
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="safe sphere")


def candidate_list(axes) -> None:
    outline(axes)
    node = np.array([-0.35, 0.3])
    axes.add_patch(Circle(node, 0.32, fill=False, linestyle="--", color=ASKED))
    for x in np.linspace(-0.85, 0.15, 4):
        axes.add_patch(Rectangle((x, 0.1 + 0.1 * np.sin(2 * x)), 0.26, 0.22, color=ASKED, alpha=0.35))
    axes.plot(*node, "o", color=ASKED, markersize=5)
    axes.text(-1.65, 1.7, "listed leaves answer", fontsize=8, color=ASKED)
    axes.text(-1.65, 1.4, "while the node stays within reach", fontsize=8, color=NOTE)
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="candidate list")


def order_of_questions(axes) -> None:
    steps = ["safe sphere", "candidate list", "clearance grid", "search of the BVH"]
    for row, words in enumerate(steps):
        axes.add_patch(Rectangle((-1.2, 1.2 - 0.72 * row), 2.4, 0.42, facecolor=FREE if row == 0 else ASKED,
                                 alpha=0.15 + 0.12 * row, edgecolor="none"))
        axes.text(0, 1.41 - 0.72 * row, words, ha="center", va="center", fontsize=8)
        if row:
            arrow(axes, (0, 1.19 - 0.72 * (row - 1)), (0, 1.63 - 0.72 * row))
    axes.set(xlim=(-1.7, 1.7), ylim=(-1.1, 1.9), title="from cheap to dear")


def distance_field(axes) -> None:
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


def adaptive_field(axes) -> None:
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


def batched_points(axes) -> None:
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


def sheet() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Nodes of a piece of a surface, and of each inner edge its two nodes and the two opposite it."""
    columns, rows = 11, 8
    random = np.random.default_rng(3)
    nodes = np.array([(x + 0.5 * (y % 2), 0.87 * y) for y in range(rows) for x in range(columns)])
    nodes += random.uniform(-0.13, 0.13, nodes.shape)
    triangles = []
    for y in range(rows - 1):
        for x in range(columns - 1):
            a, b, c, d = (columns * (y + j) + x + i for j in (0, 1) for i in (0, 1))
            triangles += [(a, b, d), (a, d, c)] if y % 2 else [(a, b, c), (b, d, c)]
    opposite: dict[tuple[int, int], list[int]] = {}
    for corners in triangles:
        for i in range(3):
            first, second, third = corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]
            opposite.setdefault((min(first, second), max(first, second)), []).append(third)
    return nodes, [(*edge, *others) for edge, others in opposite.items() if len(others) == 2]


def coloured(pairs: list[tuple[int, ...]]) -> list[list[tuple[int, ...]]]:
    """Greedily: in a colour no two pairs of triangles share a node."""
    colours: list[tuple[set[int], list[tuple[int, ...]]]] = []
    for pair in pairs:
        free = next((colour for colour in colours if not colour[0] & set(pair)), None)
        if free is None:
            colours.append(free := (set(), []))
        free[0].update(pair)
        free[1].append(pair)
    return [members for _, members in colours]


def colours_of_edges(axes) -> None:
    nodes, pairs = sheet()
    for first, second, *_ in pairs:
        axes.plot(*nodes[[first, second]].T, color="#cccccc", linewidth=0.7, zorder=1)
    shown = coloured(pairs)
    for first, second, *others in shown[0]:
        axes.add_patch(Polygon(nodes[[first, others[0], second, others[1]]], color=SHOWN_COLOURS[0], alpha=0.2,
                               linewidth=0))
    for colour, members in zip(SHOWN_COLOURS, shown):
        for first, second, *_ in members:
            axes.plot(*nodes[[first, second]].T, color=colour, linewidth=2, solid_capstyle="round", zorder=2)
    axes.set(xlim=(-0.4, 11), ylim=(-0.5, 6.6), title="pairs of triangles of a colour share no node")


def blocks_of_lanes(axes) -> None:
    lanes, side = 8, 0.8
    _, pairs = sheet()
    for row, (colour, members) in enumerate(zip(SHOWN_COLOURS, coloured(pairs))):
        for lane in range(lanes * -(-len(members) // lanes)):
            x = lane + 0.7 * (lane // lanes)
            is_used = lane < len(members)
            axes.add_patch(Rectangle((x, -2.6 * row), side, side, facecolor=colour if is_used else "none", alpha=0.55,
                                     edgecolor=colour, linestyle="-" if is_used else ":"))
        if row + 1 < len(SHOWN_COLOURS):
            arrow(axes, (12.4, -2.6 * row - 0.1), (12.4, -2.6 * row - 1.75))
    axes.text(13, -1.35, "then the next colour", fontsize=8, color=NOTE)
    axes.text(0, 1.6, "a block: eight constraints at once", fontsize=8, color=SHOWN_COLOURS[0])
    axes.text(25.4, -6.6, "dotted: padding lanes", fontsize=8, color=NOTE, ha="right")
    axes.set(xlim=(-0.3, 26), ylim=(-8.5, 3.5), title="blocks of lanes")


def moving_tree(axes) -> None:
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


def both_sides(axes) -> None:
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


DIAGRAMS = {
    "constraints": ((colours_of_edges, blocks_of_lanes), 7.4, 2.8),
    "muscle_contact": ((moving_tree, both_sides), 7.0, 3.2),
    "triangle_bvh": ((triangle_bvh,), 4.4, 3.0),
    "clearance_cache": ((safe_sphere, candidate_list, order_of_questions), 7.4, 2.6),
    "distance_field": ((distance_field,), 6.2, 2.9),
    "adaptive_field": ((adaptive_field,), 4.4, 3.2),
    "batched_closest_point": ((batched_points,), 4.8, 2.6),
}


def draw(folder: Path) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    # The same bytes whenever and wherever they are drawn, so that a change is a change.
    plt.rcParams.update({"svg.hashsalt": "musclebench", "svg.fonttype": "none", "font.size": 8, "axes.titlesize": 9})
    paths = []
    for name, (parts, width, height) in DIAGRAMS.items():
        figure, axes = panel(width, height, len(parts))
        for one, part in zip(axes, parts):
            part(one)
        figure.tight_layout(pad=0.3)
        paths.append(folder / f"{name}.svg")
        figure.savefig(paths[-1], metadata={"Date": None})
        plt.close(figure)
    return paths


def draw_and_tell() -> int:
    parser = argparse.ArgumentParser(prog="tools/draw_diagrams.py", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, metavar="FOLDER", default=FOLDER,
                        help="folder of the pictures (default: reports/performance/pictures)")
    folder = parser.parse_args().folder
    require("matplotlib")
    for written in draw(folder):
        print(written)
    return 0


if __name__ == "__main__":
    sys.exit(run_command("draw_diagrams", draw_and_tell, "some diagrams may be missing"))
