"""The matrix as a row a cell, and the cases as `musclebench hard --list` tells them."""

import math
import re

import pandas as pd

from ..program.cli import Problem

CELL_COLUMNS = ["case", "backend", "verdict", "figure", "value", "bar", "unit", "said"]
CASE_COLUMNS = ["case", "what", "why", "bar", "left_out_because", "scene"]
LISTED = re.compile(r"(?P<case>\S+)\n  (?P<what>.+)\n  (?P<why>.+)\n  Bar: (?P<bar>.+)\.\n"
                    r"(?:  Sane figures left out: (?P<left_out_because>.+)\.\n)?(?:  Scene: (?P<scene>\S+)\n)?")


def cells_of(rows: pd.DataFrame) -> pd.DataFrame:
    """`rows`: those of matrix.csv, one a figure. Of each cell the figure farthest beyond its bar, or nearest to it."""
    numbers = rows.assign(value=pd.to_numeric(rows["value"], errors="coerce"), bar=pd.to_numeric(rows["bar"], errors="coerce"))
    shares = pd.Series([_share_of_bar(value, bar) for value, bar in zip(numbers["value"], numbers["bar"])], numbers.index)
    worst = shares.groupby([rows["case"], rows["backend"]], sort=False).idxmax()
    return numbers.loc[worst].rename(columns={"detail": "said"})[CELL_COLUMNS].reset_index(drop=True)


def _share_of_bar(value: float, bar: float) -> float:
    """1: at its bar. As the program orders figures: a bar of 0 is for counts, and no number is the worst."""
    if math.isnan(value):
        return math.inf
    if bar > 0:
        return value / bar
    return 1 + value if value > 0 else 0.0


def cases_of(listed: str) -> pd.DataFrame:
    found = list(LISTED.finditer(listed))
    if not found or "".join(match.group(0) for match in found) != listed:
        raise Problem("these tools cannot read the cases of 'hard --list'; use tools and program of the same version")
    return pd.DataFrame([match.groupdict("") for match in found], columns=CASE_COLUMNS)
