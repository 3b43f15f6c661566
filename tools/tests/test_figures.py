"""Figures as they are printed: widths, sizes of text, colours, resolution; no text covers another or leaves a page."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

import fake_registry
import fake_runs
import fake_study
from musclebench.accuracy import coupled_faults, report
from musclebench.accuracy.aggregates import aggregates_of, of_mode
from musclebench.accuracy.cases import read_cases
from musclebench.figures import labels, looks, paper_figures, pareto, style
from musclebench.figures.collisions import collisions
from musclebench.figures.style import plt
from musclebench.paper.published import read_published
from musclebench.pictures import surface_figures
from musclebench.pictures.surface_pictures import DEPTH_COLOURS
from musclebench.results.run_folder import read_run, read_runs
from musclebench.tables.outcomes import shape_distances
from printed import check_print, keep_figures


@pytest.fixture(scope="module", params=[pytest.param(1, marks=pytest.mark.weekly, id="one muscle"),
                                        pytest.param(2, marks=pytest.mark.long, id="two muscles")])
def reported(request, tmp_path_factory):
    """A whole study's folder, the files of its report, and {stem: (figure, its files)}."""
    scenes = {"lhdl/iliacus": 1.0, "lhdl/gluteus_maximus": 1.7}
    folder, kept = tmp_path_factory.mktemp("study"), {}
    looks.know(fake_registry.registry())
    fake_study.write_realistic_study(folder, dict(list(scenes.items())[:request.param]), repetitions=1)
    with pytest.MonkeyPatch.context() as patch:
        keep_figures(patch, kept)
        made = report.write_report(folder)
    return folder, list(made), kept


@pytest.fixture(scope="module")
def drawn(reported):
    """{stem: (figure, its files)}"""
    return reported[2]


def test_a_study_is_drawn_for_print(drawn):
    assert {"pareto_replay", "pareto_coupled", "stages", "convergence"} <= set(drawn)
    for figure, paths in drawn.values():
        check_print(figure, paths)


def test_every_figure_has_its_rows_and_its_caption(reported):
    folder, made, _ = reported
    stems = {path.stem for path in made if path.suffix == ".png"}
    assert stems == {"overview", "pareto_replay", "pareto_coupled", "pareto_coupled_shape", "offset_and_depth", "convergence", "convergence_cost",
                     "stages", *(f"library_{name}" for name in fake_registry.names_with_many_choices())}
    for stem in stems:
        for suffix in (".png", ".svg", ".csv", ".md"):
            assert (folder / "figures" / f"{stem}{suffix}").stat().st_size > 0
        caption = (folder / "figures" / f"{stem}.md").read_text()
        assert all(word in caption for word in ("A processor", "GNU 12.2.0", "-O2", "abc1234", "lhdl", "paper"))
    assert "within 10 mm" in (folder / "figures" / "pareto_replay.md").read_text()


def test_every_axis_has_a_number(drawn):
    for axes in drawn["convergence_cost"][0].axes:
        assert any(low.label1.get_text() for low in axes.yaxis._update_ticks())


@pytest.fixture
def figure():
    """Two panels side by side that are as they should be."""
    style.apply_style()
    made, (left, _) = plt.subplots(1, 2, figsize=(style.PAGE_INCHES, 2))
    left.plot([0, 1], [0, 1], "o-", label="a curve")
    left.text(0.7, 0.3, "a word")
    left.legend(loc="upper left")
    yield made
    plt.close(made)


def test_a_figure_that_is_in_order_has_no_collisions(figure):
    assert collisions(figure) == []


@pytest.mark.parametrize(("place", "found"), [
    ((0.0, 0.0), "covers a marker"), ((0.1, 0.9), "'a curve' covers 'a word'"), ((0.98, 0.3), "half out of its panel"),
    ((1.6, 0.3), "in another panel"), ((-0.45, 0.3), "cut off"),
])
def test_a_word_that_is_moved_on_purpose_is_found(figure, place, found):
    figure.axes[0].texts[0].set_position(place)
    assert any(found in line for line in collisions(figure)), collisions(figure)


def test_a_title_that_the_page_leaves_out_is_found(figure):
    figure.suptitle("a title", y=1.2).set_in_layout(False)
    assert any("'a title' is cut off" in line for line in collisions(figure))


def test_a_legend_over_data_is_found(figure):
    figure.axes[0].legend(loc="center")
    assert any("legend covers data" in line for line in collisions(figure))


@pytest.mark.long
def test_the_papers_figures_are_drawn_for_print(fake_raw, tmp_path, monkeypatch):
    kept = {}
    keep_figures(monkeypatch, kept)
    paper_figures.draw_figures(read_runs(fake_raw), read_published(), tmp_path)
    assert len(kept) == 3
    for figure, paths in kept.values():
        check_print(figure, paths)


@pytest.mark.long
def test_times_within_a_decade_have_no_powers_with_small_raised_figures(tmp_path, monkeypatch):
    kept = {}
    keep_figures(monkeypatch, kept)
    for backend in ("voxel", "sdf"):
        fake_runs.write_run(tmp_path / "raw" / backend, "synthetic/iliacus", backend)
    paper_figures.draw_figures(read_runs(tmp_path / "raw"), read_published(), tmp_path)
    figure, paths = kept["fig_7_collision_time"]
    check_print(figure, paths)
    assert any(tick.label1.get_text() for tick in figure.axes[0].yaxis.get_minor_ticks())


def test_few_points_of_the_pareto_picture_are_named_as_people_write_them(drawn):
    panel = next(axes for axes in drawn["pareto_replay"][0].axes if axes.get_title(loc="left") == "iliacus")
    words = [text.get_text() for text in panel.texts]
    assert len(words) <= pareto.MOST_LABELS
    assert {"exact tree", "voxel grid, 64 cells", "distance field, 64 cells", "FCL, as in the paper"} <= set(words)


def test_labels_find_room_where_an_interval_is_not_known():
    figure, axes = plt.subplots(figsize=(3, 3))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    labels.place_labels(axes, [labels.Label(0.5, 0.5, "a", "black", bar=(np.nan, np.nan))])
    centre, box = axes.transData.transform((0.5, 0.5)), axes.texts[0].get_window_extent()
    assert not box.contains(*centre)
    plt.close(figure)


def colours_in(path) -> set[tuple]:
    with Image.open(path) as picture:
        return {colour for _, colour in picture.convert("RGB").getcolors(picture.width * picture.height)}


def as_bytes(colour: str) -> tuple:
    return tuple(round(255 * part) for part in to_rgb(colour))


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Two figures of surfaces whose pictures are noise of many colours, as shaded surfaces are."""
    folder = tmp_path_factory.mktemp("pictures")
    looks.know(fake_registry.registry())
    run = read_run(fake_runs.write_run(folder / "run", "synthetic/iliacus", "voxel"))
    noise = np.random.default_rng(1).integers(100, 255, (200, 200, 3), dtype=np.uint8)
    paths = []
    for name, size in (("rows", (4, 5)), ("columns", (4, 4))):
        style.apply_style()
        figure, panels = plt.subplots(*size, figsize=(style.PAGE_INCHES, 5.0), squeeze=False)
        for panel in panels.flat:
            surface_figures._show(panel, noise)
        for row, backend in enumerate(("null", "voxel", "sdf", "fcl")):
            surface_figures._row_name(panels[row, 0], backend, looks.colour(backend))
        surface_figures._finish(figure, "Title", [run], 5)
        paths.append(style.save_figure(figure, folder / name)[0])
    return paths


def test_a_backend_has_its_colour_in_every_picture(pictures):
    for path in pictures:
        found = np.array(sorted(colours_in(path)))
        for backend in ("null", "voxel", "sdf", "fcl"):  # thin strokes are smoothed by a step of 255
            assert np.abs(found - as_bytes(looks.colour(backend))).max(axis=1).min() <= 1, backend


def test_colour_bars_are_continuous(pictures):
    wanted = {as_bytes(DEPTH_COLOURS(step)) for step in range(256)}
    for path in pictures:
        assert len(wanted & colours_in(path)) > 200


def test_no_stage_has_the_colour_of_a_backend():
    from musclebench.figures.stages import COLOURS, OTHER_COLOURS
    backends = {looks.colour(name).lower() for name in ("null", "voxel", "sdf", "fcl", "bvh", "brute_force")}
    stages = [colour.lower() for colour in [*COLOURS.values(), *OTHER_COLOURS]]
    assert not backends & set(stages) and len(set(stages)) == len(stages)


@pytest.mark.long
def test_a_run_that_holds_nodes_is_not_on_the_front(tmp_path):
    """256 voxel cells leave no depth, hold nodes by false contacts and end far from the exact shape."""
    truth = fake_study.Truth(ms=0.2, remaining_mm=0.0, shift_mm=5.4, parameters={"cells": 256})
    fake_study.write_coupled(tmp_path / "raw" / "v", "lhdl/iliacus", "voxel", truth)
    fake_study.write_coupled(tmp_path / "raw" / "b", "lhdl/iliacus", "bvh", fake_study.Truth(ms=0.3, remaining_mm=0.0))
    coupled = of_mode(aggregates_of(read_cases(tmp_path)), "coupled")
    faults = coupled_faults.faults_of(coupled, shape_distances(coupled))
    assert [chosen.name for _, chosen in faults] == ["voxel 256"]
    assert "5.4 mm off" in coupled_faults.told(faults)
    report.write_report(tmp_path)
    points = pareto.pd.read_csv(tmp_path / "figures" / "pareto_coupled.csv").set_index("configuration")
    assert points.loc["voxel 256", "is_wrong"] and not points.loc["voxel 256", "on_front"]
    assert points.loc["bvh", "on_front"]
    assert "voxel 256 (" in (tmp_path / "figures" / "pareto_coupled.md").read_text()
