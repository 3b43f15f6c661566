"""The surface offset by what makes contact hard: an average over all contacts hides where a backend lets nodes in."""

import math

import pandas as pd

from ..accuracy.aggregates import Aggregate, number
from .table_formats import Column, Table

TITLES = {"flat": "flat", "ridge": "convex ridge", "concave": "concave", "thin": "thin", "attached_border": "attached border"}
COLUMNS = [
    Column("muscle", "muscle"), Column("configuration", "configuration"),
    *(Column(f"{kind}_mm", f"{title}: p99 offset mm", 4, f"{title}\nmm") for kind, title in TITLES.items()),
    *(Column(f"{kind}_sites", f"{title}: sites", 0, "sites") for kind, title in TITLES.items()),
    Column("open_sites", "sites without a surface", 0, "open"),
]
SHOWN = ["configuration", *(f"{kind}_mm" for kind in TITLES), "open_sites"]


def difficulties_table(replays: list[Aggregate]) -> Table:
    """One row a muscle and configuration that can be asked about single points."""
    rows = [_row(one) for one in replays if one.is_shown and not math.isnan(one.number("surface_offset", "p99_offset_m"))]
    caption = (
        "Surface offset by contact difficulty, 99th percentile over the contacts, inwards or outwards. Thin: the bone is "
        "thinner than 1 % of its diagonal. Ridge and concave: it bends with a radius below some 3 % of it. Attached "
        "border: the node shares a triangle with an attached one. Open: the backend's answer does not change within the "
        "band. Empty: the motion has no such contact."
    )
    return Table("contact_difficulties", caption, COLUMNS, pd.DataFrame(rows, columns=[c.key for c in COLUMNS]), SHOWN)


def _row(aggregate: Aggregate) -> dict:
    row = {"muscle": aggregate.muscle, "configuration": aggregate.configuration.name,
           "open_sites": aggregate.number("surface_offset", "open_sites")}
    for case in aggregate.ok:
        for told in (case.run.record.get("surface_offset") or {}).get("of_difficulties", []):
            if told["sites"]:
                kind = told["difficulty"]
                row |= {f"{kind}_mm": 1e3 * number(told, "p99_offset_m"), f"{kind}_sites": told["sites"]}
    return row
