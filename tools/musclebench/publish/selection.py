"""Single numbers out of measured tables, as a marker names them: `paper-lhdl/table_2_times[muscle=iliacus].ratio`."""

import re

import pandas as pd

from ..program.cli import Problem
from ..results.disturbance import MARK
from ..tables.table_formats import as_ratio
from .measured import Measured

FORM = re.compile(
    r"(?P<table>[\w-]+/\w+)(\[(?P<filters>[^\]]*)\])?\.(?P<column>\w+)( (?P<pick>min|max|range|sum|count))?"
    r"( /(?P<unit>[\d.e-]+))?( (?P<format>\.\d[fg]))?")


def value_text(measured: Measured, specification: str) -> str:
    """Three digits unless a format such as .1f is told; of several rows the smallest and the largest, or how many they are
    (`count`). `/1e6`: in units of that many. Of what timed out a row is empty: its name has to be filtered out, else one
    muscle's figure passes for all."""
    match = _parsed(specification)
    if match["pick"] == "count":
        return str(len(chosen_rows(measured.table(match["table"]), match["filters"] or "", specification)))
    return _text(_chosen(measured, match, specification), match["pick"] or "range", match["format"])


def chosen_values(measured: Measured, specification: str) -> pd.Series:
    """The values that such a marker names, in the order of the table; at least one, and none that is missing. A marker
    that picks one of several, or a format, is refused: all are compared."""
    match = _parsed(specification)
    if match["pick"] or match["format"]:
        raise Problem(f"claim about '{specification}': all values are compared; filter rows instead of "
                      f"'{match['pick'] or match['format']}'")
    return _chosen(measured, match, specification)


def _parsed(specification: str) -> re.Match:
    match = FORM.fullmatch(specification.strip())
    if match is None:
        raise Problem(f"value '{specification}': not like STUDY/TABLE[COLUMN=VALUE,...].COLUMN [min|max|range|sum|count] "
                      "[/1e6] [.2f]")
    return match


def _chosen(measured: Measured, match: re.Match, specification: str) -> pd.Series:
    rows = chosen_rows(measured.table(match["table"]), match["filters"] or "", specification)
    if match["column"] not in rows:
        raise Problem(f"value '{specification}': the table has no column '{match['column']}'; it has "
                      f"{', '.join(rows.columns)}")
    values = rows[match["column"]]
    if values.isna().all():
        raise Problem(f"value '{specification}': no row of the table has it")
    if values.isna().any():
        raise Problem(f"value '{specification}': {values.isna().sum()} of its {len(values)} rows have none; filter for the "
                      "others by name, and name them in the sentence")
    return values / float(match["unit"]) if match["unit"] else values


def chosen_rows(rows: pd.DataFrame, filters: str, specification: str) -> pd.DataFrame:
    """Filters as `muscle=iliacus|psoas,threads=1`."""
    for one in filter(None, (part.strip() for part in filters.split(","))):
        column, equals, wanted = one.partition("=")
        if not equals or column not in rows:
            raise Problem(f"'{specification}': no column '{column}'; there are {', '.join(rows.columns)}")
        chosen = [f"{float(word):g}" if _is_number(word) else word for word in wanted.split("|")]
        values = rows[column].map(plain)
        rows = rows[values.isin(chosen)]
    return rows


def plain(value) -> str:
    """As filters name it: without the mark of a disturbed run."""
    return f"{value:g}" if isinstance(value, float) else str(value).removesuffix(MARK)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _text(values: pd.Series, pick: str, form: str | None) -> str:
    if not pd.api.types.is_numeric_dtype(values):
        return ", ".join(dict.fromkeys(map(str, values)))

    def told(value: float) -> str:
        return f"{value:{form}}" if form else as_ratio(value)

    if pick != "range":
        return told(getattr(values, pick)())
    low, high = told(values.min()), told(values.max())
    return low if low == high else f"{low} to {high}"
