"""A table of results as CSV, Markdown, LaTeX and plain text."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from ..figures.style import muscle_label

UNKNOWN = "-"
LATEX_ESCAPES = [("%", "\\%"), ("_", "\\_"), ("&", "\\&"), (">", "$>$"), ("~", "$\\sim$")]


@dataclass
class Column:
    key: str
    title: str
    digits: int | None = None  # None: text
    head: str = ""  # title for a terminal, where it has to be narrower; one or two lines
    is_ratio: bool = False  # three significant digits instead of fixed ones


@dataclass
class Table:
    name: str
    caption: str
    columns: list[Column]
    rows: pd.DataFrame  # full precision; NaN is unknown
    shown: list[str]  # keys of the columns that fit a terminal


def with_unit(columns: list[Column], unit: str) -> list[Column]:
    """Titles that name what times are divided by."""
    return [replace(one, title=one.title.replace("{unit}", unit), head=one.head.replace("{unit}", unit))
            for one in columns]


def write_table(table: Table, folder: Path) -> list[Path]:
    writers = {".csv": table.rows.to_csv(index=False), ".md": as_markdown(table), ".tex": as_latex(table)}
    paths = []
    for suffix, text in writers.items():
        paths.append(folder / f"{table.name}{suffix}")
        paths[-1].write_text(text)
    return paths


def as_markdown(table: Table) -> str:
    titles = [column.title for column in table.columns]
    lines = [table.caption, "", "| " + " | ".join(titles) + " |"]
    lines.append("| " + " | ".join("---" if c.digits is None else "---:" for c in table.columns) + " |")
    lines += ["| " + " | ".join(cells) + " |" for cells in _cells(table, table.columns)]
    return "\n".join(lines) + "\n"


def as_latex(table: Table) -> str:
    layout = "".join("l" if column.digits is None else "r" for column in table.columns)
    lines = ["\\begin{table}", "\\centering", f"\\caption{{{_latex(table.caption)}}}"]
    titles = " & ".join(_latex(column.title) for column in table.columns)
    lines += [f"\\begin{{tabular}}{{{layout}}}", "\\hline", f"{titles} \\\\", "\\hline"]
    lines += [" & ".join(_latex(cell) for cell in cells) + " \\\\" for cells in _cells(table, table.columns)]
    return "\n".join([*lines, "\\hline", "\\end{tabular}", "\\end{table}"]) + "\n"


def as_text(table: Table) -> str:
    """Aligned columns for a terminal, two lines of titles, the muscle as a heading over its backends."""
    columns = [column for column in table.columns if column.key in table.shown]
    rows = [[f"  {cells[0]}", *cells[1:]] for cells in _cells(table, columns)]
    heads = [_two_lines(column.head or column.title) for column in columns]
    widths = [max(len(text) for text in (*head, *(row[i] for row in rows))) for i, head in enumerate(heads)]
    lines = [_aligned([head[line] for head in heads], columns, widths) for line in (0, 1)]
    lines.append("  ".join("-" * width for width in widths))
    muscle = None
    for row, name in zip(rows, table.rows["muscle"]):
        if name != muscle:
            lines.append(muscle_label(name))
            muscle = name
        lines.append(_aligned(row, columns, widths))
    return "\n".join(lines)


def _aligned(cells: list[str], columns: list[Column], widths: list[int]) -> str:
    parts = [c.ljust(w) if col.digits is None else c.rjust(w) for c, col, w in zip(cells, columns, widths)]
    return "  ".join(parts).rstrip()


def _two_lines(head: str) -> tuple[str, str]:
    first, _, second = head.rpartition("\n")
    return first, second


def _cells(table: Table, columns: list[Column]) -> list[list[str]]:
    return [[_cell(row[column.key], column) for column in columns] for _, row in table.rows.iterrows()]


def _cell(value, column: Column) -> str:
    if pd.isna(value) or value == "":
        return UNKNOWN
    if column.digits is None:
        return muscle_label(value) if column.key == "muscle" else str(value)
    return as_ratio(value) if column.is_ratio else f"{value:.{column.digits}f}"


def as_ratio(value: float) -> str:
    """Three significant digits, without an exponent."""
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if 0 < value < 100 else f"{value:.0f}"


def _latex(text: str) -> str:
    for plain, escaped in LATEX_ESCAPES:
        text = text.replace(plain, escaped)
    return text
