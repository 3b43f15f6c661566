"""Scenes of several muscles, from muscles.csv and pairs.csv to tables and figures, without a display."""

import numpy as np
import pandas as pd
import pytest

import fake_runs
import paper
from musclebench.pictures import surface_figures
from musclebench.results import snapshots
from musclebench.results.run_folder import read_run
from musclebench.tables.table_formats import as_text
from musclebench.figures.collisions import drawn_texts
from printed import check_print, keep_figures

MUSCLES = {"front": 266, "middle": 266, "back": 266}
FRAMES = (0, 5, 10, 20)
NAMES = ["hip-null", "hip-sdf"]


@pytest.fixture
def out(tmp_path):
    """The runs of one scene of three muscles in a row, each a ball, with snapshots."""
    balls = [fake_runs.sphere((0, 0, 0.03 * index), 0.02) for index, _ in enumerate(MUSCLES)]
    vertices = np.vstack([ball.vertices_m for ball in balls])
    triangles = np.vstack([ball.triangles + 266 * index for index, ball in enumerate(balls)])
    bones = {"pelvis": fake_runs.sphere((0, 0.03, 0.03), 0.02), "femur": fake_runs.sphere((0, 0.03, -0.05), 0.02)}
    still = np.zeros(len(vertices))
    poses = [(np.eye(3), np.zeros(3))] * 2
    shots = [fake_runs.Snapshot(frame, 90.0 * (1 - abs(frame / 10 - 1)), vertices, still, vertices[:, 2] > 0.06, poses)
             for frame in FRAMES]
    for name in NAMES:
        fake_runs.write_run(tmp_path / "raw" / name, "synthetic/hip", name.removeprefix("hip-"), bones=bones,
                            triangles=triangles, snapshots=shots, muscles=MUSCLES)
    return tmp_path


class Studio:
    """Pictures of noise; what was asked of the true one."""

    asked = []

    def __init__(self, run):
        self.bones = snapshots.read_bones(run)

    def __getattr__(self, name):
        def picture(*arguments, **named):
            self.asked.append((name, *arguments[1:], *named.values()))
            return np.random.default_rng(1).integers(100, 255, (200, 200, 3), dtype=np.uint8)

        return picture


def test_tables_say_how_deep_each_muscle_is_and_what_each_pair_takes(out):
    _, tables, files = paper.write_report(out, NAMES)
    times, depths, pairs = (table.rows.set_index("backend").loc[["sdf"]] for table in tables[2:])
    assert [table.name for table in tables[2:]] == ["table_3_frame_times", "table_4_depths", "table_5_pairs"]
    assert times[["edge_length_ms", "bending_ms", "detect_ms", "frame_ms"]].values.tolist() == [[0.6, 0.4, 3, 4]]
    assert not {"recording_ms", "judging_ms", "collision_ms"} & set(times)
    assert depths["muscle"].tolist() == ["back", "front", "middle"] and set(depths["scene"]) == {"hip"}
    for column, numbers in {
        "bone_depth_mm": [3, 1, 2], "bone_nodes": [9, 3, 6], "muscle_depth_mm": [1.5, 0.5, 1], "muscle_nodes": [6, 2, 4],
        "volume_change_percent": [3, 1, 2], "edge_stretch": [1.3, 1.1, 1.2],
    }.items():
        assert depths[column].tolist() == pytest.approx(numbers), column
    assert pairs["muscle"].tolist() == ["back, femur", "back, pelvis", "front, femur", "front, middle", "front, pelvis",
                                        "middle, back", "middle, femur", "middle, pelvis"]
    assert pairs["detect_ms"].tolist() == [6, 3, 4, 7, 1, 8, 5, 2]
    assert pairs["contacts"].tolist() == [24, 12, 16, 28, 4, 32, 20, 8]
    for table in tables[2:]:
        assert pd.read_csv(out / "tables" / f"{table.name}.csv").shape == table.rows.shape
        assert out / "tables" / f"{table.name}.tex" in files
        assert max(map(len, as_text(table).splitlines())) <= 110


def test_a_run_that_failed_early_has_no_rows_of_muscles(out):
    fake_runs.write_run(out / "raw" / "hip-fcl", "synthetic/hip", "fcl", frames=0, status="failed")
    _, tables, _ = paper.write_report(out, [*NAMES, "hip-fcl"])
    assert all(set(table.rows["backend"]) == {"null", "sdf"} for table in tables[2:])


def test_one_muscle_has_neither_of_these_tables(tmp_path):
    fake_runs.write_run(tmp_path / "raw" / "one", "synthetic/iliacus", "sdf")
    assert len(paper.write_report(tmp_path, ["one"])[1]) == 2


@pytest.mark.long
def test_each_muscle_has_its_colour_in_a_figure_of_all(out, monkeypatch):
    kept = {}
    keep_figures(monkeypatch, kept)
    monkeypatch.setattr(surface_figures, "Studio", Studio)
    monkeypatch.setattr(Studio, "asked", [])
    runs = [read_run(out / "raw" / name) for name in NAMES]
    (out / "figures").mkdir()
    files = surface_figures.draw_surface_figures(runs, out / "figures", lambda text: None)
    assert set(kept) == {"fig_6_hip", "muscles_at_full_flexion", "muscles_of_hip", "half_flexion_of_hip", "attachments"}
    assert all(path.stat().st_size > 0 for path in files)
    for figure, paths in kept.values():
        check_print(figure, paths)
    words = {text.get_text() for text in drawn_texts(kept["muscles_of_hip"][0])}
    assert {*MUSCLES, "frame 5, 45°", "frame 20, 0°", "muscle's side", "other side", "Hip with distance field (sdf)"} <= words
    of_all = [rest for name, *rest in Studio.asked if name == "muscles"]
    assert of_all == [[[266] * 3, from_behind] for _ in FRAMES for from_behind in (False, True)]
