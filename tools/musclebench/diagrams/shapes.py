"""What several drawings share: colours, a bone, arrows."""

from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (the backend must be chosen first)
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle  # noqa: E402

__all__ = ["Axes", "Circle", "Polygon", "Rectangle", "plt"]

BONE, LINE, ASKED, FREE, WRONG, NOTE = "#EDE3C7", "#6B5B3A", "#0072B2", "#009E73", "#D55E00", "#555555"


def bone_distance(x: Any, y: Any) -> Any:
    """Signed, of a flat shape with a round end: negative inside."""
    shaft = np.maximum(np.abs(y - 0.1 * np.sin(2 * x)) - 0.28, np.maximum(-x - 1.1, x - 0.8))
    head = np.hypot(x - 0.75, y - 0.18) - 0.48
    return np.minimum(shaft, head)


def panel(figure_width: float = 5.0, height: float = 2.8, columns: int = 1) -> tuple[Figure, Any]:
    figure, axes = plt.subplots(1, columns, figsize=(figure_width, height), squeeze=False)
    for one in axes[0]:
        one.set_aspect("equal")
        one.set_axis_off()
    return figure, axes[0]


def outline(axes: Axes, spread: float = 1.7) -> None:
    x, y = np.meshgrid(np.linspace(-spread, spread, 160), np.linspace(-1.1, 1.1, 110))
    axes.contourf(x, y, bone_distance(x, y), levels=[-9, 0], colors=[BONE])
    axes.contour(x, y, bone_distance(x, y), levels=[0], colors=[LINE], linewidths=1.2)


def arrow(axes: Axes, start: Any, end: Any, colour: str = NOTE) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=8, color=colour, linewidth=1))


def double_arrow(axes: Axes, start: Any, end: Any, colour: str = NOTE) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="<|-|>", mutation_scale=6, color=colour, linewidth=1, shrinkA=0, shrinkB=0))


def box(axes: Axes, corner: tuple[float, float], width: float, height: float, words: str, colour: str = ASKED, alpha: float = 0.2, points: float = 8) -> None:
    """A filled box with words in its middle."""
    axes.add_patch(Rectangle(corner, width, height, facecolor=colour, alpha=alpha, edgecolor="none"))
    axes.text(corner[0] + width / 2, corner[1] + height / 2, words, ha="center", va="center", fontsize=points)
