"""Tables and figures that a study has written already: they are shown as they are, nothing is computed again."""

import re
from pathlib import Path

import pandas as pd

from ..figures.style import muscle_label
from .parts import Axis, Chart, TablePart

BOLD = re.compile(r"\*\*(.+?)\*\*")


def read_rows(path: Path) -> pd.DataFrame:
    """Only an empty cell is unknown: a backend may be named as what pandas takes for unknown, too."""
    return pd.read_csv(path, keep_default_na=False, na_values=[""])


def written_table(folder: Path, name: str, title: str) -> list[TablePart]:
    """Of NAME.csv, with the digits, titles and caption of NAME.md where it stands beside it; nothing where there is none."""
    source = folder / f"{name}.csv"
    if not source.is_file():
        return []
    text = folder / f"{name}.md"
    caption, heads, is_number, lines = _of_markdown(text.read_text()) if text.is_file() else _of_rows(read_rows(source))
    groups: list[tuple[str, list[list[str]]]] = []
    has_muscle = heads[0] == "muscle"
    for cells in lines:
        group = cells[0] if has_muscle else ""
        if not groups or groups[-1][0] != group:
            groups.append((group, []))
        groups[-1][1].append(cells[1:] if has_muscle else cells)
    first = 1 if has_muscle else 0
    return [TablePart(name, title, caption, heads[first:], is_number[first:], groups, source.read_text())] if lines else []


def _of_markdown(text: str) -> tuple[str, list[str], list[bool], list[list[str]]]:
    """As tables.table_formats writes it."""
    caption, _, table = text.partition("\n\n")
    heads, rule, *lines = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table.strip().splitlines()]
    return caption, heads, [cell.endswith(":") for cell in rule], lines


def _of_rows(rows: pd.DataFrame) -> tuple[str, list[str], list[bool], list[list[str]]]:
    is_number = [pd.api.types.is_numeric_dtype(rows[column]) for column in rows]
    lines = [[_cell(value, column) for column, value in zip(rows, row)] for row in rows.itertuples(index=False)]
    return "", [column.replace("_", " ") for column in rows], is_number, lines


def _cell(value, column: str) -> str:
    if pd.isna(value):
        return "-"
    if isinstance(value, float):
        return f"{value:.4g}"
    return muscle_label(value) if column == "muscle" else str(value)


HOLLOW = " Hollow points at the top can't be asked about single points: their error is not known."


def pareto_chart(folder: Path, name: str, error_title: str, exact_mm: float, exact_words: str) -> list[Chart]:
    """Of NAME.csv, the points that the study drew, and the paragraphs of NAME.md."""
    source = folder / f"{name}.csv"
    if not source.is_file():
        return []
    rows = read_rows(source)
    rows.insert(0, "muscle", [panel.split("/")[-1] for panel in rows["panel"]])
    rows["structure_mb"] = rows["structure_bytes"] / 1e6
    if "spoken" not in rows:  # of a study before its points had names for readers
        rows["spoken"] = rows["configuration"]
    if "is_substitute" not in rows:
        rows["is_substitute"] = False
    for column in ("is_control", "is_wrong", "is_substitute", "on_front"):
        rows[column] = rows[column].astype(int)
    title, *paragraphs = caption_of(folder, name)
    below = "below 1 nm" if error_title.endswith("(mm)") else f"below {exact_mm:.6f} %"
    return [Chart(name, title, "Left is fast, low is accurate. A point is a setting, a curve goes over a backend's resolutions. The grey line is the "
                  "Pareto front: no other setting is both faster and more accurate. Crosses mark settings whose contacts are wrong."
                  + (HOLLOW if rows["is_substitute"].any() else ""),
                  "points", rows, Axis("time_ms", "collision time a frame (ms)", True), Axis("error_mm", error_title, True),
                  {"structure_mb": "structures (MB)", "frames": "frames", "repetitions": "repetitions"},
                  {"exact_mm": exact_mm, "exact_words": f"{exact_words} ({below})"}, more=paragraphs)]


def caption_of(folder: Path, name: str) -> list[str]:
    """The title and the paragraphs of NAME.md, as figures.captions writes it."""
    path = folder / f"{name}.md"
    texts = path.read_text().strip().split("\n\n") if path.is_file() else [name.replace("_", " ")]
    return [BOLD.sub(r"\1", text) for text in texts]
