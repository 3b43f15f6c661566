"""Observed orders of convergence: slopes of error, build time and bytes against resolution."""

import math

import numpy as np
import pandas as pd

from .aggregates import Aggregate
from .rows import build_seconds

REGIONS = ("smooth", "sharp")


def probe_rows(probes: list[Aggregate]) -> pd.DataFrame:
    """A row a bone, region, series and cell size; a bone that several scenes share counts once. Adaptive cells have no
    one size and are left out."""
    rows = []
    shown = [one for one in probes if one.is_shown and one.configuration.series]
    for aggregate in (one for one in shown if not one.configuration.wanted_error_mm):
        record, probe = aggregate.ok[0].run.record, aggregate.ok[0].probe
        digests = {bone.get("name"): bone.get("mesh_sha256") for bone in record.get("bones") or []}
        for _, line in probe.iterrows():
            rows.append({
                "bone": line["bone"], "mesh_sha256": digests.get(line["bone"]), "region": line["region"],
                "backend": aggregate.backend, "series": aggregate.configuration.series,
                "configuration": aggregate.configuration.name,
                "cell_edge_m": cell_edge_m(aggregate, line["bone"]), "points": line["points"],
                **{key: line.get(key) for key in ("max_error_m", "p99_error_m", "mean_error_m", "rms_error_m",
                                                  "wrong_side")},
            })
    keys = ["bone", "mesh_sha256", "region", "backend", "series", "configuration"]
    table = pd.DataFrame(rows, columns=[*keys, "cell_edge_m", "points", "max_error_m", "p99_error_m", "mean_error_m",
                                        "rms_error_m", "wrong_side"])
    return with_orders(table.drop_duplicates(keys))


def with_orders(table: pd.DataFrame) -> pd.DataFrame:
    """Adds `order` (between the row and the next coarser one) and `fitted_order` (over the series) of the p99 error."""
    table = table.sort_values(["bone", "region", "series", "cell_edge_m"], ascending=[True, True, True, False])
    table = table.reset_index(drop=True)
    table["order"], table["fitted_order"] = math.nan, math.nan
    for _, line in table.groupby(["bone", "mesh_sha256", "region", "series"], sort=False, dropna=False):
        table.loc[line.index, "order"] = local_orders(line["cell_edge_m"], line["p99_error_m"])
        table.loc[line.index, "fitted_order"] = slope(line["cell_edge_m"], line["p99_error_m"])
    return table


def cell_edge_m(aggregate: Aggregate, bone: str) -> float:
    """As the probe told, else of cubes as they were asked for."""
    record = aggregate.ok[0].run.record
    told = [item.get("cell_edge_m") for item in record.get("probed") or [] if item.get("name") == bone]
    edge = told[0] if told and told[0] else aggregate.configuration.cube_edge_m
    return math.nan if edge is None else float(edge)


def cost_rows(aggregates: list[Aggregate], measured_builds: dict) -> pd.DataFrame:
    """Cells of all bones, build time and bytes of each grid; scenes with the same bones count once."""
    rows = []
    for aggregate in (e for e in aggregates if e.is_shown and e.configuration.series):
        cells = cell_count(aggregate)
        rows.append({"bones": _bones(aggregate), "backend": aggregate.backend,
                     "series": aggregate.configuration.series, "cells": cells,
                     "configuration": aggregate.configuration.name,
                     "build_s": build_seconds(aggregate, measured_builds),
                     "structure_bytes": aggregate.structure_bytes})
    table = pd.DataFrame(rows, columns=["bones", "backend", "series", "cells", "configuration", "build_s",
                                        "structure_bytes"])
    table = table[table["cells"].notna()]
    return table.drop_duplicates(["bones", "configuration"]).sort_values(["series", "cells"]).reset_index(drop=True)


def cell_count(aggregate: Aggregate) -> float:
    """Of a fixed count along each axis; cubes are not counted, their boxes aren't known here."""
    cells, bones = aggregate.configuration.cells, len(aggregate.ok[0].run.record.get("bones") or [])
    return float(cells**3 * bones) if cells and bones else math.nan


def slope(x, y) -> float:
    """Of the straight line through the logarithms; NaN of fewer than two points."""
    x, y = _logarithms(x, y)
    return float(np.polyfit(x, y, 1)[0]) if len(np.unique(x)) > 1 else math.nan


def local_orders(x, y) -> list[float]:
    """Between each value and the one before it; NaN for the first."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    return [math.nan, *(slope(x[i - 1: i + 1], y[i - 1: i + 1]) for i in range(1, len(x)))][: len(x)]


def _logarithms(x, y) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    known = (x > 0) & (y > 0) & np.isfinite(x) & np.isfinite(y)
    return np.log(x[known]), np.log(y[known])


def _bones(aggregate: Aggregate) -> str:
    bones = aggregate.ok[0].run.record.get("bones") or []
    return "+".join(f"{bone.get('name')}:{(bone.get('mesh_sha256') or aggregate.scene)[:8]}" for bone in bones)
