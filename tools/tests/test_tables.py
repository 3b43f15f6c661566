"""The tables hold the numbers that follow from known runs."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import fake_runs
from musclebench.figures import paper_figures
from musclebench.paper import published
from musclebench.results import run_folder
from musclebench.results.statistics import median_ratio
from musclebench.tables import library_table, muscle_tables, paper_tables, table_formats


@pytest.fixture
def made(fake_raw):
    runs = run_folder.read_runs(fake_raw)
    paper = published.read_published()
    return paper_tables.memory_table(runs, paper), paper_tables.time_table(runs, paper)


def row_of(table, muscle, backend):
    rows = table.rows
    return rows[(rows["muscle"] == muscle) & (rows["backend"] == backend)].iloc[0]


def test_memory_is_given_as_total_offset_and_structures_beside_the_paper(made):
    row = row_of(made[0], "iliacus", "fcl")
    assert (row["first_mb"], row["last_mb"], row["structure_mb"]) == (200.0, 220.0, 90.0)
    assert (row["first_offset_mb"], row["last_offset_mb"]) == (90.0, 90.0)
    assert (row["paper_first_mb"], row["paper_first_offset_mb"], row["paper_last_offset_mb"]) == (786, 249, 303)


def test_null_has_no_numbers_in_the_paper(made):
    row = row_of(made[0], "iliacus", "null")
    assert np.isnan(row["paper_first_mb"]) and row["first_offset_mb"] == -10.0


def test_times_ratios_and_rates_follow_from_the_frames(made):
    row = row_of(made[1], "gluteus_medius", "sdf")
    assert row["collision_ms"] == 3.0 and row["ratio"] == row["ratio_low"] == row["ratio_high"] == 3.0
    assert row["fps"] == pytest.approx(1e9 / 4e6) and row["fps_without"] == pytest.approx(1e9 / 1e6)
    assert (row["missed_contacts"], row["false_contacts"]) == (20, 40)
    assert row["largest_depth_mm"] == pytest.approx(2.0)
    assert row["paper_ratio"] == "~3"


def test_frames_a_second_are_those_of_all_timed_frames_together():
    frames = pd.DataFrame({"frame": [1, 2, 3, 4, 5], "warm_up": [1, 0, 0, 0, 0], "frame_ns": [9e9, 1e6, 2e6, 3e6, np.nan]})
    assert paper_tables.frames_per_second(run_folder.Run(Path("run"), {}, frames)) == pytest.approx(3 / 6e-3)
    assert np.isnan(paper_tables.frames_per_second(None))


def test_rows_come_in_the_order_of_the_paper(made):
    assert made[1].rows["muscle"].unique().tolist() == list(fake_runs.MUSCLES)
    assert made[1].rows["backend"].tolist()[:4] == fake_runs.backends()


def test_without_voxel_there_is_no_ratio(fake_raw):
    runs = [run for run in run_folder.read_runs(fake_raw) if run.backend != "voxel"]
    row = row_of(paper_tables.time_table(runs, published.read_published()), "iliacus", "fcl")
    assert np.isnan(row["ratio"]) and row["collision_ms"] == 200.0


def test_muscles_of_one_name_in_two_scenes_have_rows_and_figures_of_their_own(tmp_path):
    for scene, frames in (("lhdl/iliacus", 20), ("synthetic/iliacus", 7), ("synthetic/adductor_brevis", 5)):
        for backend in ("voxel", "sdf"):
            fake_runs.write_run(tmp_path / "raw" / f"{scene.replace('/', '-')}-{backend}", scene, backend, frames)
    runs, paper = run_folder.read_runs(tmp_path / "raw"), published.read_published()
    rows = paper_tables.time_table(runs, paper).rows
    assert rows["muscle"].unique().tolist() == ["adductor_brevis", "lhdl-iliacus", "synthetic-iliacus"]
    assert rows[rows["backend"] == "sdf"]["frames"].tolist() == [5, 20, 7]
    of_memory = row_of(paper_tables.memory_table(runs, paper), "synthetic-iliacus", "voxel")
    assert of_memory["paper_first_mb"] == paper.memory("iliacus", "voxel", "first_mb")
    assert paper_figures.muscle_of_figures(run.muscle for run in runs) == "lhdl-iliacus"


def test_a_diverged_run_is_compared_over_the_frames_it_has(tmp_path):
    fake_runs.write_run(tmp_path / "a", "lhdl/iliacus", "voxel", frames=20)
    fake_runs.write_run(tmp_path / "b", "lhdl/iliacus", "fcl", frames=7, status="diverged", detail="frame 7")
    row = row_of(paper_tables.time_table(run_folder.read_runs(tmp_path), published.read_published()), "iliacus", "fcl")
    assert row["status"] == "diverged" and row["frames"] == 7 and row["ratio"] == 200.0


def test_text_fits_100_columns_and_names_every_case(made):
    for table in made:
        text = table_formats.as_text(table)
        assert max(map(len, text.splitlines())) <= 100
        assert all(text.count(f"\n  {backend} ") == 4 for backend in fake_runs.backends())


def test_files_agree_with_the_rows(made, tmp_path):
    paths = table_formats.write_table(made[0], tmp_path)
    assert [path.suffix for path in paths] == [".csv", ".md", ".tex"]
    read_back = pd.read_csv(paths[0])
    assert read_back["first_mb"].tolist() == made[0].rows["first_mb"].tolist()
    markdown, latex = paths[1].read_text(), paths[2].read_text()
    assert markdown.count("\n| ") == 18 and "| iliacus | fcl | ok | 200.0 | 220.0 | 90.0 |" in markdown
    assert "\\emph{gluteus maximus}" in latex and "fcl & 200.0 & 220.0" in latex


def test_latex_tables_fit_a_page(made):
    wide = pd.concat([made[1].rows] * 6, ignore_index=True)
    for table in (*made, table_formats.Table("all", "All", made[1].columns, wide, [c.key for c in made[1].columns])):
        shown = [column for column in table.columns if column.key in table.shown]
        for group in table_formats.latex_column_groups(table, shown):
            assert sum(table_formats._latex_width(table, column) for column in group) <= table_formats.LATEX_WIDTH
        parts = table_formats.as_latex(table).split("\\begin{table*}")[1:]
        assert all("\\toprule" in part and "\\bottomrule" in part for part in parts)
        assert max(part.count("\\\\") for part in parts) <= table_formats.LATEX_HEIGHT / table_formats.LATEX_LINE
    assert len(table_formats.as_latex(made[0]).split("\\begin{table*}")) == 2  # the paper's table in one piece


def test_no_column_that_a_terminal_shows_is_lost_in_latex(made):
    for table in made:
        shown = [column for column in table.columns if column.key in table.shown]
        groups = table_formats.latex_column_groups(table, shown)
        assert {column.key for group in groups for column in group} == set(table.shown)


def test_the_ratio_is_matched_by_frame():
    times, reference = pd.Series([4.0, 60.0, 9.0], index=[1, 2, 3]), pd.Series([3.0, 2.0], index=[3, 1])
    ratio = median_ratio(times, reference)
    assert ratio.frames == 2 and ratio.value == pytest.approx(2.5)


def noisy_ratio(count, seed):
    times = pd.Series(3.0 + np.random.default_rng(seed).normal(0, 0.5, count))
    return median_ratio(times, pd.Series(np.ones(count)), draws=200)


def test_the_interval_mostly_holds_the_true_ratio():
    ratios = [noisy_ratio(200, seed) for seed in range(40)]
    assert all(ratio.low <= ratio.value <= ratio.high for ratio in ratios)
    assert 32 <= sum(ratio.low <= 3.0 <= ratio.high for ratio in ratios)


def test_the_interval_narrows_with_more_frames():
    few, many = noisy_ratio(100, 1), noisy_ratio(10000, 1)
    assert many.high - many.low < 0.3 * (few.high - few.low)


def test_no_common_frames_give_no_ratio():
    assert np.isnan(median_ratio(pd.Series([1.0], index=[1]), pd.Series([1.0], index=[2])).value)


@pytest.mark.parametrize(
    "value, text", [(0.7164, "0.716"), (2.5, "2.50"), (99.94, "99.9"), (1046.7, "1047"), (0.0, "0")]
)
def test_ratios_have_three_digits_and_no_exponent(value, text):
    assert table_formats.as_ratio(value) == text


def test_what_rounds_to_zero_has_no_sign():
    column = table_formats.Column("offset", "offset", 1)
    rows = pd.DataFrame({"offset": [-0.04, -0.06]})
    assert table_formats.as_cells(table_formats.Table("t", "", [column], rows, ["offset"]), [column]) == [["0.0"], ["-0.1"]]


def test_a_pair_has_its_median_time_without_warm_up_and_its_most_contacts(fake_raw):
    run = run_folder.read_runs(fake_raw)[0]
    timed = set(run.timed_frames["frame"])
    assert len(timed) < len(run.frames)
    run.pairs = pd.DataFrame(columns=fake_runs.PAIR_COLUMNS, data=[
        {"frame": frame, "angle_deg": 0.0, "muscle": "a", "other": other, "contacts": contacts if frame in timed else 9,
         "detect_ns": 1e6 * (time_ms if frame in timed else 100)}
        for frame in run.frames["frame"] for other, contacts, time_ms in (("b", 3, 2.0), ("c", 0, 0.5))])
    table = muscle_tables.pair_table([run])
    rows = table.rows
    assert list(rows["muscle"]) == ["a, b", "a, c"] and "a, b" in table_formats.as_text(table)
    assert list(rows["detect_ms"]) == [2.0, 0.5] and list(rows["contacts"]) == [9, 9]


def test_a_library_stands_with_its_replay_and_the_hard_cases_that_all_were_asked():
    row = {"mode": "replay", "backend": "tree", "configuration": "tree", "parameters": "{}", "threads": 1, "status": "ok",
           "collision_ms": 0.5, "collision_ms_low": 0.4, "collision_ms_high": 0.6, "is_disturbed": False, "times_unit": 2.0,
           "frames": 312, "build_s": 0.1, "structure_bytes": 3e6, "missed_contacts": 4, "true_contacts": 20, "false_contacts": 0,
           "max_missed_depth_m": 1e-4, "p99_offset_m": 2e-4}
    plain = row | {"configuration": "tree as first tried", "parameters": '{"cull": "false"}', "is_disturbed": True}
    study = pd.DataFrame([row, plain, row | {"backend": "grid", "configuration": "grid 8"}, row | {"mode": "coupled"},
                          plain | {"configuration": "tree plain", "collision_ms": float("nan"), "status": "timeout"}])
    cells = pd.DataFrame([{"case": case, "backend": backend, "verdict": verdict} for case, backend, verdict in (
        ("a", "tree", "holds"), ("a", "grid", "breaks"), ("b", "tree", "refused"), ("b", "grid", "holds"),
        ("c", "tree", "not applicable"), ("c", "grid", "holds"))])
    columns, rows = library_table.library_table(study, cells)
    rows = rows.set_index("configuration")
    assert columns[-1].title == "held of 2 hard cases" and list(rows["hard"]) == ["1", "", "1", ""]
    assert list(rows["ms"]) == ["0.500 (0.400 to 0.600)", "0.500 (0.400 to 0.600) *", "0.500 (0.400 to 0.600)", "not run: too long"]
    assert rows.loc["`tree`", "missed"] == "4 of 20" and rows.loc["`tree`", "deepest_mm"] == 0.1
