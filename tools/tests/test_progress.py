"""The estimate counts work: what is measured beats what was guessed."""

import io
from dataclasses import replace
from itertools import pairwise

import pytest

import fake_registry
from musclebench.cases.case import Folders
from musclebench.experiments.experiment_file import experiment_path, read_experiment
from musclebench.cases.progress import Estimate, ProgressBar, duration
from fake_sweep import one_of, swept

ILIACUS = fake_registry.scene("lhdl/iliacus")
VOXEL, FCL = one_of("paper", ILIACUS, "voxel"), one_of("paper", ILIACUS, "fcl")
SMALL_FCL = one_of("paper", fake_registry.scene("lhdl/adductor_brevis"), "fcl")


def test_nothing_measured_counts_by_guessed_seconds():
    estimate = Estimate([VOXEL, FCL])
    assert estimate.seconds(VOXEL) == VOXEL.guessed_seconds
    assert estimate.seconds(FCL) == FCL.guessed_seconds > 2 * VOXEL.guessed_seconds
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


def test_the_plan_has_every_case_once_and_shuffled_by_its_seed():
    cases = swept("paper")
    assert len(cases) == len({case.name for case in cases}) == 4 * 7  # the paper's four, FCL as advised, an exact run and its floor
    assert swept("paper") == cases
    reseeded = swept(replace(read_experiment(experiment_path("paper")), seed=2))
    assert reseeded != cases and set(reseeded) == set(cases)


def test_snapshots_are_rest_half_and_full_flexion_the_end_and_the_motion_between():
    kept = VOXEL.snapshot_frames
    assert {0, 79, 157, 314} <= set(kept) and len(kept) == 22 and max(b - a for a, b in pairwise(kept)) == 16
    for frames, snapshots in ((20, list(range(21))), (1, [0, 1])):
        assert one_of("paper", fake_registry.scene("lhdl/iliacus", frames), "sdf").snapshot_frames == snapshots


def test_the_command_names_the_case(tmp_path):
    words = one_of("paper", fake_registry.scene("lhdl/iliacus", 20), "sdf").arguments(Folders(tmp_path / "out", tmp_path))
    assert words[:2] == ["run", "lhdl/iliacus"] and words[words.index("--backend") + 1] == "sdf"
    assert words[words.index("--data") + 1] == str(tmp_path) and words[words.index("--frames") + 1] == "20"
