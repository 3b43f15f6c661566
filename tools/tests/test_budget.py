"""The budget of a scene: one process a case, goes on where it was stopped; each source is refined alone and compared with its finest."""

import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import budget
import fake_registry
import fake_runs
from fake_sweep import swept
from musclebench.budget import budget_report, sources, substeps_table
from musclebench.budget.sources import Budget, Setting, Source
from musclebench.cases.case import Folders
from musclebench.experiments.selection import usual_backend
from musclebench.figures import looks
from musclebench.figures.budget import draw_budget
from musclebench.figures.collisions import collisions
from musclebench.results.run_folder import read_run
from printed import check_print, keep_figures

PROGRAM = Path(__file__).resolve().parent / "fake_musclebench.py"


@pytest.fixture
def study(tmp_path, monkeypatch, capfd):
    log = tmp_path / "log"

    def run(*more):
        monkeypatch.setenv("FAKE_LOG", str(log))
        log.write_text("")
        code = budget.main(["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--muscle", "iliacus",
                            "--finest", "2", "--backend", "sdf", "--frames-limit", "12", *more])
        return code, *capfd.readouterr(), sorted(line.split()[0] for line in log.read_text().splitlines())

    return run


ALL = ["iliacus-collision-sdf", "iliacus-iterations=2", "iliacus-start-1", "iliacus-start-2", "iliacus-start-3",
       "iliacus-substeps=1", "iliacus-substeps=2", "iliacus-substeps=3", "iliacus-substeps=6"]


def test_complete_runs_are_kept_and_the_table_has_a_row_a_source(study, tmp_path):
    code, text, errors, called = study()
    assert code == 0, errors
    assert called == ALL
    rows = pd.read_csv(tmp_path / "out" / "tables" / "budget.csv")
    assert list(rows["source"]) == ["time step", "iterations", "collision, distance field (sdf)", "rounding"]
    assert list(rows["setting"])[:2] == ["3 substeps", "1 iteration"]
    assert "synthetic/iliacus: no source moves the shape by more than rounding does" in text
    assert study()[3] == []
    assert study("--finest", "4")[3] == ["iliacus-iterations=4", "iliacus-substeps=12"]


def test_a_scene_of_several_muscles_takes_part(study):
    code, text, errors, called = study("--scene", "synthetic/hip")
    assert code == 0 and "hip-substeps=3" in called and "synthetic/hip" in text, errors


@pytest.mark.parametrize("arguments, words", [
    (["--finest", "many"], "invalid float value"), (["--backend", "box2d"], "--backend box2d: not built"),
    (["--muscle", "biceps"], "'biceps'"), (["--jobs", "0"], "--jobs 0"),
])
def test_bad_input_is_one_line(study, arguments, words):
    code, _, errors, called = study(*arguments)
    assert code == 2 and errors.count("\n") == 1 and words in errors and called == []


def test_only_what_is_refined_differs(tmp_path):
    """The time of a frame stays the same, whatever the number of substeps."""
    scene = fake_registry.scene("lhdl/iliacus")
    for case in swept("budget", scene):
        told = dict(word.split("=") for word in case.arguments(Folders(tmp_path)) if "=" in word)
        assert set(told) == {"time_step": {"substeps", "time_step_s"}, "iterations": {"iterations"}, "collision": set(),
                             "rounding": {"start_noise_m"}}[case.group.name]
        if case.group.name == "time_step":
            assert int(told["substeps"]) * float(told["time_step_s"]) == pytest.approx(3e-3)
        assert case.steps == case.frames * int(told.get("substeps", 3)) * int(told.get("iterations", 1))


def test_the_shell_wrapper_answers_for_help_without_building():
    done = subprocess.run([str(Path(budget.__file__).with_suffix("")), "--help"], capture_output=True, text=True,
                          timeout=60, check=False)
    assert done.returncode == 0 and "usage: tools/budget [" in done.stdout


def test_the_usual_backend_is_exact_and_fast():
    registry = fake_registry.registry()
    backend = usual_backend(registry)
    assert backend.is_exact and backend.of_role("clearance_cache")


def test_distances_are_to_the_run_of_the_most_substeps(tmp_path):
    folders = []
    for substeps, shift_m in ((5, 0.002), (20, 0.0)):
        ball = fake_runs.sphere((shift_m, 0, 0), 0.05)
        shot = fake_runs.Snapshot(10, 90.0, ball.vertices_m, 0 * ball.vertices_m[:, 0], 0 * ball.vertices_m[:, 0])
        folder = fake_runs.write_run(tmp_path / f"s{substeps}", "lhdl/iliacus", "bvh", triangles=ball.triangles,
                                     snapshots=[shot], loop={"substeps": substeps})
        folders.append(folder)
    rows = substeps_table.table([read_run(folder) for folder in folders]).rows.set_index("substeps")
    assert rows.loc[5, "rms_mm"] == pytest.approx(2.0) and rows.loc[5, "p99_mm"] == pytest.approx(2.0)
    assert rows.loc[20, "largest_mm"] == 0


def test_the_distance_of_shapes_is_the_root_of_the_mean_square(tmp_path):
    """Of four nodes one is 4 mm off."""
    triangles, folders = np.array([[0, 1, 2], [1, 3, 2]]), []
    for substeps, off_m in ((5, 0.004), (20, 0.0)):
        vertices_m = np.array([[0, 0, off_m], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
        shot = fake_runs.Snapshot(10, 90.0, vertices_m, np.zeros(4), np.zeros(4))
        folders.append(fake_runs.write_run(tmp_path / f"s{substeps}", "lhdl/iliacus", "bvh", triangles=triangles, snapshots=[shot],
                                           loop={"substeps": substeps}))
    row = substeps_table.table([read_run(folder) for folder in folders]).rows.set_index("substeps").loc[5]
    assert (row["rms_mm"], row["p99_mm"], row["largest_mm"]) == pytest.approx((2, 4, 4))


TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]])


def moved(folder: Path, off_mm: float, frame_ns: float = 1e6, backend: str = "bvh", status: str = "ok"):
    """A run whose shape at full flexion is off by so much, at each node; its frames take so long."""
    vertices_m = np.array([[0, 0, 1e-3 * off_mm], [1, 0, 1e-3 * off_mm], [0, 1, 1e-3 * off_mm], [1, 1, 1e-3 * off_mm]])
    shots = [] if status == "diverged" else [fake_runs.Snapshot(10, 90.0, vertices_m, np.zeros(4), np.zeros(4))]
    run = read_run(fake_runs.write_run(folder, "lhdl/iliacus", backend, status=status, triangles=TRIANGLES, snapshots=shots))
    run.frames["frame_ns"] = frame_ns
    return run


def refined(folder: Path, offs_mm: list[float], statuses: dict[int, str] | None = None) -> Source:
    """Settings x1, x2, x4, ...; each takes twice the time of the one before."""
    settings = [Setting(f"{2**i} parts", 2.0**i, moved(folder / f"{i}", off, 1e6 * 2**i, status=(statuses or {}).get(i, "ok")))
                for i, off in enumerate(offs_mm)]
    return Source("time_step", settings, settings[0], settings[-1].run)


def test_order_and_limit_are_those_of_a_known_series(tmp_path):
    """Shapes 8 / n^2 mm from the limit."""
    source = refined(tmp_path, [8.0, 2.0, 0.5, 0.125])
    assert source.errors()["shape_mm"] == pytest.approx(7.875)
    assert source.order() == pytest.approx(2.0)
    assert source.left_mm() == pytest.approx(0.125)
    assert source.halving().words == "2 parts"


def test_halving_counts_what_the_finest_is_off_itself(tmp_path):
    """Of order 1: 4 parts are half of 2 parts off from the limit, though they seem nearer to the finest."""
    source = refined(tmp_path, [8.0, 4.0, 2.0, 1.0])
    assert source.order() == pytest.approx(1.0) and source.left_mm() == pytest.approx(1.0)
    assert source.halving().words == "2 parts"


def test_no_order_is_told_where_none_is_seen(tmp_path):
    source = refined(tmp_path, [8.0, 3.0, 2.9, 1.0])
    assert np.isnan(source.order()) and source.left_mm() == pytest.approx(1.9)
    assert source.halving().words == "2 parts"


def test_the_finest_halves_only_where_an_order_tells_its_error(tmp_path):
    assert refined(tmp_path / "two", [8.0, 0.0]).halving() is None
    assert refined(tmp_path / "seen", [8.0, 4.0, 2.0, 1.0]).halving() is not None
    assert refined(tmp_path / "slow", [8.0, 7.0, 5.9, 3.0]).halving() is None


def test_what_did_not_reach_full_flexion_halves_nothing(tmp_path):
    source = refined(tmp_path, [8.0, 2.0, 0.5, 0.125], {1: "diverged"})
    assert source.halving().words == "4 parts"


def test_the_sentence_names_the_largest_source_and_its_price(tmp_path):
    steps = refined(tmp_path / "steps", [3.2, 1.6, 0.8, 0.4])
    exact, field = steps.own.run, moved(tmp_path / "sdf", 3.29, backend="sdf")
    collision = Setting("sdf", 1.0, field)
    found = Budget("lhdl/iliacus", "iliacus", [steps, Source("collision, sdf", [collision], collision, exact)], {"shape_mm": 0.01})
    text = sources.in_words(found, {"time_step": "time step", "collision, sdf": "collision, sdf"})
    assert text == ("lhdl/iliacus: most of the shape's error comes from the time step: 2.8 mm with 1 parts (collision, sdf 0.09 mm; "
                    "rounding 0.01 mm). 2 parts halve it for 2 times the time.")
    quiet = Budget("lhdl/iliacus", "iliacus", found.sources, {"shape_mm": 5.0})
    assert "no source moves the shape by more than rounding" in sources.in_words(quiet, {})


def test_bars_show_the_floor_and_what_is_below_it(tmp_path, monkeypatch):
    rows = pd.DataFrame({"scene": ["a"] * 3 + ["b"] * 2, "source": ["time step", "iterations", "rounding", "collision, sdf", "rounding"],
                         "setting": ["20 substeps", "1 iterations", "3 starts", "sdf", "3 starts"], "shape_mm": [3.2, 0.004, 0.02, 0.5, 0.1]})
    kept: dict = {}
    keep_figures(monkeypatch, kept)
    draw_budget(rows, tmp_path / "budget")
    figure, paths = kept["budget"]
    check_print(figure, paths)
    assert collisions(figure) == []
    first = figure.axes[0]
    assert [text.get_text() for text in first.get_yticklabels()] == ["time step: 20 substeps", "rounding: 3 starts", "iterations: 1 iterations"]
    assert [bar.get_width() for bar in first.containers[0]] == [3.2, 0.02, 0.004]
    assert len({bar.get_facecolor() for bar in first.containers[0]}) == 2
    assert draw_budget(rows.iloc[:0], tmp_path / "none") == []


def test_the_control_is_no_source(tmp_path):
    looks.know(fake_registry.registry())
    runs = {case: moved(tmp_path / case.name, 1.0, backend=case.configuration.backend)
            for case in swept("budget", fake_registry.scene("lhdl/iliacus"))}
    names = [source.name for source in budget_report.budget_of(runs).sources]
    assert "time_step" in names and "collision, distance field (sdf)" in names and not any("null" in name or "bvh" in name for name in names)
