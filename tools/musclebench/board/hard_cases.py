"""Hard cases of a published study, a page each."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from ..publish.measured import Measured
from .bundle import Told
from .page_column import PageColumn


@dataclass
class HardCase:
    """What happens, why it is hard, the bar, and a cell a backend."""

    COLUMNS: ClassVar[list[PageColumn]] = [
        PageColumn("backend", "backend"), PageColumn("verdict", "verdict"), PageColumn("figure", "worst figure"), PageColumn("value", "value", True),
        PageColumn("bar", "bar", True), PageColumn("unit", "unit"), PageColumn("said", "the program said"),
    ]
    name: str
    what: str
    why: str
    bar: str
    cells: list[Told]


def hard_cases(folder: Path) -> list[HardCase]:
    """Of reports/measured/hard-*; a cell to which the case does not apply is left out."""
    measured = Measured(folder.parent)
    cases, cells = (measured.table(f"{folder.name}/{name}").astype(object) for name in ("cases", "cells"))
    cells = cells.where(cells.notna(), "")
    found = []
    for case in cases.where(cases.notna(), "").to_dict("records"):
        mine = cells[(cells["case"] == case["case"]) & (cells["verdict"] != "not applicable")]
        rows = [{key: f"{value:.4g}" if isinstance(value, float) else value for key, value in cell.items()} for cell in mine.to_dict("records")]
        found.append(HardCase(case["case"], case["what"], case["why"], str(case["bar"]).rstrip("."), rows))
    return found
