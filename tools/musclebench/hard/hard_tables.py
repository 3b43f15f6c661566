"""What a page shows of the hard cases: the matrix, what is beyond its bar, what is not asked and why, each case in words."""

import math

import pandas as pd

from ..tables.table_formats import Column, markdown_rows
from .causes import read_causes

SHOWN = {"holds": "holds", "breaks": "**BREAKS**", "refused": "refused", "not applicable": "-"}
BEYOND_COLUMNS = [Column("case", "case"), Column("backend", "backend"), Column("verdict", ""), Column("figure", "figure"),
                  Column("measured", "measured"), Column("bar", "bar"), Column("said", "what the program says")]
MOST_OF_A_PAGE = 5
CAUSE_COLUMNS = [Column("why", "cause"), Column("count", "cells"), Column("cases", "cases")]
UNASKED_COLUMNS = [Column("backends", "backend"), Column("said", "why"), Column("cases", "cases")]


def matrix(cells: pd.DataFrame, texts_in: str = "") -> str:
    """Cases down, each linked to its text (`texts_in`: the page that has them); backends across."""
    backends = list(dict.fromkeys(cells["backend"]))
    columns = [Column("case", "case"), *(Column(name, name) for name in backends)]
    rows = [{"case": _link(case, texts_in), **{cell.backend: SHOWN[cell.verdict] for cell in row.itertuples()}}
            for case, row in cells.groupby("case", sort=False)]
    counts = cells["verdict"].value_counts()
    totals = ", ".join(f"{counts.get(verdict, 0)} {words}" for verdict, words in (
        ("holds", "hold"), ("breaks", "break"), ("refused", "refused"), ("not applicable", "not applicable")))
    return f"{markdown_rows(columns, pd.DataFrame(rows))}\n\n{totals}."


def as_text(cells: pd.DataFrame) -> str:
    """For a terminal."""
    shown = cells.assign(verdict=cells["verdict"].map(SHOWN).str.strip("*"))
    wide = shown.pivot(index="case", columns="backend", values="verdict")
    ordered = wide.loc[list(dict.fromkeys(cells["case"])), list(dict.fromkeys(cells["backend"]))].fillna("")
    return ordered.rename_axis(index=None, columns=None).to_string()


def counts(cells: pd.DataFrame) -> str:
    """How many cells of each backend hold, break, were refused or are not asked."""
    by_backend = pd.crosstab(cells["backend"], cells["verdict"]).reindex(index=dict.fromkeys(cells["backend"]), columns=SHOWN, fill_value=0)
    columns = [Column("backend", "backend"), *(Column(verdict, verdict) for verdict in SHOWN)]
    return markdown_rows(columns, by_backend.rename_axis(columns=None).reset_index())


def causes(cells: pd.DataFrame, texts_in: str = "") -> str:
    """Of the cells that break: what is known of why, the cause of the most cells first."""
    broken = set(zip(*(cells.loc[cells["verdict"] == "breaks", key] for key in ("case", "backend"))))
    rows = []
    for cause in read_causes():
        found = [case for case, backends in cause.cells.items() for backend in backends if (case, backend) in broken]
        rows += [{"why": cause.why, "count": len(found), "cases": ", ".join(_link(case, texts_in) for case in dict.fromkeys(found))}] if found else []
    return markdown_rows(CAUSE_COLUMNS, pd.DataFrame(sorted(rows, key=lambda row: -row["count"]), columns=["why", "count", "cases"]))


def beyond(cells: pd.DataFrame, texts_in: str = "") -> str:
    """Each cell that breaks or was refused, with the figure farthest beyond its bar."""
    rows = cells[cells["verdict"].isin(["breaks", "refused"])]
    if rows.empty:
        return "Every cell holds."
    shown = [{"case": _link(cell.case, texts_in), "backend": cell.backend, "verdict": SHOWN[cell.verdict],
              "figure": _text(cell.figure), "measured": _number(cell.value, cell.unit) if _text(cell.figure) else "",
              "bar": _number(cell.bar, cell.unit) if _text(cell.figure) else "", "said": _text(cell.said)}
             for cell in rows.sort_values("verdict", kind="stable").itertuples()]
    return markdown_rows(BEYOND_COLUMNS, pd.DataFrame(shown))


def unasked(cells: pd.DataFrame) -> str:
    """Why cells are not applicable; backends that give one reason for the same cases share a row."""
    every = list(dict.fromkeys(cells["case"]))
    rows = cells[cells["verdict"] == "not applicable"]
    by_backend = rows.groupby(["said", "backend"], sort=False)["case"].agg(tuple).reset_index()
    shared = by_backend.groupby(["said", "case"], sort=False)["backend"].agg(", ".join).reset_index()
    shown = [{"backends": row.backend, "said": _text(row.said), "cases": _few(row.case, every)}
             for row in shared.itertuples()]
    return markdown_rows(UNASKED_COLUMNS, pd.DataFrame(shown, columns=["backends", "said", "cases"]))


def texts(cases: pd.DataFrame) -> str:
    """A heading a case, to which the matrix links."""
    parts = []
    for case in cases.itertuples():
        scene = f" Scene: `{case.scene}`." if _text(case.scene) else ""
        because = _text(getattr(case, "left_out_because", ""))
        left_out = f" **Sane figures left out:** {because}." if because else ""
        parts.append(f"### {case.case}\n\n{_text(case.what)} {_text(case.why)} **Bar:** {_text(case.bar)}.{left_out}{scene}")
    return "\n\n".join(parts)


def _few(cases: tuple[str, ...], every: list[str]) -> str:
    """The others are named where they are fewer."""
    others = [case for case in every if case not in cases]
    if len(others) >= len(cases):
        return ", ".join(cases)
    return f"all but {', '.join(others)}" if others else "all"


def not_held(cells: pd.DataFrame, backend: str, reference: str, texts_in: str = "") -> str:
    """What a backend does not hold, but for cases that another one breaks or is refused by the same figure."""
    theirs = cells[(cells["backend"] == reference) & (cells["verdict"] != "holds")].set_index("case")["figure"]
    rows = cells[cells["backend"] == backend]
    rows = rows[[row.case not in theirs or _text(theirs[row.case]) != _text(row.figure) for row in rows.itertuples()]]
    if not rows["verdict"].isin(["breaks", "refused"]).any():
        return f"It holds all cases that can be asked of it, but for those that `{reference}` does not hold by the same figure."
    every = rows[rows["verdict"].isin(["breaks", "refused"])].sort_values("verdict", kind="stable")
    few, more = every.iloc[:MOST_OF_A_PAGE], len(every) - MOST_OF_A_PAGE
    last = f"\n| {more} more: [breaks.md](../hard_cases/breaks.md) | | | | | | |" if more > 0 else ""
    return f"{beyond(few, texts_in)}{last}"


def _link(case: str, texts_in: str) -> str:
    return f"[{case}]({texts_in}#{case})"


def _text(value) -> str:
    """Without what a table of Markdown would take for its own."""
    return value.replace("|", "/").replace("\n", " ") if isinstance(value, str) else ""


def _number(value: float, unit) -> str:
    return f"{'no number' if math.isnan(value) else f'{value:.3g}'} {_text(unit)}".strip()
