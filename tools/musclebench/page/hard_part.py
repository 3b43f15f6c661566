"""The matrix of hard cases: which backend holds in which, and the figure behind each cell."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ..figures import looks
from ..hard.cells import cells_of
from ..results.run_folder import read_runs
from .effects_part import tables_in
from .looks_of import looks_of_names
from .parts import Part, Section
from .scene_data import Sight
from .views import views_of
from .written import read_rows

SIDE = Sight(np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]))  # as their strips are cut
VERDICTS = (("holds", "hold"), ("breaks", "break"), ("refused", "refused"), ("not applicable", "not applicable"))


@dataclass(frozen=True)
class Cell:
    backend: str
    verdict: str
    words: str


@dataclass
class MatrixPart:
    title: str
    words: str
    columns: list[str]
    lines: list[tuple[str, list[Cell]]]  # (case, a cell a column)
    texts: dict[str, str]  # {case: what happens and why it is hard}
    csv: str
    name: str = "cells"
    kind_of_part: str = "matrix"


def is_hard(folder: Path) -> bool:
    return (tables_in(folder) / "cells.csv").is_file() or (folder / "matrix.csv").is_file()


def hard_section(folder: Path) -> Section:
    cells = _read_cells(folder)
    counts = cells["verdict"].value_counts()
    totals = ", ".join(f"{counts.get(verdict, 0)} {words}" for verdict, words in VERDICTS)
    what = [("Cells", f"{len(cells)}: {totals}"), ("Cases", str(cells["case"].nunique())),
            ("Backends", ", ".join(looks.title_and_name(name) for name in dict.fromkeys(cells["backend"])))]
    parts: list[Part] = [matrix_part(cells, _texts(folder))]
    runs = {(run.scene.split("/")[-1], run.backend): run for run in read_runs(folder / "raw")}
    if runs:
        parts.append(views_of(runs, "The scenes that move, in 3D", SIDE))
    colours = looks_of_names(backend for _, backend in runs)
    return Section("hard", "Cases that are hard to keep stable", what, _broken(cells), parts, colours, folder)


def matrix_part(cells: pd.DataFrame, texts: dict[str, str]) -> MatrixPart:
    backends = list(dict.fromkeys(cells["backend"]))
    lines = []
    for case, rows in cells.groupby("case", sort=False):
        found = {row.backend: Cell(row.backend, row.verdict, _words(row)) for row in rows.itertuples()}
        lines.append((case, [found.get(backend, Cell(backend, "not applicable", "not run")) for backend in backends]))
    words = ("Each row is a case, each column a backend. Refused: the figure is beyond its bar, and the program says so. A dash: not "
             "applicable. Hover over the name of a case to read what happens in it.")
    return MatrixPart("Which backend holds in which case", words, backends, lines, texts, cells.to_csv(index=False))


def _read_cells(folder: Path) -> pd.DataFrame:
    """Of a folder of tools/hard, of tools/publish or of `musclebench hard --out`, which has only matrix.csv."""
    table = tables_in(folder) / "cells.csv"
    if table.is_file():
        return read_rows(table)
    return cells_of(pd.read_csv(folder / "matrix.csv", keep_default_na=False))


def _texts(folder: Path) -> dict[str, str]:
    table = tables_in(folder) / "cases.csv"
    if not table.is_file():
        return {}
    return {row.case: f"{row.what} {row.why} Bar: {row.bar}." for row in read_rows(table).itertuples()}


def _broken(cells: pd.DataFrame) -> list[str]:
    rows = cells[cells["verdict"] == "breaks"]
    return [f"{row.case} breaks with {row.backend}: {_words(row)}" for row in rows.itertuples()]


def _words(row) -> str:
    """The verdict, the figure beside its bar, what the program says."""
    parts = [row.verdict]
    if _text(row.figure):
        parts.append(f"{row.figure} {_number(row.value)} {_text(row.unit)}".rstrip() + f", bar {_number(row.bar)} {_text(row.unit)}".rstrip())
    return "; ".join(part for part in (*parts, _text(row.said)) if part)


def _number(value: float) -> str:
    return "no number" if math.isnan(value) else f"{value:.3g}"


def _text(value) -> str:
    return value if isinstance(value, str) else ""
