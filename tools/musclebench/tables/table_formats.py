"""A table of results as CSV, Markdown, LaTeX and plain text."""

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from ..figures.style import muscle_label

UNKNOWN = "-"
LATEX_ESCAPES = str.maketrans({
    "%": "\\%", "_": "\\_", "&": "\\&", "#": "\\#", "$": "\\$", "{": "\\{", "}": "\\}", ">": "$>$", "<": "$<$",
    "~": "$\\sim$", "\N{MINUS SIGN}": "$-$", "^": "\\^{}", "\\": "\\textbackslash{}",
})
# The text of a page of two columns (article, A4), in points; \footnotesize has figures of 4.3 points and lines of 9.5.
LATEX_WIDTH, LATEX_LETTER, LATEX_GAP = 452.0, 4.3, 7.0
LATEX_HEIGHT, LATEX_LINE, LATEX_HEADING, LATEX_HEADS = 550.0, 9.5, 18.0, 76.0
LATEX_CAPTION_LINE, LATEX_CAPTION_LETTERS = 12.0, 85
LATEX_NOTE = "% Needs \\usepackage{booktabs}; no wider than 452 pt, the text of an A4 page of class article in two columns."
NUMBERED = re.compile(r"^Table [IVX]+\. ")  # LaTeX has numbers of its own
MINUS = re.compile(r"^-(?=[\d.])")


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

    def with_sentence(self, sentence: str) -> "Table":
        """At the end of its caption, which every form of it shows."""
        return replace(self, caption=f"{self.caption} {sentence}".rstrip())


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
    return f"{table.caption}\n\n{markdown_rows(table.columns, table.rows)}\n"


def markdown_rows(columns: list[Column], rows: pd.DataFrame) -> str:
    lines = ["| " + " | ".join(column.title for column in columns) + " |"]
    lines.append("| " + " | ".join("---" if c.digits is None else "---:" for c in columns) + " |")
    lines += ["| " + " | ".join(cells) + " |" for cells in as_cells(Table("", "", columns, rows, []), columns)]
    return "\n".join(lines)


def as_latex(table: Table) -> str:
    """Tables for the package booktabs that fit the width of a page and its height: of the columns that a terminal
    shows, in parts where there are more columns or rows than a page holds."""
    shown = [column for column in table.columns if column.key in table.shown]
    parts = [_latex_part(table, rows, columns) for rows in _latex_pages(table)
             for columns in latex_column_groups(table, shown)]
    captions = [table.caption, *["Continued."] * (len(parts) - 1)]
    return "\n".join([LATEX_NOTE, *(part.replace("CAPTION", _latex(NUMBERED.sub("", caption)), 1) for part, caption in zip(parts, captions))])


def latex_column_groups(table: Table, columns: list[Column]) -> list[list[Column]]:
    """Columns that fit a page side by side; the first one, which names the row, leads each group."""
    widths = {column.key: _latex_width(table, column) for column in columns}
    name, *others = columns
    groups, left = [[name]], LATEX_WIDTH - widths[name.key]
    for column in others:
        if widths[column.key] > left and len(groups[-1]) > 1:
            groups.append([name])
            left = LATEX_WIDTH - widths[name.key]
        groups[-1].append(column)
        left -= widths[column.key]
    return groups


def _latex_width(table: Table, column: Column) -> float:
    cells = [cells[0] for cells in as_cells(table, [column])]
    return LATEX_LETTER * max(map(len, (*_two_lines(column.head or column.title), *cells))) + LATEX_GAP


def _latex_pages(table: Table) -> list[pd.DataFrame]:
    """Rows that fit the height of a page, with the headings of their muscles and the caption."""
    caption_lines = math.ceil(len(table.caption) / LATEX_CAPTION_LETTERS)
    room = LATEX_HEIGHT - LATEX_HEADS - LATEX_CAPTION_LINE * caption_lines
    starts, left, last = [0], room, None
    for number, muscle in enumerate(_headings(table.rows)):
        needed = LATEX_LINE + LATEX_HEADING * (muscle != last)
        if needed > left:
            starts.append(number)
            left, needed = room, LATEX_LINE + LATEX_HEADING
        left, last = left - needed, muscle
    return [table.rows.iloc[first:end] for first, end in zip(starts, [*starts[1:], len(table.rows)])]


def _latex_part(table: Table, rows: pd.DataFrame, columns: list[Column]) -> str:
    layout = "".join("l" if column.digits is None else "r" for column in columns)
    heads = [_two_lines(column.head or column.title) for column in columns]
    lines = ["\\begin{table*}", "\\centering", "\\footnotesize", "\\setlength{\\tabcolsep}{3pt}", "\\setlength{\\belowcaptionskip}{6pt}", "\\caption{CAPTION}",
             f"\\begin{{tabular}}{{{layout}}}", "\\toprule"]
    lines += [" & ".join(_latex(head[line]) for head in heads) + " \\\\" for line in (0, 1)]
    lines += [] if "muscle" in rows else ["\\midrule"]
    muscle = None
    for name, cells in zip(_headings(rows), as_cells(Table(table.name, "", table.columns, rows, []), columns)):
        if name != muscle:
            muscle = name
            heading = f"\\emph{{{_latex(muscle_label(muscle))}}}"
            lines += ["\\midrule", f"\\multicolumn{{{len(columns)}}}{{l}}{{{heading}}} \\\\"]
        lines.append(" & ".join(_latex(MINUS.sub("\N{MINUS SIGN}", cell)) for cell in cells) + " \\\\")
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}", "\\end{table*}"]) + "\n"


def as_text(table: Table) -> str:
    """Aligned columns for a terminal, two lines of titles, the muscle, where there is one, as a heading over its backends."""
    columns = [column for column in table.columns if column.key in table.shown]
    rows = [[f"  {cells[0]}", *cells[1:]] for cells in as_cells(table, columns)]
    heads = [_two_lines(column.head or column.title) for column in columns]
    widths = [max(len(text) for text in (*head, *(row[i] for row in rows))) for i, head in enumerate(heads)]
    lines = [_aligned([head[line] for head in heads], columns, widths) for line in (0, 1)]
    lines.append("  ".join("-" * width for width in widths))
    muscle = None
    for row, name in zip(rows, _headings(table.rows)):
        if name != muscle:
            lines.append(muscle_label(name))
            muscle = name
        lines.append(_aligned(row, columns, widths))
    return "\n".join(lines)


def _headings(rows: pd.DataFrame) -> list:
    """Muscles of the rows; None of a table without."""
    return list(rows["muscle"]) if "muscle" in rows else [None] * len(rows)


def _aligned(cells: list[str], columns: list[Column], widths: list[int]) -> str:
    parts = [c.ljust(w) if col.digits is None else c.rjust(w) for c, col, w in zip(cells, columns, widths)]
    return "  ".join(parts).rstrip()


def _two_lines(head: str) -> tuple[str, str]:
    first, _, second = head.rpartition("\n")
    return first, second


def as_cells(table: Table, columns: list[Column]) -> list[list[str]]:
    """Texts with the digits that people read."""
    return [[_cell(row[column.key], column) for column in columns] for _, row in table.rows.iterrows()]


def _cell(value, column: Column) -> str:
    if pd.isna(value) or value == "":
        return UNKNOWN
    if column.digits is None:
        return muscle_label(value) if column.key == "muscle" else str(value)
    return as_ratio(value) if column.is_ratio else f"{value:z.{column.digits}f}"


def as_ratio(value: float) -> str:
    """Three significant digits, without an exponent."""
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if 0 < value < 100 else f"{value:.0f}"


def _latex(text: str) -> str:
    return text.translate(LATEX_ESCAPES)
