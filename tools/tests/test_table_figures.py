"""The figures of tools/speed and tools/budget, drawn from the published tables: what is held or ok is filled."""

import pandas as pd
import pytest

from copied_tools import PROJECT
from musclebench.figures.collisions import collisions
from musclebench.figures.budget import draw_substeps
from musclebench.figures.targets import HELD, draw_targets
from printed import check_print, keep_figures, texts_of


def published(name: str) -> pd.DataFrame:
    return pd.read_csv(PROJECT / "reports" / "measured" / f"{name}.csv", keep_default_na=False, na_values=[""])


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    kept = {}
    keep_figures(monkeypatch, kept)

    def draw(function, rows):
        function(rows, tmp_path / "figure")
        return kept["figure"]

    return draw


@pytest.mark.parametrize(("function", "table"), [(draw_targets, "speed-lhdl/speed"), (draw_substeps, "budget-lhdl/substeps")])
def test_it_is_drawn_for_print_and_nothing_covers_anything(drawn, function, table):
    figure, paths = drawn(function, published(table))
    check_print(figure, paths)
    assert collisions(figure) == []


def test_a_target_is_held_left_of_one(drawn):
    rows = pd.DataFrame({
        "what": ["less is better", "more is better", "missed", "no target", "none allowed"], "part": None,
        "target": ["<= 2, aim 1", ">= 4", ">= 3", "", "<= 0"], "measured": [1.0, 8.0, 1.5, 7.0, 0.0], "low": [0.8, 6.0, 1.2, 6.0, 0.0],
        "high": [1.6, 10.0, 2.0, 8.0, 0.0], "held": ["yes", "yes", "no", "", "yes"],
    })
    figure, _ = drawn(draw_targets, rows)
    points = [line for line in figure.axes[0].get_lines() if line.get_marker() == "o"]
    assert [line.get_xdata()[0] for line in points] == [0.5, 0.5, 2.0]
    assert [line.get_markerfacecolor() for line in points] == [HELD, HELD, "white"]
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == [
        "less is better  ≤ 2", "more is better  ≥ 4", "missed  ≥ 3"]
    spreads = [sorted(line.get_xdata()) for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 2][:3]
    assert spreads == [[0.4, 0.8], [0.4, pytest.approx(2 / 3)], [1.5, 2.5]]


def test_a_run_that_is_not_ok_is_hollow(drawn):
    rows = pd.DataFrame({"scene": "lhdl/iliacus", "substeps": [5, 10, 20], "rms_mm": [4.0, 2.0, 0.0],
                         "status": ["suspect", "ok (disturbed)", "ok"]})
    figure, _ = drawn(draw_substeps, rows)
    curve, hollow = figure.axes[0].get_lines()
    assert list(curve.get_xdata()) == [5, 10] and list(hollow.get_xdata()) == [5]
    assert "iliacus" in [text.get_text() for text in texts_of(figure)]


def test_nothing_is_drawn_of_nothing(tmp_path):
    assert draw_targets(published("speed-lhdl/speed").iloc[:0], tmp_path / "a") == []
    assert draw_substeps(published("budget-lhdl/substeps").iloc[:0], tmp_path / "b") == []
