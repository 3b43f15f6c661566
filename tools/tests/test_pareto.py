"""Which configurations are on the Pareto front, and how the picture places points and labels."""

import numpy as np
import pandas as pd
import pytest

from fake_study import SCENES, SIZES, replays_of
from musclebench.accuracy import front
from musclebench.figures import labels, looks, overview, pareto
from musclebench.figures.style import plt


def test_the_front_leaves_out_what_is_slower_and_no_better_and_what_is_wrong(study):
    replays = replays_of(study)
    wrong = {(e.scene, e.configuration) for e in replays if e.is_wrong}
    points = front.points_of(replays, lambda aggregate: aggregate.p99_offset_mm, wrong)
    best = points[points["on_front"]].groupby("panel")["configuration"].apply(list).to_dict()
    for panel in (*SCENES, front.ALL_MUSCLES):
        assert best[panel] == ["voxel 64", "sdf 64", "sdf 128", "bvh"]
    crossed = set(points[points["is_wrong"]]["configuration"])
    assert crossed == {"fcl RSS"}
    assert "fcl 2 threads" not in set(points["configuration"])


def test_all_muscles_are_the_sum_of_times_and_the_largest_error(study):
    points = front.points_of(replays_of(study), lambda one: one.p99_offset_mm * SIZES[one.scene], set())
    row = points[points["panel"] == front.ALL_MUSCLES].set_index("configuration").loc["sdf 128"]
    assert row["time_ms"] == pytest.approx(0.6) and row["error_mm"] == pytest.approx(0.08)


def test_exact_backends_count_as_equal():
    rows = [("a", 1.0, 2e-17), ("b", 2.0, 0.0), ("c", 0.5, 1e-3)]
    points = pd.DataFrame(rows, columns=["backend", "time_ms", "error_mm"]).assign(is_wrong=False, is_control=False)
    assert [points.loc[i, "backend"] for i in front.on_front(points)] == ["c", "a"]


def test_exact_points_stand_in_a_band_below_the_axis():
    axis = pareto.error_axis(pd.Series([0.0, 1e-17, 0.02, 5.0]))
    assert axis.low_mm == pytest.approx(0.01) and axis.bottom_mm < axis.low_mm
    assert axis.bottom_mm < axis.height(1e-17) == axis.height(0.0) < axis.low_mm
    assert axis.height(0.02) == 0.02
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


def test_lines_to_labels_cross_neither_each_other_nor_labels():
    figure, axes = plt.subplots(figsize=(4, 4))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    wanted = [labels.Label(0.5 + 0.01 * (i % 3), 0.5 + 0.01 * (i // 3), f"label {i}", "black") for i in range(30)]
    labels.place_labels(axes, wanted)
    lines = [axes.transAxes.transform(line.get_xydata()) for line in axes.lines]
    boxes = [np.array(text.get_window_extent().extents) for text in axes.texts]
    assert len(lines) >= 4
    assert not any(labels._cross(a, b) for i, a in enumerate(lines) for b in lines[:i])
    assert not any(labels._touches(line, box) for line in lines for box in boxes
                   if not np.allclose(line[1], (box[:2] + box[2:]) / 2, atol=6))
    plt.close(figure)


def test_the_overview_has_defaults_what_is_advised_and_one_curve_a_backend(study):
    points = front.points_of(replays_of(study), lambda one: one.p99_offset_mm, set())
    shown = overview.overview(points)
    assert set(shown["panel"]) == {front.ALL_MUSCLES}
    assert {"voxel 64", "sdf 64", "bvh", "fcl default", "fcl as advised"} & set(points["configuration"]) <= set(shown["configuration"])
    curves = shown[shown["series"].notna()].groupby("backend")["series"].nunique()
    assert (curves == 1).all() and len(curves) >= 2
    assert not shown["is_control"].any() and shown["on_front"].any()


def test_a_backend_that_stands_once_in_the_overview_has_its_plain_name(study):
    shown = overview.overview(front.points_of(replays_of(study), lambda one: one.p99_offset_mm, set()))
    named = shown.loc[overview.named(shown)]
    assert named["spoken"].is_unique and len(named) >= 3
    assert "exact tree" in set(named["spoken"]) and not any("default" in words for words in named["spoken"])
    externals = [looks.backend(name).is_external for name in named["backend"]]
    assert externals == sorted(externals), "other people's libraries come after this project's and the paper's"


def test_what_can_not_be_asked_about_points_is_hollow(study, tmp_path):
    replays = replays_of(study)
    points = front.points_of(replays, lambda one: one.p99_offset_mm, set(), lambda one: one.configuration.backend == "fcl")
    assert set(points.loc[points["is_substitute"], "backend"]) == {"fcl"}
    drawn = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pareto.style, "save_figure", lambda figure, stem: drawn.append(figure) or [])
        overview.draw_overview(points, tmp_path / "overview", "title")
    (legend,) = [axes.get_legend() for axes in drawn[0].axes if axes.get_legend()]
    assert np.isinf(overview.overview(points).set_index("configuration").loc["fcl default", "error_mm"])
    assert any("can't be asked" in text.get_text() for text in legend.get_texts())
    plt.close(drawn[0])
