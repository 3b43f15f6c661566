"""Sentences that hold only while the tables say so. The claim stands before its sentence:

    <!-- claim: budget-lhdl/substeps[scene=lhdl/iliacus].rms_mm falls --> The shape converges.
    <!-- claim: accuracy-lhdl/price_list[target_mm=0.1].ratio < 1 --> It costs less than voxels.

A study that is not in reports/measured is a mistake. Relations over all chosen rows, in the order of the table: `falls`,
`rises` (each value to the next), `< X`, `> X`, `within LOW to HIGH` (each value, bounds included). A sentence whose claim fails has to be written anew."""

import re
from itertools import pairwise

from ..program.cli import Problem
from .measured import Measured
from .selection import chosen_values

FORM = re.compile(r"(?P<values>.+?) (?P<relation>falls|rises|[<>] \S+|within \S+ to \S+)")


def check_claim(measured: Measured, specification: str) -> None:
    """Raises Problem where the measured values don't hold it, or where it is none."""
    match = FORM.fullmatch(specification.strip())
    if match is None:
        raise Problem(f"claim '{specification}': not like STUDY/TABLE[FILTERS].COLUMN falls|rises|< X|> X|within X to Y")
    values = [float(value) for value in chosen_values(measured, match["values"])]
    if not _holds(values, match["relation"].split()):
        told = ", ".join(f"{value:.3g}" for value in values)
        raise Problem(f"claim '{specification}' does not hold for the measured values ({told}): write its sentence anew")


def _holds(values: list[float], relation: list[str]) -> bool:
    name, *words = relation
    if name in ("falls", "rises"):
        sign = 1 if name == "rises" else -1
        return len(values) > 1 and all(sign * (after - before) > 0 for before, after in pairwise(values))
    bounds = [_number(word) for word in words if word != "to"]
    if name == "within":
        return all(bounds[0] <= value <= bounds[1] for value in values)
    return all(value < bounds[0] if name == "<" else value > bounds[0] for value in values)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise Problem(f"claim: '{word}' is no number") from None
