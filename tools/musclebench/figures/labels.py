"""Short texts beside points, moved apart so that none covers another text or a point."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.patheffects import withStroke

DIRECTIONS = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)]
DISTANCES_POINTS = (4, 8, 14)
LEADER_FROM_POINTS = 10
GAP_POINTS = 0.8  # two numbers side by side must not read as one
LATTICE_POINTS = 2.5  # how fine the whole panel is looked through where there is no room beside a point


@dataclass
class Label:
    x: float
    y: float
    text: str
    colour: str
    radius_points: float = 3.0  # of the point that it names
    prefer: tuple[int, int] = (1, 0)  # direction that is tried first
    bar: tuple[float, float] | None = None  # x of the ends of its error bar


def place_labels(axes, labels: list[Label], size: float = 7.0, levels: Sequence[float] = ()) -> None:
    """Limits and scales of the axes must stand. The first free spot beside a point is taken, else the nearest free one
    of the panel; a label that is far from its point gets a thin line to it, which crosses no other. Labels without room
    anywhere are left out, so that none covers another one or a point; points without a text only take their
    room. `levels`: heights of lines across the panel that no label covers."""
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    pixels = axes.figure.dpi / 72.0
    centres = np.array([axes.transData.transform((label.x, label.y)) for label in labels]).reshape(-1, 2)
    radii = np.array([label.radius_points * pixels for label in labels])
    points = np.concatenate([centres - radii[:, None], centres + radii[:, None]], axis=1)
    points = np.concatenate([points, _bars(axes, labels, pixels)])
    frame = np.array(axes.get_window_extent(renderer).extents)
    taken = [np.array(text.get_window_extent(renderer).extents) for text in axes.texts]
    heights = [axes.transData.transform((label.x, y))[1] for label in labels[:1] for y in levels]
    points = np.concatenate([points, np.reshape([[frame[0], y, frame[2], y] for y in heights], (-1, 4))])
    leaders = np.empty((0, 2, 2))
    for index, label in enumerate(labels):
        if not label.text:
            continue
        extent = _extent(axes, label.text, size, renderer, pixels)
        covered = np.reshape(taken, (-1, 4))
        boxes = _free_boxes(centres[index], radii[index], label.prefer, extent, frame, np.concatenate([points, covered]), pixels)
        middles = (boxes[:, :2] + boxes[:, 2:]) / 2
        lines = np.stack([np.broadcast_to(centres[index], middles.shape), middles], axis=1)
        gaps = np.abs(middles - centres[index]) - extent / 2 - radii[index]
        has_leader = gaps.max(axis=1, initial=0.0) > LEADER_FROM_POINTS * pixels
        clear = np.flatnonzero(_are_clear(boxes, lines, has_leader, covered, leaders))
        if clear.size:
            best = clear[0]
            taken.append(boxes[best])
            if has_leader[best]:
                leaders = np.concatenate([leaders, lines[best:best + 1]])
            _draw(axes, label, centres[index], boxes[best], size, has_leader[best])


def _are_clear(boxes, lines, has_leader, taken, leaders) -> np.ndarray:
    """Of boxes (n, 4) with their lines (n, 2, 2): those of which no line crosses another one or a label."""
    covers = _touches(leaders, boxes[:, None]).any(axis=1)
    crosses = _cross(lines[:, None], leaders).any(axis=1) | _touches(lines[:, None], taken).any(axis=1)
    return ~covers & ~(has_leader & crosses)


def _touches(lines: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Lines (..., 2, 2) and boxes (..., 4), broadcast."""
    inside = np.all((lines >= boxes[..., None, :2]) & (lines <= boxes[..., None, 2:]), axis=-1).any(axis=-1)
    corners = boxes[..., [[0, 1], [2, 1], [2, 3], [0, 3]]]
    edges = np.stack([np.roll(corners, 1, axis=-2), corners], axis=-2)
    return inside | _cross(lines[..., None, :, :], edges).any(axis=-1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Lines (..., 2, 2), broadcast."""
    def are_apart(line, points) -> np.ndarray:
        """Whether two points are on both sides of a line."""
        along, to = line[..., None, 1, :] - line[..., None, 0, :], points - line[..., None, 0, :]
        side = along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]
        return side[..., 0] * side[..., 1] < 0

    return are_apart(a, b) & are_apart(b, a)


def _extent(axes, text: str, size: float, renderer, pixels: float) -> np.ndarray:
    drawn = axes.text(0.5, 0.5, text, fontsize=size, transform=axes.transAxes)
    box = drawn.get_window_extent(renderer)
    drawn.remove()
    return np.array([box.width, box.height]) + 2 * GAP_POINTS * pixels


def _bars(axes, labels: list[Label], pixels: float) -> np.ndarray:
    ends = [(axes.transData.transform((label.bar[0], label.y)), axes.transData.transform((label.bar[1], label.y)))
            for label in labels if label.bar is not None]
    gap = GAP_POINTS * pixels
    boxes = np.array([[*left - gap, *right + gap] for left, right in ends]).reshape(-1, 4)
    return boxes[np.isfinite(boxes).all(axis=1)]  # of few frames the interval is not known


def _free_boxes(centre, radius, prefer, extent, frame, others, pixels) -> np.ndarray:
    """(left, bottom, right, top) in pixels, the best first, inside of the frame: those that cover no label and no point."""
    beside = np.array([centre + np.array(direction) * (radius + (distance - 2) * pixels + extent / 2)
                       for distance in DISTANCES_POINTS for direction in [prefer, *DIRECTIONS]])
    middles = np.concatenate([beside, _lattice(centre, extent, frame, pixels)])
    return _boxes_free_of(middles, extent, frame, others)


def _lattice(centre, extent, frame, pixels) -> np.ndarray:
    """Middles of boxes over the whole frame, the nearest to the centre first."""
    step = LATTICE_POINTS * pixels
    x, y = (np.arange(frame[axis] + extent[axis] / 2, frame[axis + 2] - extent[axis] / 2, step) for axis in (0, 1))
    middles = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return middles[np.argsort(np.linalg.norm(middles - centre, axis=1), kind="stable")]


def _boxes_free_of(middles: np.ndarray, extent, frame, others: np.ndarray) -> np.ndarray:
    boxes = np.concatenate([middles - extent / 2, middles + extent / 2], axis=1)
    inside = np.all(boxes[:, :2] >= frame[:2], axis=1) & np.all(boxes[:, 2:] <= frame[2:], axis=1)
    boxes = boxes[inside]
    apart = np.any(boxes[:, None, :2] >= others[None, :, 2:], axis=2) \
        | np.any(boxes[:, None, 2:] <= others[None, :, :2], axis=2)
    return boxes[np.all(apart, axis=1)]


def _draw(axes, label: Label, centre, box, size: float, has_leader: bool) -> None:
    middle = (box[:2] + box[2:]) / 2
    to_axes = axes.transAxes.inverted()
    (x, y), (from_x, from_y) = to_axes.transform(middle), to_axes.transform(centre)
    axes.text(x, y, label.text, fontsize=size, color=label.colour, ha="center", va="center", transform=axes.transAxes,
              zorder=6, path_effects=[withStroke(linewidth=1.5, foreground="white", alpha=0.8)])
    if has_leader:
        axes.plot([from_x, x], [from_y, y], color=label.colour, linewidth=0.4, alpha=0.6, transform=axes.transAxes,
                  zorder=1.5)
