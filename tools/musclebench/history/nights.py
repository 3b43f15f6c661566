"""A night's results as rows of the history."""

from pathlib import Path

import pandas as pd

from ..comparison.metrics import EXACT, METRICS, Metric
from ..comparison.result_set import ResultSet, Sample
from ..comparison.verdicts import different_values, numbers
from ..hard.cells import cells_of
from ..program.cli import Problem
from ..program.release_build import RELEASE, refusal
from ..results import samples as statistics
from ..results.disturbance import disturbed
from ..results.statistics import percentile
from .detection import HARD
from .history import Measure, Night


def night_of(results: ResultSet, started: str) -> Night:
    """Refused where times would say nothing."""
    told = {key: results.told(*key) for key in (("build", "git"), ("build", "compiler"), ("build", "type"),
                                                ("machine", "cpu"), ("machine", "cores"))}
    git, compiler, kind, cpu, cores = (values[0] if values else "unknown" for values in told.values())
    if kind != RELEASE:
        raise refusal(results.name, kind, "")
    busy = disturbed({sample.run.folder.name: sample.run.record for sample in results.samples})
    programs = sorted(results.programs())
    return Night(started, str(git), programs[0] if programs else "", f"{cpu}, {cores} cores", str(compiler), len(busy),
                 len(results.samples))


def measures_of(results: ResultSet) -> list[Measure]:
    """A row a case and metric that was measured."""
    return [measure for case, samples in results.cases.items() for metric in METRICS.values()
            if (measure := _measure(case, metric, samples)) is not None]


def cells_measures(matrix: Path) -> list[Measure]:
    """The verdicts of `musclebench hard --out`: a row a cell."""
    try:
        cells = cells_of(pd.read_csv(matrix, keep_default_na=False))
    except (OSError, ValueError, KeyError) as problem:
        raise Problem(f"{matrix}: no matrix of hard cases ({problem})") from None
    return [Measure(f"{HARD}{cell.case}/{cell.backend}", "verdict", EXACT, "", text=cell.verdict)
            for cell in cells.itertuples()]


def _measure(case: str, metric: Metric, samples: list[Sample]) -> Measure | None:
    if metric.kind == EXACT:
        told = different_values(metric, samples)
        text = " or ".join(map(str, told))
        return Measure(case, metric.name, metric.kind, metric.unit, text=text, runs=len(samples)) if told else None
    values = numbers(samples, metric.name)
    if values.empty:
        return None
    median = statistics.median(values)
    low, high = (None if pd.isna(end) else end for end in (median.low, median.high))
    variation = statistics.variation(values)
    return Measure(case, metric.name, metric.kind, metric.unit, median.value, None, low, high,
                   float(percentile(values, 25)), len(values), None if pd.isna(variation) else variation)
