"""The accuracy study's tables and figures say what follows from known runs, however incomplete the study is."""

import json
import math

import numpy as np
import pandas as pd
import pytest

import fake_runs
import fake_study
from fake_study import SURFACES, Truth, write_coupled, write_failure, write_plan, write_probe, write_replay
from musclebench_report import ply, results, table_formats
from musclebench_report.accuracy import cases, front, labels, orders, outcomes, pareto, prices, report, shapes
from musclebench_report.accuracy.configurations import Configuration, configuration
from musclebench_report.accuracy.entries import entries_of, find, of_mode
from musclebench_report.accuracy.fcl_table import best_right, fcl_table
from musclebench_report.accuracy.rows import accuracy_rows, build_seconds_of, study_rows
from musclebench_report.accuracy.stages import chosen_entries, stage_rows
from musclebench_report.statistics import Estimate, paired_ratio, pooled_median, quotient, total
from musclebench_report.style import plt

SCENES = ("lhdl/iliacus", "lhdl/gluteus_medius")
SIZES = {"lhdl/iliacus": 1.0, "lhdl/gluteus_medius": 0.5}
GRID_64 = {"cells": 64, "voxel_size_m": 0.0}
REPLAYED = {  # ms and p99 error in mm on the iliacus
    "voxel": Truth(0.2, 3.0, false=5000, structure_bytes=65_536, build_s=0.3, noise=0, parameters=GRID_64),
    "sdf 64": Truth(0.3, 0.25, noise=0, structure_bytes=15_000_000, build_s=12, parameters={"cells": 64}),
    "sdf 128": Truth(0.4, 0.08, noise=0, build_s=90, parameters={"cells": 128, "precision": "float"}),
    "fcl": Truth(72, 0.02, missed=50, noise=0, parameters=SURFACES),
    "fcl OBB": Truth(36, 0.02, missed=50, noise=0, parameters=SURFACES | {"bounding_volume": "OBB"}),
    "fcl RSS": Truth(10, 0.02, missed=9990, noise=0, parameters=SURFACES | {"bounding_volume": "RSS"}),
    "fcl threads": Truth(20, 0.02, missed=50, noise=0, parameters=SURFACES, threads=2),
    "bvh": Truth(15, 1e-14, noise=0, build_s=0.4),
}


@pytest.fixture
def study(tmp_path):
    """Two muscles; the RSS of fcl is fast and wrong."""
    for scene in SCENES:
        for name, truth in REPLAYED.items():
            scaled = Truth(**{**vars(truth), "ms": truth.ms * SIZES[scene]})
            for repetition in range(2):
                folder = tmp_path / "raw" / f"{scene.split('/')[1]}-{name}-r{repetition}"
                write_replay(folder, scene, name.split()[0], scaled, repetition)
    return tmp_path


def replays_of(out_dir):
    return of_mode(entries_of(cases.read_cases(out_dir)), "replay")


def price(replays, muscle, bar):
    rows = prices.price_list(replays, build_seconds_of(replays)).rows
    return rows[(rows["muscle"] == muscle) & (rows["bar_mm"] == bar)].iloc[0]


# Configurations


def test_resolved_and_asked_parameters_are_the_same_configuration():
    asked = configuration("sdf", {"cells": "128"})
    resolved = configuration("sdf", {"cells": 128, "cell_size_m": 0.0, "precision": "float", "margin": 0.001,
                                     "structures": "/somewhere"})
    assert asked == resolved and asked.name == "sdf 128" and asked.series == "sdf float cells"
    assert configuration("fcl", SURFACES) == configuration("fcl", {}) == Configuration("fcl")


def test_cubes_are_a_series_of_their_own_whatever_the_count_of_cells():
    cubes = configuration("voxel", {"cells": 32, "voxel_size_m": 0.002})
    assert cubes.series == "voxel cubes" and cubes.short == "2 mm" and cubes.cells is None
    assert cubes == configuration("voxel", {"voxel_size_m": 2e-3})
    assert cubes.fineness > configuration("voxel", {"voxel_size_m": 4e-3}).fineness


def test_adaptive_cells_are_a_series_by_the_error_that_is_wanted():
    adaptive = configuration("sdf", {"cells": 64, "cell_size_m": 0.0, "max_error_mm": 0.05})
    assert adaptive.series == "sdf float adaptive" and adaptive.name == "sdf to 0.05 mm" and adaptive.cells is None
    assert adaptive == configuration("sdf", {"max_error_mm": "0.05", "precision": "float"})
    assert adaptive.fineness > configuration("sdf", {"max_error_mm": 0.3}).fineness


def test_motion_budgets_make_a_curve_or_point_of_their_own():
    assert configuration("sdf", {"motion_budgets": "on"}) == configuration("sdf", {})
    assert configuration("sdf", {"motion_budgets": "off"}).series == "sdf float cells no budgets"
    assert configuration("bvh", {"motion_budgets": "off"}).name == "bvh no budgets"
    distance = {"query": "node_distance"}
    assert configuration("fcl", distance | {"motion_budgets": "off"}).name == "fcl node distance"
    assert configuration("fcl", distance | {"motion_budgets": "on"}).name == "fcl node distance, budgets"


def test_names_tell_configurations_apart():
    made = [configuration(backend, truth.parameters, truth.threads)
            for backend, truth in fake_study.realistic_truths()]
    assert len({one.name for one in made}) == len(made) == len(set(made))


def test_the_radius_counts_only_where_nodes_are_spheres():
    near = configuration("fcl", {"query": "node_collide", "node_radius_m": 2e-3})
    assert near != configuration("fcl", {"query": "node_collide"}) and "2 mm" in near.name
    assert configuration("fcl", {"node_radius_m": 2e-3}).is_default


# Statistics


def test_repetitions_that_differ_widen_the_interval():
    frames = range(200)
    alike = pooled_median([pd.Series(10.0, index=frames)] * 3)
    apart = pooled_median([pd.Series(value, index=frames) for value in (9.0, 10.0, 12.0)])
    assert (alike.low, alike.value, alike.high) == (10, 10, 10)
    assert apart.value == 10 and apart.low <= 9.0 and apart.high >= 12.0


def test_ratios_are_matched_by_frame_and_repetition():
    slow_second = {0: pd.Series([1.0, 2.0, 3.0]), 1: pd.Series([10.0, 20.0, 30.0])}
    three_times = {number: 3 * values for number, values in slow_second.items()}
    assert paired_ratio(three_times, slow_second).value == pytest.approx(3.0)
    some_frames = {0: pd.Series([4.0], index=[2])}
    assert paired_ratio(some_frames, {0: slow_second[0]}).value == pytest.approx(4 / 3)
    assert math.isnan(paired_ratio({}, slow_second).value)


def test_sums_and_quotients_carry_their_intervals():
    draws = np.linspace(1, 3, 1001)
    one = Estimate(2.0, 1.05, 2.95, 5, draws)
    assert total([one, one]).value == 4 and total([one, one]).high == pytest.approx(5.9, abs=0.01)
    assert quotient(one, Estimate(2.0, 2, 2, 5, np.full(1001, 2.0))).value == 1
    assert math.isnan(quotient(one, Estimate.unknown()).value)


# Reading an incomplete study


def test_what_failed_or_is_missing_is_a_row_and_not_in_a_figure(study):
    write_failure(study / "raw" / "late", "coupled", SCENES[0], "brute_force", "timeout")
    write_failure(study / "raw" / "refused", "replay", SCENES[0], "fcl", "unsupported", Truth(
        parameters={"bounding_volume": "KDOP24"}))
    (study / "raw" / "broken").mkdir()
    (study / "raw" / "broken" / "run.json").write_text("{")
    plan = {"mode": "replay", "scene": SCENES[0], "backend": "voxel", "parameters": {"cells": 48}, "threads": 1,
            "repetition": 0}
    write_plan(study, [{"name": "not-yet", **plan}, {"name": "broken", **plan, "repetition": 1}])
    made = report.write_report(study)
    table = pd.read_csv(study / "accuracy.csv").set_index("case")
    assert table.loc["late", "status"] == "timeout" and table.loc["refused", "status"] == "unsupported"
    assert table.loc["not-yet", "status"] == "missing" and table.loc["broken", "status"] == "failed"
    assert np.isnan(table.loc["late", "median_collision_ns"])
    drawn = pd.read_csv(study / "figures" / "pareto_replay.csv")
    assert not {"voxel 48", "fcl KDOP24"} & set(drawn["configuration"])
    caption = (study / "figures" / "pareto_replay.md").read_text()
    assert "voxel 48 (missing)" in caption and "fcl KDOP24 (unsupported)" in caption
    assert all(path.is_file() for path in made)


@pytest.mark.parametrize("folders", [[], ["raw"]])
def test_an_empty_study_gives_empty_tables_and_no_figure(tmp_path, folders):
    for folder in folders:
        (tmp_path / folder).mkdir()
    made = report.write_report(tmp_path)
    assert not [path for path in made if path.suffix == ".png"]


def test_a_broken_folder_that_no_plan_names_stops_with_its_place(tmp_path):
    (tmp_path / "raw" / "x").mkdir(parents=True)
    (tmp_path / "raw" / "x" / "run.json").write_text("{")
    with pytest.raises(results.ResultProblem, match="x/run.json"):
        report.write_report(tmp_path)


def test_a_broken_plan_is_named(tmp_path):
    (tmp_path / "study.json").write_text("[]")
    with pytest.raises(results.ResultProblem, match="study.json"):
        cases.read_cases(tmp_path)


def test_repetitions_with_different_answers_are_shown_as_such(study):
    path = study / "raw" / "iliacus-bvh-r1" / "run.json"
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"contact_hash": "another"}))
    entry = next(e for e in replays_of(study) if e.backend == "bvh" and e.scene == SCENES[0])
    assert entry.status == "nondeterministic" and not entry.is_shown


def test_rows_have_medians_and_the_judged_repetitions_errors(study):
    found = cases.read_cases(study)
    table = accuracy_rows(found)
    assert len(table) == 2 * len(SCENES) * len(REPLAYED)
    entries = entries_of(found)
    row = study_rows(entries, build_seconds_of(entries)).set_index(["scene", "configuration"]).loc[
        (SCENES[0], "sdf 64")]
    assert row["collision_ms"] == pytest.approx(0.3) and row["times_voxel_64"] == pytest.approx(1.5)
    assert row["p99_depth_error_m"] == pytest.approx(0.25e-3) and row["ok_repetitions"] == 2
    assert row["detect_ms"] == pytest.approx(0.24) and row["build_s"] == 12


def test_a_field_that_was_loaded_has_the_build_time_of_the_case_that_built_it(tmp_path):
    truth = Truth(build_s=12, parameters={"cells": 64})
    write_probe(tmp_path / "raw" / "p", SCENES[0], "sdf", truth)
    loaded = Truth(build_s=0.1, structures="loaded", parameters={"cells": 64})
    write_replay(tmp_path / "raw" / "r", SCENES[0], "sdf", loaded)
    for name in "pr":  # the same bones in both
        path = tmp_path / "raw" / name / "run.json"
        record = json.loads(path.read_text())
        path.write_text(json.dumps(record | {"bones": [{"name": "femur", "mesh_sha256": "same"}]}))
    entries = entries_of(cases.read_cases(tmp_path))
    rows = study_rows(entries, build_seconds_of(entries))
    assert rows.set_index("mode").loc["replay", "build_s"] == 12


# Pareto front


def test_the_front_leaves_out_what_is_slower_and_no_better_and_what_is_wrong(study):
    replays = replays_of(study)
    wrong = {(e.scene, e.configuration) for e in replays if e.is_wrong}
    points = front.points_of(replays, lambda entry: entry.p99_error_mm, wrong)
    best = points[points["on_front"]].groupby("panel")["configuration"].apply(list).to_dict()
    for panel in (*SCENES, front.ALL_MUSCLES):
        assert best[panel] == ["voxel 64", "sdf 64", "sdf 128", "bvh"]
    crossed = set(points[points["is_wrong"]]["configuration"])
    assert crossed == {"fcl RSS"}
    assert "fcl 2 threads" not in set(points["configuration"])


def test_all_muscles_are_the_sum_of_times_and_the_largest_error(study):
    points = front.points_of(replays_of(study), lambda entry: entry.p99_error_mm * SIZES[entry.scene], set())
    row = points[points["panel"] == front.ALL_MUSCLES].set_index("configuration").loc["sdf 128"]
    assert row["time_ms"] == pytest.approx(0.6) and row["error_mm"] == pytest.approx(0.08)


def test_exact_backends_count_as_equal():
    rows = [("a", 1.0, 2e-17), ("b", 2.0, 0.0), ("c", 0.5, 1e-3)]
    points = pd.DataFrame(rows, columns=["backend", "time_ms", "error_mm"]).assign(is_wrong=False)
    assert [points.loc[i, "backend"] for i in front.on_front(points)] == ["c", "a"]


def test_exact_points_stand_in_a_band_below_the_axis():
    axis = pareto.error_axis(pd.Series([0.0, 1e-17, 0.02, 5.0]))
    assert axis.low_mm == pytest.approx(0.01) and axis.bottom_mm < axis.low_mm
    assert all(axis.bottom_mm < axis.height(1e-17, lane) < axis.low_mm for lane in range(12))
    assert axis.height(0.02, 3) == 0.02
    without = pareto.error_axis(pd.Series([0.02, 5.0]))
    assert without.bottom_mm == without.low_mm


def test_labels_cover_neither_each_other_nor_points():
    figure, axes = plt.subplots(figsize=(5, 4))
    axes.set(xscale="log", yscale="log", xlim=(0.1, 1000), ylim=(0.01, 10))
    wanted = [labels.Label(10.0 * 1.15**i, 0.3, str(i), "black") for i in range(12)]
    labels.place_labels(axes, wanted)
    renderer = figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in axes.texts]
    assert len(boxes) == 12
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    plt.close(figure)


# Price list and factors of fcl


def test_the_price_list_names_the_cheapest_that_holds(study):
    replays = replays_of(study)
    expected = {"1": "sdf 64", "0.3": "sdf 64", "0.1": "sdf 128", "0.03": "bvh", "0.01": "bvh"}
    for muscle in ("iliacus", "gluteus_medius", front.ALL_MUSCLES):
        assert {bar: price(replays, muscle, bar)["configuration"] for bar in expected} == expected
    row = price(replays, "iliacus", "0.1")
    assert row["ratio"] == pytest.approx(2.0) and row["build_s"] == 90 and row["p99_error_mm"] == pytest.approx(0.08)
    assert price(replays, front.ALL_MUSCLES, "0.01")["ratio"] == pytest.approx(75)


def test_a_configuration_that_fails_on_one_muscle_holds_not_for_all(study):
    path = study / "raw" / "gluteus_medius-sdf 128-r0" / "run.json"
    record = json.loads(path.read_text())
    record["accuracy"]["p99_depth_error_m"] = 0.2e-3
    path.write_text(json.dumps(record))
    replays = replays_of(study)
    assert price(replays, "iliacus", "0.1")["configuration"] == "sdf 128"
    assert price(replays, front.ALL_MUSCLES, "0.1")["configuration"] == "bvh"


def test_a_configuration_that_one_muscle_lacks_holds_not_for_all(study):
    write_failure(study / "raw" / "late", "replay", SCENES[1], "sdf", "timeout", Truth(parameters={"cells": 200}))
    write_replay(study / "raw" / "fine", SCENES[0], "sdf", Truth(0.5, 0.005, parameters={"cells": 200}))
    replays = replays_of(study)
    assert price(replays, "iliacus", "0.01")["configuration"] == "sdf 200"
    assert price(replays, front.ALL_MUSCLES, "0.01")["configuration"] == "bvh"


def test_a_depth_that_none_holds_names_the_best_found(tmp_path):
    write_replay(tmp_path / "raw" / "a", SCENES[0], "voxel", REPLAYED["voxel"])
    row = price(replays_of(tmp_path), "iliacus", "0.3")
    assert row["configuration"] == "none" and "voxel 64 with 3 mm" in row["note"]
    report.write_report(tmp_path)
    assert "voxel 64 with 3 mm" in (tmp_path / "tables" / "price_list.txt").read_text()


def test_the_factors_of_fcl_and_its_wrong_answers(study):
    replays = replays_of(study)
    rows = fcl_table(replays).rows
    rows = rows[rows["muscle"] == "iliacus"].set_index("choice")
    assert rows.index[0] == "default" and rows.loc["default", "factor"] == 1
    assert rows.loc["OBB", "factor"] == pytest.approx(0.5) and rows.loc["OBB", "ratio"] == pytest.approx(180)
    assert rows.loc["default", "verdict"] == "right" and rows.loc["default", "missed"] == 50
    assert rows.loc["RSS", "verdict"] == "wrong: 100 % missed"
    assert best_right(replays, SCENES[0]).configuration.name == "fcl OBB"
    assert "a factor of 2.00 is configuration" in fcl_table(replays).caption


@pytest.mark.parametrize("missed, false, p99_mm, verdict", [
    (100, 0, 0.1, "right"), (101, 0, 0.1, "wrong: 1.0 % missed"), (0, 200, 0.0, "wrong: 2.0 % false"),
    (0, 0, 0.11, "wrong: 0.11 mm off"), (0, 0, 0.0, "right"),
])
def test_the_rule_of_right_and_wrong(tmp_path, missed, false, p99_mm, verdict):
    write_replay(tmp_path / "raw" / "a", SCENES[0], "fcl", Truth(missed=missed, false=false, p99_mm=p99_mm))
    assert replays_of(tmp_path)[0].verdict == verdict


def test_tables_fit_a_terminal(study):
    for table in report.write_report(study).tables:
        assert max(map(len, table_formats.as_text(table).splitlines())) <= 110


# Convergence


def test_observed_orders_are_those_of_the_errors(tmp_path):
    for cells in (8, 16, 32, 64):
        write_probe(tmp_path / "raw" / f"s{cells}", SCENES[0], "sdf", Truth(
            structure_bytes=60 * cells**3, build_s=1e-5 * cells**3, parameters={"cells": cells}))
    probes = entries_of(cases.read_cases(tmp_path))
    rows = orders.probe_rows(probes)
    for place, order in (("smooth", fake_study.SMOOTH_ORDER), ("sharp", fake_study.SHARP_ORDER)):
        mine = rows[(rows["bone"] == "pelvis") & (rows["place"] == place)]
        assert mine["cell_edge_m"].tolist() == [0.2 / cells for cells in (8, 16, 32, 64)]
        assert mine["fitted_order"].iloc[0] == pytest.approx(order)
        assert np.isnan(mine["order"].iloc[0]) and mine["order"].iloc[1:].tolist() == pytest.approx([order] * 3)
    costs = orders.cost_rows(probes, build_seconds_of(probes))
    assert costs["cells"].tolist() == [2 * cells**3 for cells in (8, 16, 32, 64)]
    assert orders.slope(costs["cells"], costs["build_s"]) == pytest.approx(1)


def test_bones_that_muscles_share_count_once(tmp_path):
    for scene in SCENES:
        write_probe(tmp_path / "raw" / scene.replace("/", "-"), scene, "sdf", Truth(parameters={"cells": 8}))
    rows = orders.probe_rows(entries_of(cases.read_cases(tmp_path)))
    assert len(rows) == 2 * 2  # bones, places


def test_an_error_of_nothing_has_no_order():
    assert orders.local_orders([4, 2, 1], [1e-3, 0.0, 1e-5])[1:] == pytest.approx([math.nan] * 2, nan_ok=True)
    assert math.isnan(orders.slope([1, 2], [0.0, 0.0]))


# Shapes and outcomes of coupled runs


def mesh_of(body):
    return ply.PlyMesh(np.asarray(body.vertices_m, dtype=float), np.asarray(body.triangles), {})


def square(height_m, half_m=1.0):
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * half_m + [0, 0, height_m]
    return ply.PlyMesh(corners.astype(float), np.array([[0, 1, 2], [0, 2, 3]]), {})


def test_distances_of_parallel_squares_and_of_spheres():
    assert shapes.rms_distance_m(square(0), square(0.25)) == pytest.approx(0.25)
    assert shapes.hausdorff_distance_m(square(0), square(0.25)) == pytest.approx(0.25, rel=1e-6)
    small, large = (mesh_of(fake_runs.sphere((0, 0, 0), r, rings=24)) for r in (1.0, 1.5))
    assert shapes.hausdorff_distance_m(small, large) == pytest.approx(0.5, rel=1e-3)
    assert shapes.rms_distance_m(small, large) == pytest.approx(0.5)


def test_the_hausdorff_distance_is_symmetric_and_to_the_surface():
    inner, outer = square(0.1, half_m=0.5), square(0.0, half_m=2.0)
    far = math.hypot(math.hypot(1.5, 1.5), 0.1)
    assert shapes.hausdorff_distance_m(inner, outer) == pytest.approx(far, rel=1e-6)
    assert shapes.hausdorff_distance_m(outer, inner) == pytest.approx(far, rel=1e-6)
    # The same square in finer triangles: no distance to the surface, half an edge from vertex to vertex.
    finer = np.array([[0, 0, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    fan = ply.PlyMesh(finer, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]), {})
    assert shapes.hausdorff_distance_m(square(0), fan) == pytest.approx(0, abs=1e-12)


def test_shapes_of_different_nodes_have_no_rms():
    assert math.isnan(shapes.rms_distance_m(square(0), mesh_of(fake_runs.sphere((0, 0, 0), 1.0))))
    broken = square(0)
    broken.vertices_m[0] = math.nan
    assert math.isnan(shapes.hausdorff_distance_m(broken, square(0)))


@pytest.fixture
def coupled(tmp_path):
    raw = tmp_path / "raw"
    write_coupled(raw / "e", SCENES[0], "bvh", Truth(15, remaining_mm=0.02))
    for repetition in range(2):
        write_coupled(raw / f"s{repetition}", SCENES[0], "sdf", Truth(0.3, noise=0, remaining_mm=0.1, shift_mm=0.7,
                                                                     parameters={"cells": 64}), repetition)
    write_coupled(raw / "n", SCENES[0], "null", Truth(0.0005, remaining_mm=9, shift_mm=4, structure_bytes=0))
    return tmp_path


def test_outcomes_are_compared_with_the_exact_runs_shape(coupled):
    entries = entries_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(entries, outcomes.shape_distances(entries)).rows.set_index("configuration")
    assert rows.loc["sdf 64", "full_rms_mm"] == pytest.approx(0.7) and rows.loc["bvh", "full_rms_mm"] == 0
    assert 0.55 < rows.loc["sdf 64", "final_hausdorff_mm"] <= 0.7 + 1e-9
    assert rows.loc["sdf 64", "node_depth_mm"] == pytest.approx(0.12)
    assert rows.loc["sdf 64", "collision_s"] == pytest.approx(0.3e-3 * fake_study.FRAMES)
    assert rows.loc["sdf 64", "max_volume_percent"] == pytest.approx(2)


def test_without_an_exact_run_shapes_stay_unknown(coupled):
    path = coupled / "raw" / "e" / "run.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"status": "diverged"}))
    entries = entries_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(entries, outcomes.shape_distances(entries)).rows.set_index("configuration")
    assert math.isnan(rows.loc["sdf 64", "full_rms_mm"]) and rows.loc["bvh", "status"] == "diverged"


def test_a_snapshot_that_is_gone_costs_only_its_own_cells(coupled):
    for path in (coupled / "raw" / "s0" / "snapshots").iterdir():
        path.unlink()
    entries = entries_of(cases.read_cases(coupled))
    rows = outcomes.outcomes_table(entries, outcomes.shape_distances(entries)).rows.set_index("configuration")
    assert math.isnan(rows.loc["sdf 64", "full_rms_mm"]) and rows.loc["sdf 64", "node_depth_mm"] > 0


def test_remaining_depth_is_the_surfaces_else_the_nodes(coupled):
    entry = find(entries_of(cases.read_cases(coupled)), SCENES[0], configuration("sdf", {}))
    assert entry.remaining_depth_mm == pytest.approx(0.2)
    for case in entry.ok:
        case.run.record.get("outcome", {}).pop("p99_surface_depth_m", None)
    assert entry.remaining_depth_mm == pytest.approx(0.1)


# Where the time goes


def test_shares_of_a_frame_add_up_and_the_best_fcl_is_chosen(study):
    for place, name in enumerate(("voxel", "fcl", "fcl OBB", "fcl RSS")):
        write_coupled(study / "raw" / f"c{place}", SCENES[0], name.split()[0], REPLAYED[name])
    entries = entries_of(cases.read_cases(study))
    replays, coupled = of_mode(entries, "replay"), of_mode(entries, "coupled")
    names = [entry.configuration.name for entry in chosen_entries(coupled, replays, SCENES[0])]
    assert names == ["voxel 64", "fcl default", "fcl OBB"]
    rows = stage_rows(coupled, replays).set_index(["configuration", "stage"])
    assert rows.loc[("fcl OBB", "detect_ns"), "ms"] == pytest.approx(0.8 * 36)
    assert rows.groupby("configuration")["share"].sum().tolist() == pytest.approx([1, 1, 1])
    assert ("voxel 64", "frame_ns") not in rows.index


# All together


def test_every_figure_has_its_rows_and_its_caption(tmp_path):
    small = {"lhdl/iliacus": 1.0}
    fake_study.write_realistic_study(tmp_path, small, repetitions=1)
    made = report.write_report(tmp_path)
    stems = {path.stem for path in made if path.suffix == ".png"}
    assert stems == {"pareto_replay", "pareto_coupled", "pareto_coupled_shape", "convergence", "convergence_cost",
                     "stages"}
    for stem in stems:
        for suffix in (".png", ".svg", ".csv", ".md"):
            assert (tmp_path / "figures" / f"{stem}{suffix}").stat().st_size > 0
        caption = (tmp_path / "figures" / f"{stem}.md").read_text()
        assert all(word in caption for word in ("A processor", "GNU 12.2.0", "-O2", "abc1234", "lhdl", "paper"))
    assert "within 10 mm" in (tmp_path / "figures" / "pareto_replay.md").read_text()
