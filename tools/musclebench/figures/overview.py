"""The picture that a newcomer sees first: each backend as advised, as it is by default, and its first curve, on one panel."""

from pathlib import Path

import pandas as pd

from ..accuracy.front import ALL_MUSCLES, on_front
from . import looks
from .pareto import Emphasis, draw_pareto

EXACT_MM = 1e-3  # a micrometre: nobody who looks for the first time cares which is nearer


def overview(points: pd.DataFrame) -> pd.DataFrame:
    """Of all muscles together where there are several. An error that isn't known is infinite: what stands in for it
    elsewhere would look exact here."""
    panel = ALL_MUSCLES if ALL_MUSCLES in set(points["panel"]) else points["panel"].iloc[0]
    is_curve = [series in looks.series_of(backend)[:1] for series, backend in zip(points["series"], points["backend"])]
    chosen = (points["panel"] == panel) & ~points["is_control"] & (points["is_default"] | points["is_advised"] | is_curve)
    shown = points[chosen].reset_index(drop=True)
    # A backend has one name; of two points each has its words: FCL, as in the paper; FCL, as advised.
    is_alone = (shown["is_default"] | shown["is_advised"]).groupby(shown["backend"]).transform("sum") == 1
    shown["spoken"] = shown["spoken"].mask(is_alone, shown["backend"].map(looks.title))
    shown["on_front"] = shown.index.isin(on_front(shown, EXACT_MM))
    return shown


def named(points: pd.DataFrame) -> list[int]:
    """First the backends of this project and of the paper, then other people's libraries."""
    marked = points[points["is_default"] | points["is_advised"]]
    order = looks.backends_in_order(marked["backend"])
    order.sort(key=lambda backend: looks.backend(backend).is_external)
    return [index for backend in order for index in marked.index[marked["backend"] == backend]]


def draw_overview(points: pd.DataFrame, stem: Path, title: str) -> list[Path]:
    if points.empty:
        return []
    emphasis = Emphasis("below 1 \N{MICRO SIGN}m", EXACT_MM, has_intervals=False, names_curves=False, named=named)
    return draw_pareto(overview(points), stem, title, "surface offset, 99th percentile (mm)", emphasis)
