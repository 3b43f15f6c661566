"""Short texts beside points, moved apart so that none covers another text or a point."""

from dataclasses import dataclass

import numpy as np
from matplotlib.patheffects import withStroke

DIRECTIONS = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)]
DISTANCES_POINTS = (4, 8, 14, 21, 29, 38)
LEADER_FROM_POINTS = 10
GAP_PIXELS = 2  # two numbers side by side must not read as one


@dataclass
class Label:
    x: float
    y: float
    text: str
    colour: str
    radius_points: float = 3.0  # of the point that it names
    prefer: tuple[int, int] = (1, 0)  # direction that is tried first
    bar: tuple[float, float] | None = None  # x of the ends of its error bar


def place_labels(axes, labels: list[Label], size: float = 7.0) -> None:
    """Limits and scales of the axes must stand. The first free place around a point is taken, the nearest distance
    first; a label that is far from its point gets a thin line to it."""
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    pixels = axes.figure.dpi / 72.0
    centres = np.array([axes.transData.transform((label.x, label.y)) for label in labels]).reshape(-1, 2)
    radii = np.array([label.radius_points * pixels for label in labels])
    points = np.concatenate([centres - radii[:, None], centres + radii[:, None]], axis=1)
    points = np.concatenate([points, _bars(axes, labels)])
    frame, taken = axes.get_window_extent(renderer), []
    for place, label in enumerate(labels):
        extent = _extent(axes, label.text, size, renderer)
        box, distance = _free_box(centres[place], radii[place], label.prefer, extent, frame, points, taken, pixels)
        taken.append(box)
        _draw(axes, label, centres[place], box, size, distance > LEADER_FROM_POINTS)


def _extent(axes, text: str, size: float, renderer) -> np.ndarray:
    drawn = axes.text(0.5, 0.5, text, fontsize=size, transform=axes.transAxes)
    box = drawn.get_window_extent(renderer)
    drawn.remove()
    return np.array([box.width + 2 * GAP_PIXELS, box.height])


def _bars(axes, labels: list[Label]) -> np.ndarray:
    ends = [(axes.transData.transform((label.bar[0], label.y)), axes.transData.transform((label.bar[1], label.y)))
            for label in labels if label.bar is not None]
    return np.array([[*left - GAP_PIXELS, *right + GAP_PIXELS] for left, right in ends]).reshape(-1, 4)


def _free_box(centre, radius, prefer, extent, frame, points, taken, pixels):
    """(left, bottom, right, top) in pixels and its distance in points; the least covered where none is free."""
    others = np.array([*points, *taken])
    best = None
    for distance in DISTANCES_POINTS:
        for direction in [prefer, *DIRECTIONS]:
            middle = centre + np.array(direction) * (radius + (distance - 2) * pixels + extent / 2)
            box = np.concatenate([middle - extent / 2, middle + extent / 2])
            covered = _covered(box, others) + _outside(box, frame)
            if best is None or covered < best[0]:
                best = (covered, box, distance)
            if covered == 0:
                return box, distance
    return best[1], best[2]


def _covered(box, others: np.ndarray) -> float:
    widths = np.minimum(box[2], others[:, 2]) - np.maximum(box[0], others[:, 0])
    heights = np.minimum(box[3], others[:, 3]) - np.maximum(box[1], others[:, 1])
    return float(np.sum(np.clip(widths, 0, None) * np.clip(heights, 0, None)))


def _outside(box, frame) -> float:
    """Leaving the panel is worse than covering something."""
    over = [frame.x0 - box[0], frame.y0 - box[1], box[2] - frame.x1, box[3] - frame.y1]
    return 1e4 * sum(max(0.0, value) for value in over)


def _draw(axes, label: Label, centre, box, size: float, has_leader: bool) -> None:
    middle = (box[:2] + box[2:]) / 2
    to_axes = axes.transAxes.inverted()
    (x, y), (from_x, from_y) = to_axes.transform(middle), to_axes.transform(centre)
    axes.text(x, y, label.text, fontsize=size, color=label.colour, ha="center", va="center", transform=axes.transAxes,
              zorder=6, path_effects=[withStroke(linewidth=1.5, foreground="white", alpha=0.8)])
    if has_leader:
        axes.plot([from_x, x], [from_y, y], color=label.colour, linewidth=0.4, alpha=0.6, transform=axes.transAxes,
                  zorder=1.5)
