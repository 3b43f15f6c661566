"""What a reader would see of a careless layout: cut words, words over words or markers, legends over data."""

from matplotlib.collections import PathCollection
from matplotlib.container import BarContainer
from matplotlib.text import Text
from matplotlib.transforms import Bbox

TOUCHING_POINTS = 0.12  # boxes of letters hold some air: covering each other by less is not seen
OVER_MARKER_POINTS = 1.2


def collisions(figure) -> list[str]:
    """A line for each; empty where nothing covers what it must not. Draws the figure."""
    figure.canvas.draw()  # legends and ticks are laid out now
    renderer, point = figure.canvas.get_renderer(), figure.dpi / 72.0
    texts = [(text.get_text(), text.get_window_extent(renderer)) for text in drawn_texts(figure)]
    return [*_cut_off(figure, texts), *_over_texts(texts, TOUCHING_POINTS * point),
            *_over_markers(figure, texts, OVER_MARKER_POINTS * point), *_out_of_panels(figure, renderer, point),
            *_legends_over_data(figure, renderer)]


def drawn_texts(figure) -> list[Text]:
    """Those that are seen: without ticks outside of the panels and the axes of panels that have none."""
    found = [*figure.texts, *_texts_of(figure.legends), *([figure._suptitle] if figure._suptitle else [])]
    for axes in [*figure.axes, *(child for axes in figure.axes for child in axes.child_axes)]:
        found += [axes.title, axes._left_title, axes._right_title, *axes.texts, *_texts_of([axes.get_legend()])]
        if axes.axison:
            found += [label for axis in (axes.xaxis, axes.yaxis) for label in (
                axis.label, *(label for tick in axis._update_ticks() for label in (tick.label1, tick.label2)))]
    return [text for text in dict.fromkeys(found) if text.get_visible() and text.get_text().strip()]


def _texts_of(legends) -> list[Text]:
    return [text for legend in legends if legend for text in [*legend.get_texts(), legend.get_title()]]


def _cut_off(figure, texts) -> list[str]:
    """A page is as wide as the figure and as high as what counts as drawn (`style.save_figure`)."""
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())
    low, high = figure.dpi * drawn.y0, figure.dpi * drawn.y1
    return [f"'{words}' is cut off at the edge of the page" for words, box in texts
            if box.x0 < -0.5 or box.x1 > figure.bbox.x1 + 0.5 or box.y0 < low - 0.5 or box.y1 > high + 0.5]


def _over_texts(texts, tolerance: float) -> list[str]:
    boxes = [(words, box.padded(-tolerance)) for words, box in texts]
    return [f"'{a}' covers '{b}'" for i, (a, of_a) in enumerate(boxes) for b, of_b in boxes[:i] if of_a.overlaps(of_b)]


def _over_markers(figure, texts, tolerance: float) -> list[str]:
    markers = [box for axes in figure.axes for box in _markers(axes)]
    boxes = [(words, box.padded(-tolerance)) for words, box in texts]
    return [f"'{words}' covers a marker" for words, box in boxes if any(box.overlaps(marker) for marker in markers)]


def _markers(axes) -> list[Bbox]:
    """Of what is seen in the panel."""
    point, found = axes.figure.dpi / 72.0, []
    for line in axes.lines:
        if line.get_visible() and line.get_marker() not in (None, "", " ", "None"):
            places = line.get_transform().transform(line.get_xydata())
            found += [(place, line.get_markersize() * point / 2) for place in places]
    for collection in axes.collections:
        if isinstance(collection, PathCollection) and collection.get_visible():
            places = collection.get_offset_transform().transform(collection.get_offsets())
            sizes = collection.get_sizes()
            found += [(place, sizes[i % len(sizes)] ** 0.5 * point / 2) for i, place in enumerate(places)]
    return [Bbox([place - radius, place + radius]) for place, radius in found if axes.bbox.padded(1).contains(*place)]


def _out_of_panels(figure, renderer, point: float) -> list[str]:
    """Words of a panel are in it, or in the margin beside it, never half and half and never in another panel."""
    found = []
    panels = [axes for axes in figure.axes if axes.axison or axes.images]
    for axes in figure.axes:
        for text in (text for text in axes.texts if text.get_visible() and text.get_text().strip()):
            box, own = text.get_window_extent(renderer).padded(-point), axes.bbox
            is_inside = own.x0 <= box.x0 and own.y0 <= box.y0 and box.x1 <= own.x1 and box.y1 <= own.y1
            if axes in panels and box.overlaps(own) and not is_inside:
                found.append(f"'{text.get_text()}' is half out of its panel")
            if any(other is not axes and box.overlaps(other.bbox) for other in panels) and not is_inside:
                found.append(f"'{text.get_text()}' is in another panel")
    return found


def _legends_over_data(figure, renderer) -> list[str]:
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    boxes = [legend.get_window_extent(renderer).padded(-1) for legend in legends if legend.get_visible()]
    return [f"a legend covers data of '{axes.get_title(loc='left') or axes.get_title() or axes.get_ylabel()}'"
            for box in boxes for axes in figure.axes if box.overlaps(axes.bbox) and _has_data_in(axes, box)]


def _has_data_in(axes, box: Bbox) -> bool:
    if any(box.overlaps(marker) for marker in _markers(axes)):
        return True
    if any(line.get_path().transformed(line.get_transform()).intersects_bbox(box, filled=False)
           for line in axes.lines if line.get_visible() and len(line.get_xydata())):
        return True
    bars = [bar for container in axes.containers if isinstance(container, BarContainer) for bar in container]
    return bool(axes.images) or any(box.overlaps(bar.get_window_extent()) for bar in bars)
