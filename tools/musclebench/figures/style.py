"""One look for all figures: names, fonts, saving."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (the backend must be chosen first)
from PIL import Image  # noqa: E402

PNG_DPI = 180
PNG_COLOURS = 128


def muscle_label(muscle: str) -> str:
    return muscle.replace("_", " ")


def in_order(names, order: list[str]) -> list[str]:
    """Names without repetition, the known ones first and in their order."""
    names = set(names)
    return [name for name in order if name in names] + sorted(names - set(order))


def apply_style() -> None:
    plt.rcParams.update({
        "font.size": 10, "axes.titlesize": 11, "axes.labelsize": 10, "legend.fontsize": 9,
        "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e3e3e3",
        "grid.linewidth": 0.6, "lines.linewidth": 1.6, "figure.facecolor": "white", "svg.fonttype": "none",
        "axes.axisbelow": True,
    })


def save_figure(figure, stem: Path) -> list[Path]:
    """PNG and SVG; closes the figure."""
    paths = [stem.with_suffix(".png"), stem.with_suffix(".svg")]
    for path in paths:
        figure.savefig(path, dpi=PNG_DPI, bbox_inches="tight", pad_inches=0.12)
    plt.close(figure)
    with Image.open(paths[0]) as drawn:
        indexed = drawn.convert("RGB").quantize(PNG_COLOURS)  # a third of the bytes, and nobody sees it
    indexed.save(paths[0], optimize=True)
    return paths
