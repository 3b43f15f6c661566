"""The estimate counts work: what is measured beats what was guessed."""

import io
from itertools import pairwise

import pytest

import fake_registry
from musclebench.cases.case import Folders
from musclebench.cases.progress import Estimate, ProgressBar, duration
from musclebench.paper.paper_cases import PaperCase, plan

SCENES = fake_registry.scenes("synthetic")
ILIACUS = fake_registry.scene("lhdl/iliacus")
VOXEL, FCL = PaperCase(ILIACUS, "voxel"), PaperCase(ILIACUS, "fcl")
SMALL_FCL = PaperCase(fake_registry.scene("lhdl/adductor_brevis"), "fcl")


def test_nothing_measured_counts_by_guessed_seconds():
    estimate = Estimate([VOXEL, FCL])
    assert estimate.seconds(VOXEL) == VOXEL.guessed_seconds
    assert estimate.seconds(FCL) == FCL.guessed_seconds > 5 * VOXEL.guessed_seconds
    assert estimate.fraction() == 0.0


def test_a_finished_case_weighs_what_it_took_and_corrects_its_backend():
    estimate = Estimate([VOXEL, FCL, SMALL_FCL], finished={FCL: 3 * FCL.guessed_seconds})
    assert estimate.seconds(FCL) == 3 * FCL.guessed_seconds
    assert estimate.seconds(SMALL_FCL) == pytest.approx(3 * SMALL_FCL.guessed_seconds)
    assert estimate.seconds(VOXEL) == pytest.approx(3 * VOXEL.guessed_seconds)
    assert estimate.remaining_seconds(1) == pytest.approx(3 * (SMALL_FCL.guessed_seconds + VOXEL.guessed_seconds))


def test_a_backend_is_corrected_from_its_own_runs_first():
    took = {FCL: 2 * FCL.guessed_seconds, VOXEL: 50 * VOXEL.guessed_seconds}
    estimate = Estimate([VOXEL, FCL, SMALL_FCL], finished=took)
    assert estimate.seconds(SMALL_FCL) == pytest.approx(2 * SMALL_FCL.guessed_seconds)


def test_a_running_case_is_extrapolated_from_its_fraction():
    estimate = Estimate([VOXEL, FCL], finished={VOXEL: 10.0}, running={FCL: (30.0, 0.25)})
    assert estimate.seconds(FCL) == 120.0
    assert estimate.total_seconds() == 130.0
    assert estimate.fraction() == pytest.approx(40.0 / 130.0)
    assert estimate.remaining_seconds(2) == pytest.approx(90.0)  # one case can't be split over two cores


def test_a_case_that_has_hardly_begun_is_not_extrapolated():
    estimate = Estimate([VOXEL], running={VOXEL: (8.0, 0.01)})
    assert estimate.seconds(VOXEL) == pytest.approx(max(8.0, VOXEL.guessed_seconds))


def test_all_finished_is_all_done():
    estimate = Estimate([VOXEL, FCL], finished={VOXEL: 1.0, FCL: 2.0})
    assert estimate.fraction() == 1.0 and estimate.remaining_seconds(2) == 0.0


def test_the_bar_never_runs_back():
    estimate = Estimate([VOXEL, FCL], finished={VOXEL: 10.0}, running={FCL: (5.0, 0.5)})
    stream = io.StringIO()
    bar = ProgressBar(estimate, 2, stream)
    bar.show(force=True)
    estimate.running[FCL] = (500.0, 0.5)
    bar.show(force=True)
    shares = [line.split("]")[1].split("%")[0] for line in stream.getvalue().splitlines()]
    assert shares == ["  75 ", "  75 "]


def test_off_a_terminal_lines_come_seldom():
    stream = io.StringIO()
    bar = ProgressBar(Estimate([VOXEL]), 1, stream)
    for _ in range(5):
        bar.show()
    assert stream.getvalue() == ""
    bar.end()
    assert stream.getvalue().count("\n") == 1


@pytest.mark.parametrize("seconds, text", [(0.2, "0 s"), (59.4, "59 s"), (60, "1:00 min"), (754, "12:34 min")])
def test_durations_read_well(seconds, text):
    assert duration(seconds) == text


def test_the_plan_has_every_case_once_shuffled_with_long_ones_first():
    cases = plan(SCENES)
    assert len(cases) == len(set(cases)) == 16
    assert {case.backend for case in cases[:3]} == {"fcl"}
    assert plan(SCENES) == cases != plan(SCENES, seed=2)


def test_snapshots_are_rest_half_and_full_flexion_the_end_and_the_motion_between():
    kept = VOXEL.snapshot_frames
    assert {0, 79, 157, 314} <= set(kept) and len(kept) == 22 and max(b - a for a, b in pairwise(kept)) == 16
    assert PaperCase(fake_registry.scene("lhdl/iliacus", 20), "sdf").snapshot_frames == list(range(21))
    assert PaperCase(fake_registry.scene("lhdl/iliacus", 1), "sdf").snapshot_frames == [0, 1]


def test_the_command_names_the_case(tmp_path):
    words = PaperCase(fake_registry.scene("lhdl/iliacus", 20), "sdf").arguments(Folders(tmp_path / "out", tmp_path))
    assert words[:4] == ["run", "lhdl/iliacus", "--backend", "sdf"]
    assert words[words.index("--data") + 1] == str(tmp_path) and words[words.index("--frames") + 1] == "20"
