"""What a change brings to the board, as a page of Markdown that a pull request shows."""

import re
from collections.abc import Sequence

import pandas as pd

from ..tables.table_formats import Column, markdown_rows

MARKUP = re.compile(r"([\\`*_{}\[\]<>()#+!|~&:@-])")  # a stranger's words stay words: no link, no picture, nobody called
COLUMNS = [
    Column("scene", "scene"), Column("setting", "setting"), Column("time_ms", "ms a frame", 4), Column("offset", "surface offset (mm)"),
    Column("bound", "declared bound"), Column("standing", "answers"), Column("division", "division"), Column("why_not", "why it can't win"),
]
FARTHER = "farther than was searched"


def as_summary(rows: pd.DataFrame, machines: Sequence[str]) -> str:
    """A table each bundle, from rows of the board and names of standing.machines_of."""
    parts = []
    for machine in machines:
        of_bundle = rows[rows["machine"] == machine]
        told = of_bundle.assign(setting=of_bundle["spoken"].where(of_bundle["spoken"] != "", of_bundle["configuration"]))
        offsets = ["" if pd.isna(offset) else f"{offset:.4f}" for offset in told["offset_mm"]]
        told = told.assign(offset=[FARTHER if is_open else offset for is_open, offset in zip(told["is_open"], offsets)])
        told = told.assign(**{column.key: told[column.key].map(_as_text) for column in COLUMNS if column.digits is None})
        counts = ", ".join(f"{count} {name}" for name, count in of_bundle["standing"].value_counts().items())
        parts.append(f"### {_as_text(machine)}\n\n"
                     f"{len(of_bundle)} settings: {counts}. Times compare within this table only.\n\n{markdown_rows(COLUMNS, told)}\n")
    return "\n".join(parts)


def _as_text(words: str) -> str:
    return MARKUP.sub(r"\\\1", " ".join(str(words).split()))
