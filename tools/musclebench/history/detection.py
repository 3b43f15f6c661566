"""What changed over the nights of one machine.

A time has two parts: what all cases share in a night, which is the machine's or that of code that all of them run, and what
is the case's own. Both are series of logarithms of a night's lower quartile, and each is searched for change points."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ..comparison.comparison_report import shown
from ..comparison.metrics import COUNTER, EXACT, METRICS, TIME
from .change_points import ChangePoint, change_points
from .history import Finding

LEVEL = 0.001  # of any false alarm in the series of a night: a month looks at them thirty times
WINDOW = 60  # nights that are looked at; older ones tell little of the machine of today
FEWEST_NIGHTS = 4
FEWEST_CASES = 4  # that tell what they share
SAME_STEP = 2  # nights; a change point may move by so many when later nights become known
ALL_CASES = "all cases"
CHANGE_POINT = "change point"  # found by it, some nights later
GONE = "no run of it"
HARD = "hard/"  # begins the names of cells of the matrix
COUNTED_ALONE = "-counted"  # ended the names of cases of older nights, whose instructions were counted


def step_findings(measures: pd.DataFrame) -> list[Finding]:
    """Steps of times and counters. `measures`: of History.measures, of one machine."""
    found = []
    all_series = _series(measures)
    for (case, metric), series in all_series.items():
        # The smallest change of the rule counts, either way.
        smallest = np.log1p(METRICS[metric].smallest)
        for point in change_points(series.to_numpy(), LEVEL / len(all_series), smallest):
            found.append(_finding(case, metric, series, point, measures))
    return found


def answer_findings(measures: pd.DataFrame) -> list[Finding]:
    """Answers of the last night that are not those of the night before that had them."""
    return [Finding(case, metric, night, "not the same", before["text"], after["text"])
            for case, metric, night, before, after in _last_two(measures, EXACT) if before["text"] != after["text"]]


def counter_findings(measures: pd.DataFrame) -> list[Finding]:
    """Counters that did not vary in the night before nor in the last, but from one to the other: found the same night."""
    found = []
    for case, metric, night, before, after in _last_two(measures, COUNTER):
        smallest = METRICS[metric].smallest
        varied = any(row["variation"] > smallest / 10 for row in (before, after))  # false where one run tells none
        if not varied and before["value"] > 0 and abs(after["value"] / before["value"] - 1) >= smallest:
            told = (shown(row["value"], METRICS[metric]) for row in (before, after))
            found.append(Finding(case, metric, night, "counted", *told, after["value"] / before["value"]))
    return found


def gone_findings(measures: pd.DataFrame) -> list[Finding]:
    """Cases of the night before that the last night has not. Cells of the matrix of hard cases only where it was run."""
    nights = list(dict.fromkeys(measures["night"]))
    if len(nights) < 2:
        return []
    before, last = ({case.removesuffix(COUNTED_ALONE) for case in measures["case"][measures["night"] == night]} for night in nights[-2:])
    has_matrix = any(case.startswith(HARD) for case in last)
    return [Finding(case, "status", int(nights[-1]), GONE, "measured", "")
            for case in sorted(before - last) if has_matrix or not case.startswith(HARD)]


def _last_two(measures: pd.DataFrame, kind: str) -> Iterator[tuple[str, str, int, dict, dict]]:
    """(case, metric, last night, row before, row of it) of what the last night has and an earlier one had."""
    if measures.empty:
        return
    last = measures["night"].iloc[-1]
    for (case, metric), rows in measures[measures["kind"] == kind].groupby(["case", "metric"], sort=False):
        if len(rows) > 1 and rows["night"].iloc[-1] == last:
            before, after = rows.iloc[-2:].to_dict("records")
            yield case, metric, int(last), before, after


def new_ones(found: list[Finding], known: list[Finding], nights: list[int]) -> list[Finding]:
    """Without the change points that were reported before: of the same case and metric, at most SAME_STEP nights away. What
    was found the same night is new."""
    order = {night: number for number, night in enumerate(nights)}
    steps: dict[tuple[str, str], list[int]] = {}
    for one in known:
        steps.setdefault((one.case, one.metric), []).append(order.get(one.changed_in, -10 * SAME_STEP))
    return [one for one in found if one.found_by != CHANGE_POINT or all(
        abs(order[one.changed_in] - step) > SAME_STEP for step in steps.get((one.case, one.metric), []))]


def shared_part(table: pd.DataFrame) -> pd.Series:
    """Of logarithms, a row a night and a column a case: by how much the cases together are above their medians."""
    if len(table.columns) < FEWEST_CASES:
        return pd.Series(0.0, table.index)
    return (table - table.median()).median(axis=1)


def _series(measures: pd.DataFrame) -> dict[tuple[str, str], pd.Series]:
    """{(case, metric): logarithms by night}"""
    found = {}
    looked_at = list(dict.fromkeys(measures["night"]))[-WINDOW:]
    numbers = measures[(measures["kind"] != EXACT) & (measures["quartile"] > 0) & measures["night"].isin(looked_at)]
    for metric, rows in numbers.groupby("metric", sort=False):
        table = np.log(rows.pivot(index="night", columns="case", values="quartile"))
        table = table.reindex([night for night in looked_at if night in table.index])
        if METRICS[metric].kind == TIME and len(table.columns) >= FEWEST_CASES:
            shared = shared_part(table)
            found[ALL_CASES, metric] = shared
            table = table.sub(shared, axis=0)
        found |= {(case, metric): table[case].dropna() for case in table}
    return {key: series for key, series in found.items() if len(series) >= FEWEST_NIGHTS}


def _finding(case: str, metric: str, series: pd.Series, point: ChangePoint, measures: pd.DataFrame) -> Finding:
    ratio, low, high = (float(np.exp(value)) for value in (point.difference, point.low, point.high))
    rows = measures[(measures["case"] == case) & (measures["metric"] == metric)].set_index("night")["value"]
    told = ["", ""] if case == ALL_CASES else [shown(rows.loc[part].median(), METRICS[metric])
                                               for part in (series.index[:point.index], series.index[point.index:])]
    return Finding(case, metric, int(series.index[point.index]), CHANGE_POINT, *told, ratio, low, high, point.chance)
