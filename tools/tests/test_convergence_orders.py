"""Observed orders of convergence are those of the errors."""

import math

import numpy as np
import pytest

import fake_study
from fake_study import SCENES, Truth, write_probe
from musclebench.accuracy import cases, orders
from musclebench.accuracy.aggregates import aggregates_of
from musclebench.accuracy.rows import build_seconds_of


def test_observed_orders_are_those_of_the_errors(tmp_path):
    for cells in (8, 16, 32, 64):
        write_probe(tmp_path / "raw" / f"s{cells}", SCENES[0], "sdf", Truth(
            structure_bytes=60 * cells**3, build_s=1e-5 * cells**3, parameters={"cells": cells}))
    probes = aggregates_of(cases.read_cases(tmp_path))
    rows = orders.probe_rows(probes)
    for region, order in (("smooth", fake_study.SMOOTH_ORDER), ("sharp", fake_study.SHARP_ORDER)):
        mine = rows[(rows["bone"] == "pelvis") & (rows["region"] == region)]
        assert mine["cell_edge_m"].tolist() == [0.2 / cells for cells in (8, 16, 32, 64)]
        assert mine["fitted_order"].iloc[0] == pytest.approx(order)
        assert np.isnan(mine["order"].iloc[0]) and mine["order"].iloc[1:].tolist() == pytest.approx([order] * 3)
    costs = orders.cost_rows(probes, build_seconds_of(probes))
    assert costs["cells"].tolist() == [2 * cells**3 for cells in (8, 16, 32, 64)]
    assert orders.slope(costs["cells"], costs["build_s"]) == pytest.approx(1)


def test_adaptive_cells_have_no_order(tmp_path):
    write_probe(tmp_path / "raw" / "a", SCENES[0], "sdf", Truth(parameters={"cells": 64, "max_error_mm": 0.1}))
    assert orders.probe_rows(aggregates_of(cases.read_cases(tmp_path))).empty


def test_bones_that_muscles_share_count_once(tmp_path):
    for scene in SCENES:
        write_probe(tmp_path / "raw" / scene.replace("/", "-"), scene, "sdf", Truth(parameters={"cells": 8}))
    rows = orders.probe_rows(aggregates_of(cases.read_cases(tmp_path)))
    assert len(rows) == 2 * 3  # bones; all points, smooth and sharp ones


def test_an_error_of_nothing_has_no_order():
    assert orders.local_orders([4, 2, 1], [1e-3, 0.0, 1e-5])[1:] == pytest.approx([math.nan] * 2, nan_ok=True)
    assert math.isnan(orders.slope([1, 2], [0.0, 0.0]))


def test_probes_from_before_name_their_region_a_place(tmp_path):
    for cells in (8, 16):
        write_probe(tmp_path / "raw" / f"s{cells}", SCENES[0], "sdf", Truth(parameters={"cells": cells}))
        rows = tmp_path / f"raw/s{cells}/probe.csv"
        rows.write_text(rows.read_text().replace("region", "place", 1))
    assert set(orders.probe_rows(aggregates_of(cases.read_cases(tmp_path)))["region"]) == {"all", "smooth", "sharp"}
