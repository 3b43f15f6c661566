"""Points of the Pareto picture: time and error of each configuration, a muscle a panel and all muscles together."""

import math

import numpy as np
import pandas as pd

from ..results.statistics import total
from .aggregates import Aggregate

EXACT_MM = 1e-6  # a nanometre: what double precision leaves of millimetres is drawn as exact
ALL_MUSCLES = "all"


def points_of(aggregates: list[Aggregate], error_mm, wrong: set, is_substitute=lambda aggregate: False) -> pd.DataFrame:
    """One row a panel and configuration. `error_mm`: of an aggregate; NaN where it is unknown. `wrong`: pairs (scene,
    configuration) that answer wrongly. `is_substitute`: whether an aggregate's error is another than that of the axis.
    Runs of one thread only: what threads gain is another question."""
    shown = [aggregate for aggregate in aggregates if aggregate.is_shown and aggregate.configuration.threads == 1]
    panels = [(aggregate.scene, [aggregate]) for aggregate in shown]
    scenes = {aggregate.scene for aggregate in shown}
    if len(scenes) > 1:
        panels += [(ALL_MUSCLES, group) for group in _on_all(shown, scenes)]
    rows = [_row(panel, group, error_mm, wrong) | {"is_substitute": any(map(is_substitute, group))} for panel, group in panels]
    points = pd.DataFrame(rows, columns=_row_keys())
    points = points[points["time_ms"].notna() & points["error_mm"].notna()].reset_index(drop=True)
    points["on_front"] = False
    for _, panel in points.groupby("panel", sort=False):
        points.loc[on_front(panel), "on_front"] = True
    return points


def on_front(points: pd.DataFrame, exact_mm: float = EXACT_MM) -> list:
    """Index of the points than which no other is both faster and at least as accurate. Wrong configurations and the run
    without collision take no part; below `exact_mm` all are equally accurate."""
    best, front = math.inf, []
    may = points[~points["is_wrong"] & ~points["is_control"]]
    for index, row in may.sort_values(["time_ms", "error_mm"]).iterrows():
        error = max(row["error_mm"], exact_mm)
        if error < best:
            best = error
            front.append(index)
    return front


def _on_all(aggregates: list[Aggregate], scenes: set[str]) -> list[list[Aggregate]]:
    groups: dict = {}
    for aggregate in aggregates:
        groups.setdefault(aggregate.configuration, []).append(aggregate)
    return [group for group in groups.values() if {aggregate.scene for aggregate in group} == scenes]


def _row(panel: str, group: list[Aggregate], error_mm, wrong: set) -> dict:
    """Of all muscles: the sum of their times, the largest of their errors."""
    chosen, time = group[0].configuration, total([aggregate.collision_ms for aggregate in group])
    return {
        "panel": panel, "backend": chosen.backend, "configuration": chosen.name, "series": chosen.series,
        "label": chosen.short, "spoken": chosen.spoken, "is_default": chosen.is_default, "is_advised": chosen.is_advised,
        "fineness": chosen.fineness,
        "time_ms": time.value, "time_ms_low": time.low, "time_ms_high": time.high, "error_mm": float(np.max([error_mm(aggregate) for aggregate in group])),
        "structure_bytes": sum(aggregate.structure_bytes for aggregate in group) / len(group),
        "is_control": chosen.about.is_control,
        "is_wrong": any((aggregate.scene, aggregate.configuration) in wrong for aggregate in group),
        "repetitions": min(len(aggregate.ok) for aggregate in group),
        "frames": time.frames,
    }


def _row_keys() -> list[str]:
    return ["panel", "backend", "configuration", "series", "label", "spoken", "is_default", "is_advised", "fineness", "time_ms",
            "time_ms_low", "time_ms_high", "error_mm", "structure_bytes", "is_control", "is_wrong", "repetitions", "frames",
            "is_substitute"]
