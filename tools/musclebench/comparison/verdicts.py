"""What changed from one set of results to another. Each process is one sample: frames of a process are too much alike to
count as many.

Times and counters have changed where a test says so (Holm's procedure over all that vary), the 95 % interval of the ratio
leaves out 1, and the ratio is at least the metric's smallest change from 1. The test is Mann and Whitney's U; of runs that
were interleaved the surer one of it and Yuen's test of the pairs, at twice its p. Answers have changed where they are not the
same."""

import math
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from ..results import samples as statistics
from ..results.disturbance import disturbed
from ..results.statistics import Estimate
from .metrics import EXACT, METRICS, TIME, Metric
from .result_set import ResultSet, Sample, match_frames

LEVEL = 0.01  # of any false alarm in a comparison
FEWEST_RUNS = 5  # on either side; fewer can't be told from noise
TESTS = 2  # of which the surer one is taken
WIDEST = 1.25  # upper end over lower end of an interval that still says something
FEWEST_FOR_MACHINE = 4  # cases; the median of fewer is that of one backend
PROGRAM_SIDES = ("before", "after")
CHANGED = ("slower", "faster", "more", "fewer", "changed", "gone")


@dataclass
class Row:
    case: str
    metric: Metric
    before: float | str
    after: float | str
    verdict: str  # one of CHANGED, or same, unclear, too few runs, not trusted, new
    ratio: Estimate = field(default_factory=Estimate.unknown)  # after over before
    chance: float = float("nan")  # p by Holm
    runs: int = 0  # of the side with fewer
    paired_chance: float = float("nan")  # p of the pairs, where runs were interleaved
    why: str = ""  # it is not trusted
    is_certain: bool = False  # a counter that is the same in all runs of a side: chance has no part in it

    @property
    def is_change(self) -> bool:
        return self.verdict in CHANGED

    @property
    def is_tested(self) -> bool:
        """Whether it could alarm by chance."""
        return self.metric.kind != EXACT and not self.is_certain

    @property
    def is_trusted(self) -> bool:
        return not self.why


@dataclass
class Comparison:
    before: ResultSet
    after: ResultSet
    rows: list[Row]
    is_interleaved: bool
    machine: dict[str, float] = field(default_factory=dict)  # {metric: common factor that was taken out}
    disturbed: dict[str, str] = field(default_factory=dict)  # {run: why}

    @property
    def changes(self) -> list[Row]:
        return [row for row in self.rows if row.is_change]

    @property
    def runs(self) -> int:
        """Of the case with the fewest times on either side; 0: none has any."""
        return min((len(side) for case in self.before.cases.keys() & self.after.cases.keys() for one in (self.before, self.after)
                    if not (side := numbers(one.cases[case], "frame_ns")).empty), default=0)

    @property
    def fewest_runs(self) -> int:
        """That could show a change, for all figures together."""
        return fewest_runs(sum(row.is_tested for row in self.rows))

    @property
    def is_one_program(self) -> bool:
        """What times and counters differ by is then not the program's."""
        return self.before.programs() == self.after.programs() and len(self.before.programs()) == 1


def compare(before: ResultSet, after: ResultSet, with_times: bool = True) -> Comparison:
    match_frames(before, after)
    is_interleaved = _invocations(before) == _invocations(after) != {""}
    busy = disturbed({f"{side}/{sample.run.folder.name}": sample.run.record
                      for side, one in zip(PROGRAM_SIDES, (before, after)) for sample in one.samples})
    found = Comparison(before, after, [], is_interleaved, disturbed=busy)
    if with_times and not is_interleaved:
        found.machine = _machine_factors(before, after)
    for case in dict.fromkeys([*before.cases, *after.cases]):
        found.rows += _rows_of(case, found, with_times)
    _judge(found)
    return found


def fewest_runs(tested: int) -> int:
    """Of a side, with which complete separation of one of so many figures would be as unlikely as LEVEL by one of TESTS."""
    return next(runs for runs in range(FEWEST_RUNS, 100) if TESTS * 2 * tested / math.comb(2 * runs, runs) < LEVEL)


def numbers(samples: list[Sample], metric: str) -> pd.Series:
    """By invocation and repetition, so that what was interleaved is paired."""
    values = {(sample.invocation, sample.repetition): sample.values[metric] for sample in samples if metric in sample.values}
    return pd.Series(values, dtype=float)


def _rows_of(case: str, comparison: Comparison, with_times: bool) -> list[Row]:
    sides = comparison.before.cases.get(case, []), comparison.after.cases.get(case, [])
    if not all(sides):
        is_gone = bool(sides[0])
        return [Row(case, METRICS["status"], *(("measured", "") if is_gone else ("", "measured")),
                    "gone" if is_gone else "new")]
    rows = []
    for metric in METRICS.values():
        if metric.kind == TIME and not with_times:
            continue
        row = _exact_row(case, metric, sides) if metric.kind == EXACT else _number_row(case, metric, sides, comparison)
        rows += [row] if row else []
    return rows


def _exact_row(case: str, metric: Metric, sides) -> Row | None:
    told = [different_values(metric, side) for side in sides]
    if not all(told) or (metric.name == "status" and _only_one_was_judged(told, sides)):
        return None  # one of them was not judged
    before, after = (values[0] if len(values) == 1 else " or ".join(map(str, values)) for values in told)
    return Row(case, metric, before, after, "same" if told[0] == told[1] and len(told[0]) == 1 else "changed")


def different_values(metric: Metric, side: list[Sample]) -> list:
    """Of an answer. Suspect is what the Referee finds: runs beside it that nobody judged are ok all the same."""
    values = {sample.values[metric.name] for sample in side if metric.name in sample.values}
    if metric.name == "status" and "suspect" in values and not any(sample.run.status == "ok" and sample.is_judged for sample in side):
        values.discard("ok")
    return sorted(values, key=str)


def _only_one_was_judged(told: list[list], sides) -> bool:
    return sorted(map(tuple, told)) == [("ok",), ("suspect",)] and not all(any(sample.is_judged for sample in side) for side in sides)


def _number_row(case: str, metric: Metric, sides, comparison: Comparison) -> Row | None:
    before, after = (numbers(side, metric.name) for side in sides)
    if before.empty or after.empty:
        return None
    after = after / comparison.machine.get(metric.name, 1.0)
    row = Row(case, metric, float(before.median()), float(after.median()), "same")
    if metric.is_deterministic and before.nunique() == after.nunique() == 1:
        row.ratio = statistics.exact(row.after / row.before) if row.before else Estimate.unknown()
        row.chance, row.is_certain = 1.0 if row.before == row.after else 0.0, True
        return row
    row.chance = statistics.mann_whitney(after, before)
    row.ratio = statistics.ratio(after, before) if comparison.is_interleaved else statistics.unpaired_ratio(after, before)
    row.paired_chance = statistics.trimmed_pairs(after, before) if comparison.is_interleaved else float("nan")
    row.runs = min(len(before), len(after))
    row.why = _distrust(row, sides, comparison)
    return row


def _distrust(row: Row, sides, comparison: Comparison) -> str:
    if row.runs < FEWEST_RUNS:
        return f"{row.runs} runs, {FEWEST_RUNS} are the fewest"
    if not row.ratio.high <= WIDEST * row.ratio.low:
        return "varies too much"
    names = {f"{side}/{sample.run.folder.name}" for side, samples in zip(PROGRAM_SIDES, sides) for sample in samples}
    if row.metric.kind == TIME and not comparison.is_interleaved and names & comparison.disturbed.keys():
        return "the machine was busy"
    return ""


def _judge(comparison: Comparison) -> None:
    tested = [row for row in comparison.rows if row.is_tested and not math.isnan(row.chance)]
    for row in tested:
        if row.runs >= comparison.fewest_runs and not math.isnan(row.paired_chance):
            row.chance = min(1.0, TESTS * min(row.chance, row.paired_chance))
    for row, chance in zip(tested, statistics.holm([row.chance for row in tested])):
        row.chance = chance
    for row in tested + [row for row in comparison.rows if row.is_certain]:
        row.verdict = _verdict(row)
        if row.is_change and comparison.is_one_program:
            row.verdict, row.why = "not trusted", "the same program"


def _verdict(row: Row) -> str:
    if row.why:
        return "too few runs" if "runs" in row.why else "not trusted"
    value, low, high = row.ratio.value, row.ratio.low, row.ratio.high
    if math.isnan(value):
        return "same" if row.before == row.after else "more"  # than none
    smallest = 1 + row.metric.smallest
    if row.chance < LEVEL and (value >= smallest and low > 1 or value <= 1 / smallest and high < 1):
        words = ("slower", "faster") if row.metric.kind == TIME else ("more", "fewer")
        return words[0] if value > 1 else words[1]
    return "same" if low > 1 / smallest and high < smallest else "unclear"


def _machine_factors(before: ResultSet, after: ResultSet) -> dict[str, float]:
    """By how much all cases together take longer: between two invocations that is the machine's, as far as one can tell.
    Who changed what all backends share has to interleave."""
    factors = {}
    for metric in (metric.name for metric in METRICS.values() if metric.kind == TIME):
        medians = [(numbers(before.cases[case], metric).median(), numbers(after.cases[case], metric).median())
                   for case in before.cases.keys() & after.cases.keys()]
        ratios = [later / earlier for earlier, later in medians if earlier > 0 and later > 0]
        if len(ratios) >= FEWEST_FOR_MACHINE:
            factors[metric] = float(np.median(ratios))
    return factors


def _invocations(one: ResultSet) -> set[str]:
    return {sample.invocation for sample in one.samples}
