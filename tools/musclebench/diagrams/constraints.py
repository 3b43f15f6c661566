"""How constraints are solved side by side."""

from typing import Any

import numpy as np

from .shapes import ASKED, FREE, NOTE, WRONG, Axes, Polygon, Rectangle, arrow

SHOWN_COLOURS = (ASKED, FREE, WRONG)


def sheet() -> tuple[Any, list[tuple[int, ...]]]:
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
            free = (set(), [])
            colours.append(free)
        free[0].update(pair)
        free[1].append(pair)
    return [members for _, members in colours]


def colours_of_edges(axes: Axes) -> None:
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


def blocks_of_lanes(axes: Axes) -> None:
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
