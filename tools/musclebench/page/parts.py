"""What a page is made of: sections of tables, charts and views in space. A chart draws the rows that it carries, so that
what the mouse shows is what its file holds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import pandas as pd

from ..figures.style import muscle_label
from ..tables.table_formats import Table, as_cells
from .views import Views


@dataclass(frozen=True)
class Axis:
    column: str  # of the rows
    title: str  # with its unit
    is_log: bool = False


@dataclass(frozen=True)
class Chooser:
    """Of a chart that shows, one at a time, the rows with one value of a column."""

    column: str
    title: str
    names: dict[str, str]  # {value: as people read it}
    first: str = ""  # value that is chosen at first; that of the first name unless told


@dataclass
class Chart:
    """One muscle at a time where the rows have a column `muscle`; colours are those of the column `backend`."""

    name: str  # of its file and in links
    title: str
    words: str  # what one sees, for readers and screen readers
    kind: str  # lines, points, bars or nights
    rows: pd.DataFrame  # in the units of the axes
    x: Axis
    y: Axis
    hover: dict[str, str] = field(default_factory=dict)  # {column: title with unit} of what else a point tells
    options: dict = field(default_factory=dict)  # of the kind, as tools/page/KIND.js reads them
    beside: dict = field(default_factory=dict)  # a small table under it: caption, heads, lines of cells
    more: list[str] = field(default_factory=list)  # paragraphs for whom wants to know
    choosers: list[Chooser] = field(default_factory=list)
    kind_of_part: str = "chart"

    @property
    def csv(self) -> str:
        return csv_of(self.rows)

    @property
    def spec(self) -> dict:
        return {"name": self.name, "title": self.title, "kind": self.kind, "x": vars(self.x), "y": vars(self.y),
                "hover": self.hover, **self.options}


MOST_IN_A_CELL = 40  # characters


@dataclass
class TablePart:
    """A table of results with the rows behind it."""

    name: str
    title: str
    words: str
    heads: list[str]
    is_number: list[bool]
    groups: list[tuple[str, list[list[str]]]]  # (muscle or "", cells of its rows)
    csv: str
    kind_of_part: str = "table"

    @property
    def below(self) -> set[int]:
        """Columns of sentences, such as the reason of a status: these stand under their row, as wide as the table. Where most cells
        are short, a long one wraps."""
        told = [[cells[i].strip() for _, lines in self.groups for cells in lines if cells[i].strip() not in ("", "-")]
                for i in range(len(self.heads))]
        return {i for i, cells in enumerate(told)
                if cells and not self.is_number[i] and 2 * sum(len(cell) > MOST_IN_A_CELL for cell in cells) > len(cells)}


class Part(Protocol):
    """A table, a chart or a view: the page's template knows what is what."""

    kind_of_part: str


@dataclass
class Section:
    """Of one folder of results."""

    name: str  # in links
    title: str
    what: list[tuple[str, str]]  # (what was run and on what, in words)
    problems: list[str]  # runs without a result, machines that were busy
    parts: Sequence[Part]
    colours: dict[str, dict]  # {backend: label, colour, dash}
    folder: Path
    is_left_out: bool = False  # its results can't be read; `problems` says why

    @property
    def muscles(self) -> list[str]:
        """Those that can be chosen, in the order of their first rows."""
        found = []
        for part in self.parts:
            if isinstance(part, Chart) and "muscle" in part.rows:
                found += list(part.rows["muscle"].unique())
            elif isinstance(part, Views):
                found += [scene["muscle"] for scene in part.scenes]
        return list(dict.fromkeys(found))

    @property
    def backends(self) -> list[str]:
        """Those that can be clicked away."""
        found = {name for part in self.parts if isinstance(part, Chart) and "backend" in part.rows
                 for name in part.rows["backend"].unique()}
        found |= {run["backend"] for part in self.parts if isinstance(part, Views) for scene in part.scenes for run in scene["runs"]}
        return [name for name in self.colours if name in found]


def table_part(table: Table, title: str) -> TablePart:
    """The columns that a terminal shows; its file has all."""
    columns = [column for column in table.columns if column.key in table.shown]
    cells = as_cells(table, columns)
    groups: list[tuple[str, list[list[str]]]] = []
    muscles = table.rows["muscle"] if "muscle" in table.rows else [""] * len(cells)
    for muscle, row in zip(muscles, cells):
        if not groups or groups[-1][0] != muscle_label(muscle):
            groups.append((muscle_label(muscle), []))
        groups[-1][1].append(row)
    return TablePart(table.name, title, table.caption, [column.title for column in columns],
                     [column.digits is not None for column in columns], groups, table.rows.to_csv(index=False))


def csv_of(rows: pd.DataFrame) -> str:
    """Of many frames: digits beyond those of a measurement would double the page."""
    return rows.to_csv(index=False, float_format=_number)


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.7g}"
