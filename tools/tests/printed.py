"""What any figure is held to: it fits the page and its text can be read."""

import re
import zlib

import pytest
from matplotlib.text import Text
from PIL import Image

from musclebench.figures import style
from musclebench.figures.style import plt


def keep_figures(patch, kept: dict) -> None:
    """What save_figure is given, before it closes it."""
    save, close = style.save_figure, plt.close

    def keep(figure, stem):
        patch.setattr(plt, "close", lambda figure: None)
        kept[stem.name] = (figure, save(figure, stem))
        patch.setattr(plt, "close", close)
        return kept[stem.name][1]

    patch.setattr(style, "save_figure", keep)


def texts_of(figure) -> list[Text]:
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]


def check_print(figure, paths) -> None:
    """Widths of a column or a page, nothing smaller than 7 points, nothing beyond the sides."""
    assert figure.get_figwidth() in (style.COLUMN_INCHES, style.PAGE_INCHES)
    assert min(text.get_fontsize() for text in texts_of(figure)) >= style.SMALLEST_POINTS
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())
    assert drawn.x0 >= -0.01 and drawn.x1 <= figure.get_figwidth() + 0.01
    suffixes = {path.suffix: path for path in paths}
    assert {".png", ".svg", ".pdf"} <= set(suffixes)
    box = re.search(rb"/MediaBox \[([^]]*)\]", suffixes[".pdf"].read_bytes()).group(1).split()
    assert float(box[2]) - float(box[0]) == pytest.approx(72 * figure.get_figwidth(), abs=1)
    sizes = printed_sizes(suffixes[".pdf"])
    assert sizes and min(sizes) >= style.SMALLEST_POINTS, (suffixes[".pdf"].name, sizes)
    with Image.open(suffixes[".png"]) as picture:
        assert picture.info["dpi"] == pytest.approx((style.DPI, style.DPI), abs=1)
        assert picture.width == pytest.approx(style.DPI * figure.get_figwidth(), abs=3)


def printed_sizes(pdf) -> set[float]:
    """In points: of all fonts that a PDF of matplotlib chooses, raised figures such as those of powers among them."""
    found = set()
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf.read_bytes(), re.DOTALL):
        try:
            text = zlib.decompress(stream)
        except zlib.error:
            continue  # a picture or a font
        found |= {float(size) for size in re.findall(rb"/F[\w-]* ([\d.]+) Tf", text)}
    return found
