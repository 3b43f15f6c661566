"""Pictures of the hard cases: strips show what lies in a bone, and the matrix can be read."""

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

import fake_registry
import fake_runs
from musclebench.figures import looks
from musclebench.figures.cuts import cut
from musclebench.figures.effect_scenes import MUSCLE_COLOURS
from musclebench.figures.collisions import collisions
from musclebench.figures.hard_cases import draw_counts, draw_matrix, draw_strips
from musclebench.program.registry import parse_registry
from musclebench.results.run_folder import read_run
from printed import check_print, keep_figures


def test_a_cut_is_what_the_plane_meets():
    ball = fake_runs.sphere((1, 2, 3), 0.5, rings=24)
    (outline,) = cut(ball.vertices_m, ball.triangles, 2.3)
    radii = np.linalg.norm(outline - [1, 3], axis=1)
    assert radii.max() <= 0.4 + 1e-12 and radii.min() > 0.38  # sqrt(0.5^2 - 0.3^2), less than a facet's height below
    assert np.array_equal(outline[0], outline[-1])
    assert cut(ball.vertices_m, ball.triangles, 2.6) == []
    inner = fake_runs.sphere((1, 2, 3), 0.2)
    both = np.vstack([ball.triangles, inner.triangles + len(ball.vertices_m)])
    assert len(cut(np.vstack([ball.vertices_m, inner.vertices_m]), both, 2.01)) == 2


def test_an_open_surface_is_cut_from_border_to_border():
    ball = fake_runs.sphere((0, 0, 0), 1.0)
    middles = ball.vertices_m[ball.triangles].mean(axis=1)
    (outline,) = cut(ball.vertices_m, ball.triangles[middles[:, 2] > 0], 0.01)
    assert sorted(np.sign(outline[[0, -1], 0])) == [-1, 1] and abs(outline[[0, -1], 1]).max() < 0.3


def test_a_muscle_in_a_bone_is_seen(tmp_path, monkeypatch):
    """The bone hides nothing: at the start the muscle is wholly inside, at the end far outside."""
    muscle, bone = fake_runs.sphere((0, 0, 0), 0.02), fake_runs.sphere((0, 0, 0), 0.06)
    pose = (np.eye(3), np.zeros(3))
    shapes = [fake_runs.Snapshot(frame, 0.0, muscle.vertices_m + [away_m, 0, 0], np.zeros(len(muscle.vertices_m)),
                                 np.zeros(len(muscle.vertices_m)), [pose]) for frame, away_m in ((0, 0.0), (7, 0.01), (20, 0.4))]
    folder = fake_runs.write_run(tmp_path / "run", "hard/pinch", "fcl", status="suspect", bones={"jaw": bone},
                                 triangles=muscle.triangles, snapshots=shapes)
    kept = {}
    keep_figures(monkeypatch, kept)
    png = draw_strips([read_run(folder)], tmp_path / "scenes")[0]
    (figure, paths), = kept.values()
    check_print(figure, paths)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["pinch: suspect\nstart, frame 0", "\nworst, frame 7", "\nend, frame 20"]
    pixels = np.asarray(Image.open(png).convert("RGB"), dtype=float) / 255
    red = np.abs(pixels - to_rgb(MUSCLE_COLOURS[0])).max(axis=2) < 0.02
    for axes in figure.axes:
        left, right = (int(x * red.shape[1]) for x in (axes.get_position().x0, axes.get_position().x1))
        assert red[:, left:right].any(), axes.get_title(loc="left")


@pytest.mark.long
def test_the_matrix_of_every_backend_can_be_read(tmp_path, monkeypatch):
    """Libraries among them, with the titles of their studies."""
    listed = fake_registry.listed()
    some = listed["backends"][-1]
    names = [one["name"] for one in listed["backends"]]
    others = [path.parent.name for path in sorted(fake_registry.BACKENDS.glob("*/study.toml")) if path.parent.name not in names]
    listed["backends"] += [some | {"name": name, "study": {"title": fake_registry.study_of(name).get("title", name)}} for name in others]
    monkeypatch.setattr(looks, "_known", parse_registry(json.dumps(listed), "all of them"))
    rows = pd.DataFrame([{"case": case, "backend": name, "verdict": "refused"} for case in ("soundness", "step-size-unguarded")
                         for name in ("loop", *names, *others)])
    kept: dict = {}
    keep_figures(monkeypatch, kept)
    draw_matrix(rows, tmp_path / "matrix")
    check_print(*kept["matrix"])
    draw_counts(rows, tmp_path / "counts")
    check_print(*kept["counts"])


def test_bars_count_what_holds_breaks_and_is_refused(tmp_path, monkeypatch):
    told = {"sdf": ["holds", "holds", "breaks"], "bvh": ["breaks", "refused", "not applicable"]}
    rows = pd.DataFrame([{"case": f"case-{number}", "backend": backend, "verdict": verdict}
                         for backend, verdicts in told.items() for number, verdict in enumerate(verdicts) for _ in range(2)])
    kept: dict = {}
    keep_figures(monkeypatch, kept)
    draw_counts(rows, tmp_path / "counts")
    figure, _ = kept["counts"]
    bars = {bars.get_label(): [bar.get_width() for bar in bars] for bars in figure.axes[0].containers}
    assert bars == {"holds": [2, 0], "breaks": [1, 1], "refused": [0, 1]}
    assert collisions(figure) == []
