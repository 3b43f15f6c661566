"""One look for all figures: names, fonts, printed widths, saving."""

import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (the backend must be chosen first)
from matplotlib.ticker import LogFormatter  # noqa: E402
from matplotlib.transforms import Bbox  # noqa: E402

# Figures are drawn at the width at which a two-column page prints them, so that a point of text stays a point.
COLUMN_INCHES = 3.5
PAGE_INCHES = 7.16
SMALLEST_POINTS = 7.0
NOTE_COLOUR = "#555555"
DPI = 300
PAD_INCHES = 0.05
FORMATS = (".png", ".svg", ".pdf")


class PlainLogFormatter(LogFormatter):
    """Labels minor ticks of a log axis where there are few decades, without powers, whose raised figures are too small."""

    def __call__(self, x, pos=None):
        return f"{x:g}" if super().__call__(x, pos) else ""


def muscle_label(muscle: str) -> str:
    return muscle.replace("_", " ")


def in_order(names, order: list[str]) -> list[str]:
    """Names without repetition, the known ones first and in their order."""
    names = set(names)
    return [name for name in order if name in names] + sorted(names - set(order))


def apply_style() -> None:
    plt.rcParams.update({
        "font.size": 7.5, "axes.titlesize": 8, "axes.labelsize": 7.5, "legend.fontsize": 7, "xtick.labelsize": 7,
        "ytick.labelsize": 7, "figure.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False,
        "axes.grid": True, "grid.color": "#e3e3e3", "grid.linewidth": 0.4, "lines.linewidth": 1.1,
        "axes.linewidth": 0.6, "figure.facecolor": "white", "figure.dpi": DPI, "svg.fonttype": "none",
        "pdf.fonttype": 42, "axes.axisbelow": True,
    })


def save_figure(figure, stem: Path) -> list[Path]:
    """PNG, SVG and PDF, as wide as the figure and as high as what is drawn; closes the figure."""
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())
    page = Bbox([[0, drawn.y0 - PAD_INCHES], [figure.get_figwidth(), drawn.y1 + PAD_INCHES]])
    paths = [stem.with_suffix(suffix) for suffix in FORMATS]
    for path in paths:
        figure.savefig(path, dpi=DPI, bbox_inches=page)
    plt.close(figure)
    return paths


def wrapped(text: str, width_inches: float, points: float = SMALLEST_POINTS) -> str:
    """Lines that fit the width, by the mean width of a letter of the font."""
    return "\n".join(textwrap.wrap(text, int(width_inches * 72 / (0.55 * points))))


def add_note(figure, text: str, y: float = -0.01, left_inches: float = 0.05) -> None:
    """Small print under a figure, over its whole width."""
    width = figure.get_figwidth()
    figure.text(left_inches / width, y, wrapped(text, width - 2 * left_inches), fontsize=SMALLEST_POINTS,
                color=NOTE_COLOUR, va="top")
