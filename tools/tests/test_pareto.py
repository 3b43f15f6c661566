"""Which configurations are on the Pareto front, and how the picture places points and labels."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from fake_study import SCENES, SIZES, replays_of
from musclebench.accuracy import front, report
from musclebench.accuracy.aggregates import Aggregate
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


def drawn_rows() -> pd.DataFrame:
    """Backend, configuration, words, series, fineness, time ms, error mm, and whether it is default, advised, a control, hollow."""
    rows = [
        ("null", "null", "nothing", None, 0, 0.001, 30.0, True, True, True, False),
        ("voxel", "voxel 64", "voxel grid, 64 cells", "voxel cells", 64, 0.09, 4.0, True, True, False, False),
        ("voxel", "voxel 64 no cache", "voxel grid, 64 cells, no cache", "voxel cells no cache", 64, 0.2, 4.0, False, False, False, False),
        ("sdf", "sdf 64", "distance field, 64 cells", "sdf cells", 64, 0.05, 0.06, True, True, False, False),
        ("sdf", "sdf 16", "distance field, 16 cells", "sdf cells", 16, 0.04, 0.7, False, False, False, False),
        ("sdf", "sdf to 0.1 mm", "distance field, to 0.1 mm", "sdf adaptive", 10, 0.03, 0.05, False, False, False, False),
        ("bvh", "bvh", "exact tree", None, 0, 0.08, 0.0, True, True, False, False),
        ("bvh", "bvh no cache", "exact tree, no cache", None, 0, 1.0, 0.0, False, False, False, False),
        ("fcl", "fcl default", "FCL, as in the paper", None, 0, 80.0, np.inf, True, False, False, True),
        ("fcl", "fcl as advised", "FCL, as advised", None, 0, 0.8, 1e-5, False, True, False, False),
        ("fcl", "fcl OBB", "FCL, OBB", None, 0, 40.0, np.inf, False, False, False, True),
        ("brute_force", "brute_force", "brute force", None, 0, 0.07, 2e-4, True, True, False, False),
    ]
    names = ["backend", "configuration", "spoken", "series", "fineness", "time_ms", "error_mm", "is_default", "is_advised", "is_control",
             "is_substitute"]
    return pd.DataFrame(rows, columns=names).assign(
        panel="synthetic/iliacus", is_wrong=False, on_front=False, structure_bytes=1e6, time_ms_low=lambda rows: 0.9 * rows["time_ms"],
        time_ms_high=lambda rows: 1.1 * rows["time_ms"])


def test_the_overview_has_defaults_what_is_advised_and_one_curve_a_backend():
    shown = overview.overview(drawn_rows())
    assert set(shown["configuration"]) == {"voxel 64", "sdf 64", "sdf 16", "bvh", "fcl default", "fcl as advised", "brute_force"}
    assert set(shown.loc[shown["on_front"], "configuration"]) == {"sdf 16", "sdf 64", "brute_force"}, "a micrometre is exact"


def test_the_overview_of_several_muscles_is_that_of_all():
    rows = drawn_rows()
    shown = overview.overview(pd.concat([rows, rows.assign(panel=front.ALL_MUSCLES)]))
    assert set(shown["panel"]) == {front.ALL_MUSCLES}


def test_a_backend_that_stands_once_in_the_overview_has_its_plain_name():
    named = overview.overview(drawn_rows())
    words = list(named.loc[overview.named(named), "spoken"])
    assert sorted(words) == sorted(["voxel grid", "distance field", "exact tree", "FCL, as in the paper", "FCL, as advised", "brute force"])


def test_libraries_of_others_are_named_last_in_the_overview():
    known = looks.known()
    other = [replace(one, study={**one.study, "external": one.name == "voxel"}) for one in known.backends]
    looks.know(replace(known, backends=tuple(other)))
    shown = overview.overview(drawn_rows())
    assert shown.loc[overview.named(shown)[-1], "backend"] == "voxel"


def test_what_can_not_be_asked_about_points_is_hollow_at_the_edge(tmp_path):
    drawn = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pareto.style, "save_figure", lambda figure, stem: drawn.append(figure) or [])
        overview.draw_overview(drawn_rows(), tmp_path / "overview", "title")
    panel, key = drawn[0].axes
    hollow = [marks for marks in panel.collections if tuple(marks.get_facecolor()[0]) == (1, 1, 1, 1)]
    (place,) = [marks.get_offsets()[0] for marks in hollow if len(marks.get_offsets())]
    assert place[0] == 80 and 4 < place[1] < panel.get_ylim()[1], "above all that is known"
    words = {text.get_text() for text in key.get_legend().get_texts()}
    assert "can't be asked about points" in words and "95 % interval" not in words
    written = pd.read_csv(tmp_path / "overview.csv").set_index("configuration")
    assert np.isnan(written.loc["fcl default", "error_mm"]) and written.loc["bvh", "time_ms_low"] < written.loc["bvh", "time_ms"]
    plt.close(drawn[0])


@pytest.mark.long
def test_what_can_not_be_asked_about_points_has_no_error_in_the_replay(study, tmp_path, monkeypatch):
    """Nor a place on the front: the depth that its own run left would look exact."""
    monkeypatch.setattr(Aggregate, "is_asked", property(lambda one: one.configuration.backend != "fcl"))
    report._draw_replay(replays_of(study), set(), tmp_path)
    rows = pd.read_csv(tmp_path / "pareto_replay.csv")
    unknown = rows[rows["is_substitute"]]
    assert set(unknown["backend"]) == {"fcl"} and unknown["error_mm"].isna().all() and not unknown["on_front"].any()
    assert rows[~rows["is_substitute"]]["error_mm"].notna().all()


def test_an_error_that_is_not_known_leaves_the_time(study):
    def is_fcl(one) -> bool:
        return one.configuration.backend == "fcl"

    points = front.points_of(replays_of(study), lambda one: np.inf if is_fcl(one) else one.p99_offset_mm, set(), is_fcl)
    unknown = points[points["is_substitute"]]
    assert set(unknown["backend"]) == {"fcl"} and np.isinf(unknown["error_mm"]).all() and unknown["time_ms"].notna().all()
    assert not unknown["on_front"].any()


def test_a_named_set_of_choices_has_a_mark_of_its_own():
    known = looks.known()
    looks.know(replace(known, backends=tuple(
        replace(one, study={**one.study, "named": [{"text": "as first tried", "parameters": {}}]}) if one.name == "sdf" else one
        for one in known.backends)))
    try:
        curve, alone, named = (looks.series_style("sdf", words) for words in ("sdf cells", "sdf, no cache cells", "sdf, as first tried cells"))
        assert curve == looks.SERIES_STYLES[0] and len({curve, alone, named}) == 3
    finally:
        looks.know(known)
