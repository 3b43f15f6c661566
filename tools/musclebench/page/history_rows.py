"""The rows of the chart of a history: one a night, case and metric, in units that people read."""

import numpy as np
import pandas as pd

from ..comparison.metrics import EXACT, METRICS, TIME
from ..history.detection import ALL_CASES, FEWEST_CASES, shared_part
from ..history.history import Finding, Night
from .changes import ratio_words

SCALES = {"ns": ((1e9, "s"), (1e6, "ms"), (1e3, "us")), "bytes": ((1e6, "MB"), (1e3, "kB")),
          "": ((1e9, "billions"), (1e6, "millions"), (1e3, "thousands"))}
NUMBERS = ["value", "low", "high"]


def night_rows(measures: pd.DataFrame, nights: list[Night], changes: list[Finding], commits: dict[int, str]) -> pd.DataFrame:
    """Columns started, commit, case, metric, value, low, high, unit, level (median between two changes) and, in the first
    night of a change, ratio, changed and between (empty in others). `measures`: of History.measures; `commits`: {first
    night of a change: the commits before it, in words}."""
    numbers = measures[(measures["kind"] != EXACT) & measures["value"].notna()]
    series = [_in_units(rows, unit) for (_, _, unit), rows in numbers.groupby(["case", "metric", "unit"], sort=False)]
    series += _shared(numbers)
    if not series:
        return pd.DataFrame(columns=["started", "commit", "case", "metric", *NUMBERS, "unit", "level", "ratio", "changed", "between"])
    found: dict[tuple[str, str], dict[int, Finding]] = {}
    for change in changes:
        found.setdefault((change.case, change.metric), {})[change.changed_in] = change
    known = {night.id: night for night in nights}
    rows = pd.concat([_with_changes(one, found.get((one["case"].iloc[0], one["metric"].iloc[0]), {}), commits) for one in series],
                     ignore_index=True)
    rows.insert(0, "started", [known[night].started for night in rows["night"]])
    rows.insert(1, "commit", [known[night].git for night in rows["night"]])
    return rows.drop(columns="night")


def metric_name(metric: str) -> str:
    """'collision' of collision_ns."""
    kind = METRICS[metric].kind if metric in METRICS else ""
    return metric.removesuffix("_ns" if kind == TIME else "_bytes").replace("_", " ")


def _in_units(rows: pd.DataFrame, unit: str) -> pd.DataFrame:
    middle = rows["value"].median()
    scale, shown = next((one for one in SCALES.get(unit, ()) if middle >= one[0]), (1.0, unit))
    return rows[["night", "case", "metric"]].join(rows[NUMBERS] / scale).assign(unit=shown)


def _shared(numbers: pd.DataFrame) -> list[pd.DataFrame]:
    """What all cases share in a night, over its median: where a change of the machine, or of code that all run, is seen."""
    found = []
    times = numbers[(numbers["kind"] == TIME) & (numbers["quartile"] > 0)]
    for metric, rows in times.groupby("metric", sort=False):
        table = np.log(rows.pivot(index="night", columns="case", values="quartile"))
        if len(table.columns) < FEWEST_CASES:
            continue
        shared = np.exp(shared_part(table.reindex(rows["night"].drop_duplicates())))
        found.append(pd.DataFrame({"night": shared.index, "case": ALL_CASES, "metric": metric, "value": shared.to_numpy(),
                                   "low": np.nan, "high": np.nan, "unit": "x the median night"}))
    return found


def _with_changes(rows: pd.DataFrame, changes: dict[int, Finding], commits: dict[int, str]) -> pd.DataFrame:
    part = rows["night"].isin(changes).cumsum()
    ratios = [changes[night].ratio if night in changes else None for night in rows["night"]]
    return rows.assign(level=rows.groupby(part)["value"].transform("median"), ratio=np.array(ratios, dtype=float),
                       changed=[ratio_words(changes[night]) if night in changes else "" for night in rows["night"]],
                       between=[commits.get(night, "") if night in changes else "" for night in rows["night"]])
