"""The budget of a scene: one process a case, goes on where it was stopped; each source is refined alone and compared with its finest."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import budget
import fake_registry
import fake_runs
from fake_sweep import swept
from musclebench.budget import budget_report, choice, sources, substeps_table
from musclebench.budget.sources import Budget, Setting, Source
from musclebench.cases.case import Folders
from musclebench.experiments.selection import usual_backend
from musclebench.figures import looks
from musclebench.figures.budget import draw_budget
from musclebench.figures.collisions import collisions
from musclebench.program.cli import Problem
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


ALL = ["iliacus-collision-sdf", "iliacus-iterations=2", "iliacus-smooth_bones=1", "iliacus-smooth_bones=2",
       "iliacus-split_muscles=1-substeps=3", "iliacus-split_muscles=1-substeps=6", "iliacus-start-1", "iliacus-start-2", "iliacus-start-3",
       "iliacus-substeps=1", "iliacus-substeps=2", "iliacus-substeps=3", "iliacus-substeps=6"]


def test_complete_runs_are_kept_and_the_table_has_a_row_a_source(study, tmp_path):
    code, text, errors, called = study()
    assert code == 0, errors
    assert called == ALL
    rows = pd.read_csv(tmp_path / "out" / "tables" / "budget.csv")
    assert list(rows["source"]) == ["time step", "iterations", "muscle mesh", "bone mesh", "collision, distance field (sdf)", "rounding"]
    assert list(rows["setting"])[:4] == ["3 substeps", "1 iteration", "its own triangles, 6 substeps", "its own triangles"]
    assert list(rows["reference"])[2:4] == ["4 times the triangles, 6 substeps", "16 times the triangles"]
    assert (tmp_path / "out" / "tables" / "budget.txt").read_text().strip() in text
    assert "synthetic/iliacus: no source moves the shape by more than rounding" in text
    assert study()[3] == []
    assert study("--finest", "4")[3] == ["iliacus-iterations=4", "iliacus-split_muscles=1-substeps=12", "iliacus-substeps=12"]


def test_a_scene_of_several_muscles_takes_part(study):
    code, text, errors, called = study("--scene", "synthetic/hip")
    assert code == 0 and "hip-substeps=3" in called and "synthetic/hip" in text, errors


@pytest.mark.parametrize("arguments, words", [
    (["--finest", "many"], "invalid int value"), (["--finest", "1"], "--finest 1: nothing is refined"), (["--backend", "box2d"], "--backend box2d: not built"),
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
                             "rounding": {"start_noise_m"}, "muscle_mesh": {"split_muscles", "substeps", "time_step_s"},
                             "bone_mesh": {"smooth_bones"}}[case.group.name]
        if "substeps" in told:
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
    shots = [fake_runs.Snapshot(10, 90.0, vertices_m, np.zeros(4), np.zeros(4))]
    run = read_run(fake_runs.write_run(folder, "lhdl/iliacus", backend, status=status, triangles=TRIANGLES, snapshots=shots))
    run.frames["frame_ns"] = frame_ns
    return run


def refined(folder: Path, offs_mm: list[float]) -> Source:
    """Settings x1, x2, x4, ...; each takes twice the time of the one before."""
    settings = [Setting(f"{2**i} parts", 2.0**i, moved(folder / f"{i}", off, 1e6 * 2**i)) for i, off in enumerate(offs_mm)]
    return Source("time step", settings, settings[0], settings[-1])


def test_order_and_limit_are_those_of_a_known_series(tmp_path):
    """Shapes 8 / n^2 mm from the limit."""
    source = refined(tmp_path, [8.0, 2.0, 0.5, 0.125])
    assert source.errors()["shape_mm"] == pytest.approx(7.875)
    assert source.order() == pytest.approx(2.0) and source.has_settled()
    assert source.left_mm() == pytest.approx(0.125) and source.most_mm() == pytest.approx(8.0)
    assert source.halving().words == "2 parts"
    assert source.halving(floor_mm=9.0) is None, "an error below the floor tells nothing"


def test_halving_counts_what_the_finest_is_off_itself(tmp_path):
    """Of order 1: 4 parts are half of 2 parts off from the limit, though they seem nearer to the finest."""
    source = refined(tmp_path, [8.0, 4.0, 2.0, 1.0])
    assert source.order() == pytest.approx(1.0) and source.left_mm() == pytest.approx(1.0)
    assert source.halving().words == "2 parts"


@pytest.mark.parametrize(("offs_mm", "has_settled", "halved_by"), [
    ([10.0, 8.71, 7.58, 6.60], False, None), ([0.0, 3.0, 0.0, 3.0], False, None), ([1.0, 1.0, 1.0, 1.0], True, None),
    ([8.0, 3.0, 2.9, 2.85], True, "2 parts"), ([8.0, 5.0, 3.2, 2.0], True, "4 parts"), ([8.0, 0.0], False, None), ([8.0, 7.0, 5.9, 3.0], False, None)])
def test_nothing_is_said_to_halve_what_has_not_settled(tmp_path, offs_mm, has_settled, halved_by):
    source = refined(tmp_path, offs_mm)
    assert source.has_settled() == has_settled
    better = source.halving()
    assert (better.words if better else None) == halved_by


def test_no_order_is_told_where_none_is_seen(tmp_path):
    source = refined(tmp_path, [8.0, 3.0, 2.9, 1.0])
    assert np.isnan(source.order()) and source.left_mm() == pytest.approx(1.9)


def budget_with(tmp_path, **more) -> Budget:
    steps = refined(tmp_path / "steps", [3.2, 1.6, 0.8, 0.4])
    field = Setting("sdf", 1.0, moved(tmp_path / "sdf", 3.29, backend="sdf"))
    bad = Setting("voxel", 1.0, moved(tmp_path / "voxel", 50.0, backend="voxel", status="diverged"))
    found = [steps, *(Source(f"collision, {one.words}", [one], one, steps.own) for one in (field, bad))]
    usual = {"scene": "lhdl/iliacus", "muscle": "iliacus", "own": steps.own.run, "sources": found,
             "floors": [{"shape_mm": 0.01}, {"shape_mm": 0.002}]}
    return Budget(**(usual | more))


def test_the_sentence_names_the_largest_source_what_ended_badly_and_the_price(tmp_path):
    found = budget_with(tmp_path)
    assert sources.in_words(found) == (
        "lhdl/iliacus: most of the shape's error comes from the time step: 2.8 ± 0.4 mm with 1 parts (collision, sdf 0.09 mm; "
        "rounding 0.01 mm). Not judged: voxel: diverged. 2 parts halve the error of the time step for 2 times the time.")
    quiet = budget_with(tmp_path / "quiet", floors=[{"shape_mm": 5.0}])
    assert "no source moves the shape by more than rounding 5 mm" in sources.in_words(quiet)
    unknown = budget_with(tmp_path / "unknown", floors=[])
    assert "rounding not known" in sources.in_words(unknown)


def test_a_source_is_ranked_with_what_its_finest_is_off(tmp_path):
    """Two settings only: the finest may be as far from the limit as its last step was long."""
    steps = refined(tmp_path / "steps", [8.0, 4.0])
    field = Setting("sdf", 1.0, moved(tmp_path / "sdf", 13.0, backend="sdf"))
    found = Budget("a", "m", steps.own.run, [Source("collision, sdf", [field], field, steps.own), steps], [])
    text = sources.in_words(found)
    assert text.startswith("a: most of the shape's error comes from the time step: 4 ± 4 mm")
    assert text.endswith("What halves the error of the time step is not known: refining it has not settled.")


def test_rows_leave_out_what_ended_badly_and_times_are_over_the_exact_run(tmp_path):
    found = budget_with(tmp_path)
    rows = pd.DataFrame(budget_report._rows(found)).set_index("source")
    assert rows.loc["collision, voxel", "status"] == "diverged" and np.isnan(rows.loc["collision, voxel", "shape_mm"])
    assert rows.loc["time step", "reference"] == "8 parts" and rows.loc["collision, sdf", "reference"] == "1 parts"
    steps = found.sources[0]
    steps.reference.run.record["status"] = "suspect"
    assert budget_report._rows(found)[0]["reference"] == "8 parts (suspect)"
    assert rows.loc["time step", "price"] == pytest.approx(2.0)
    assert rows.loc["rounding", "setting"] == "2 starts" and rows.loc["rounding", "shape_mm"] == 0.01
    settings = pd.DataFrame(budget_report._setting_rows(found))
    assert list(settings["times"]) == pytest.approx([1, 2, 4, 8, 1, 1])
    assert settings["shape_mm"].isna().tolist() == [False, False, False, True, False, True]


def runs_of(tmp_path, scene, status):
    """The cases of the experiment without a program; `status` of a case's name."""
    looks.know(fake_registry.registry())
    return {case: moved(tmp_path / case.name, 1.0, backend=case.configuration.backend, status=status(case.name))
            for case in swept("budget", scene)}


def test_the_control_and_the_exact_are_no_sources(tmp_path):
    found = budget_report.budget_of(runs_of(tmp_path, fake_registry.scene("lhdl/iliacus"), lambda name: "ok"))
    names = [source.name for source in found.sources]
    assert names[:2] == ["time step", "iterations"] and "collision, distance field (sdf)" in names
    assert not any("null" in name or "bvh" in name for name in names) and len(found.floors) == 3
    without = next(row for row in budget_report._rows(found) if row["source"] == budget_report.WITHOUT)
    assert without["shape_mm"] == 0 and "null" in without["setting"]
    assert "Without any collision the shape is 0 mm from the exact run's." in sources.in_words(replace(found, floors=[]))


@pytest.mark.parametrize(("bad", "told"), [
    ("substeps=3", "no budget: the exact run of the scene's own setting ended with the status diverged"),
    ("substeps=", "no budget"), ("iterations", ("time step", "muscle mesh", "bone mesh")), ("start", "rounding not known"),
    ("substeps=6 substeps=12 substeps=24", ("iterations", "bone mesh")), ("split_muscles=1-substeps=12", ("time step", "iterations", "bone mesh")),
    ("smooth_bones=1 smooth_bones=2", ("time step", "iterations", "muscle mesh"))])
def test_a_budget_is_told_of_what_ended_well(tmp_path, bad, told):
    runs = runs_of(tmp_path, fake_registry.scene("lhdl/iliacus"),
                   lambda name: "diverged" if any(name.endswith(word) or (word in name and word[-1] in "=st") for word in bad.split()) else "ok")
    found = budget_report.budget_of(runs)
    if isinstance(found, str):
        assert told in found
    elif isinstance(told, str):
        assert found.floors == [] and told in sources.in_words(found)
    else:
        refined_names = [source.name for source in found.sources if source.is_refined]
        assert refined_names == list(told)


def of_muscles(folder: Path, off_mm: dict[str, list[float]], splits: int = 0):
    """A run of several muscles, each vertex so far from the origin."""
    vertices_m = np.array([[1e-3 * off, 0, 0] for offs in off_mm.values() for off in offs])
    shots = [fake_runs.Snapshot(10, 90.0, vertices_m, np.zeros(len(vertices_m)), np.zeros(len(vertices_m)))]
    run = read_run(fake_runs.write_run(folder, "lhdl/hip", "bvh", triangles=TRIANGLES, snapshots=shots,
                                       muscles={name: len(offs) for name, offs in off_mm.items()}))
    run.record["case"]["meshes"] = {"split_muscles": splits}
    return run


def test_a_finer_mesh_is_compared_at_the_vertices_of_the_coarse_one(tmp_path):
    """Those of each muscle are followed by its new ones. Two meshes of which neither is a split of the other are not compared."""
    coarse, fine_mm = of_muscles(tmp_path / "coarse", {"a": [0, 0, 0], "b": [10, 10]}), {"a": [1, 1, 1, 90, 90], "b": [12, 12, 70]}
    fine = of_muscles(tmp_path / "fine", fine_mm, splits=1)
    for ours, theirs in ((coarse, fine), (fine, coarse)):
        assert list(sources.node_distances_mm(ours, theirs)) == pytest.approx([1, 1, 1, 2, 2])
    assert sources.node_distances_mm(coarse, of_muscles(tmp_path / "other", {"a": [0, 0, 0, 10], "b": [10, 10], "c": [5, 5]}, splits=1)) is None
    assert sources.node_distances_mm(coarse, of_muscles(tmp_path / "same", fine_mm)) is None


def test_the_finer_muscle_mesh_is_off_by_its_step_and_by_what_its_time_step_still_moves(tmp_path):
    own, fine = Setting("its own triangles", 1.0, moved(tmp_path / "own", 0.0)), Setting("4 times", 2.0, moved(tmp_path / "fine", 4.0))
    source = Source("muscle mesh", [own, fine], own, fine, nearly=moved(tmp_path / "nearly", 3.5))
    assert source.errors()["shape_mm"] == pytest.approx(4.0) and source.left_mm() == pytest.approx(4.5)
    assert not source.has_settled() and source.halving() is None


def test_splits_come_on_top_of_those_of_the_scene(tmp_path):
    scene = replace(fake_registry.scene("lhdl/iliacus"), split_muscles=1, smooth_bones=2)
    words = {case.name: case.arguments(Folders(tmp_path)) for case in swept("budget", scene)}
    assert "split_muscles=2" in words["iliacus-split_muscles=1-substeps=24"] and "smooth_bones=3" in words["iliacus-smooth_bones=1"]
    assert "split_muscles=2" not in words["iliacus-substeps=24"]
    finest = {case.name for case in swept("budget", replace(scene, split_muscles=4, smooth_bones=3))}
    assert "iliacus-smooth_bones=1" in finest and not any("smooth_bones=2" in name or "split_muscles" in name for name in finest)


def test_a_scene_that_changes_its_time_step_is_refused():
    with pytest.raises(Problem, match="time_step_change"):
        swept("budget", replace(fake_registry.scene("lhdl/iliacus"), has_step_changes=True))


def test_steps_that_shrink_slowly_leave_more_than_the_last(tmp_path):
    """8, 4.5, 3 and so on: a third each time, so that twice the last step is still to come."""
    assert refined(tmp_path, [15.5, 7.5, 3.0, 0.0]).left_mm() == pytest.approx(3.0 * (2 / 3) / (1 / 3))


def test_meshes_are_refined_where_the_time_step_is_finest(tmp_path):
    runs = runs_of(tmp_path, fake_registry.scene("lhdl/iliacus"), lambda name: "ok")
    found = {source.name: source for source in budget_report.budget_of(runs).sources}
    by_name = {case.name: run for case, run in runs.items()}
    mesh, bones = found["muscle mesh"], found["bone mesh"]
    assert mesh.own.run is by_name["iliacus-substeps=24"] and mesh.reference.run is by_name["iliacus-split_muscles=1-substeps=24"]
    assert mesh.nearly is by_name["iliacus-split_muscles=1-substeps=12"]
    assert [one.factor for one in bones.settings] == [1, 2, 4] and bones.reference.run is by_name["iliacus-smooth_bones=2"]


def test_figures_of_two_runs_differ_by_what_they_differ_in(tmp_path):
    ours, theirs = moved(tmp_path / "a", 3.0), moved(tmp_path / "b", 1.0)
    theirs.record["muscle"] = {"rest_volume_m3": 2e-4}
    for run, volume_m3, depth_m in ((ours, 2.02e-4, 0.004), (theirs, 2e-4, 0.001)):
        run.frames["volume_m3"] = [2e-4] * (len(run.frames) - 1) + [volume_m3]
        run.frames["surface_depth_m"] = [0.0] * (len(run.frames) - 1) + [depth_m]
        angles = np.linspace(0, 90, 10)
        run.fibres = pd.DataFrame({"muscle": "iliacus", "frame": range(10), "angle_deg": angles, "mean_length_m": 0.1, "mean_moment_arm_m": 10 * depth_m})
        run.forces = pd.DataFrame({"source": ["joint", "bone"], "frame": 1, "other": "femur", "muscle": "iliacus", "torque_n_m": [depth_m, np.nan],
                                   "force_x_n": 1.0, "force_y_n": 0.0, "force_z_n": 0.0, "peak_pressure_pa": [np.nan, 1e6 * depth_m]})
    found = sources.differences(ours, theirs)
    assert found == pytest.approx({"shape_mm": 2.0, "arm_mm": 30.0, "volume_percent": 1.0, "surface_mm": 3.0, "torque_percent": 300.0,
                                   "pressure_percent": 300.0})


def test_multiples_double_up_to_the_finest():
    assert budget.doubled((0.5, 1.0, 2.0, 4.0, 8.0), 8) == (0.5, 1.0, 2.0, 4.0, 8.0)
    assert budget.doubled((0.5, 1.0, 2.0, 4.0), 20) == (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
    assert budget.doubled((2.0, 4.0), 3) == (2.0,)


def test_bars_show_the_floor_and_what_is_below_it(tmp_path, monkeypatch):
    rows = pd.DataFrame({"scene": ["a"] * 3 + ["b"] * 2, "source": ["time step", "iterations", "rounding", "collision, sdf", "rounding"],
                         "setting": ["20 substeps", "1 iteration", "3 starts", "sdf", "3 starts"], "shape_mm": [3.2, 0.004, 0.02, 0.5, 0.1],
                         "left_mm": [1.0, np.nan, np.nan, np.nan, np.nan], "status": ["ok", "ok", np.nan, "suspect", np.nan]})
    kept: dict = {}
    keep_figures(monkeypatch, kept)
    draw_budget(rows, tmp_path / "budget")
    figure, paths = kept["budget"]
    check_print(figure, paths)
    assert collisions(figure) == []
    first, second = figure.axes
    assert [text.get_text() for text in first.get_yticklabels()] == ["time step: 20 substeps", "rounding: 3 starts", "iterations: 1 iteration"]
    assert [text.get_text() for text in second.get_yticklabels()] == ["collision, sdf (suspect)", "rounding: 3 starts"]
    assert [bar.get_width() for bar in first.containers[0]] == [3.2, 0.02, 0.004]
    assert len({bar.get_facecolor() for bar in first.containers[0]}) == 2
    assert draw_budget(rows.iloc[:0], tmp_path / "none") == []


OFF_MM = {"substeps=1": 8.0, "substeps=3": 4.0, "substeps=6": 2.0, "substeps=12": 1.0, "substeps=24": 0.5, "collision-sdf": 4.3,
          "collision-voxel": 24.0, "collision-null": 4.0}
MS = {"substeps=1": 1.0, "substeps=3": 2.0, "substeps=6": 4.0, "substeps=12": 8.0, "substeps=24": 16.0, "collision-sdf": 1.0,
      "collision-voxel": 0.4, "collision-null": 0.1}


def choices_with(tmp_path, off_mm=None, name="lhdl/iliacus", **status):
    """Shapes off by 12 mm over the substeps; a field that is 0.3 mm off in half of the time, voxels that are 20 mm off, and the
    control, which is off by nothing here."""
    looks.know(fake_registry.registry())
    scene, runs, off_mm = fake_registry.scene(name), {}, OFF_MM | (off_mm or {})
    for case in swept("budget", scene):
        told = case.name.partition("-")[2]
        if told in off_mm:
            runs[case] = moved(tmp_path / case.name, off_mm[told], 1e6 * MS[told], case.configuration.backend, status.get(told.partition("-")[2], "ok"))
            runs[case].record["state_hash"] = case.name
    return scene, choice.choices_of(budget_report.budget_of(runs), runs, fake_registry.registry())


def pattern_of(scene):
    return next(case.group for case in swept("budget", scene) if case.group.name == "collision")


def test_the_fastest_that_is_expected_to_hold_comes_first(tmp_path):
    _, found = choices_with(tmp_path)
    assert found.steps.left_mm() == pytest.approx(0.5) and found.error_mm(found.budget.own) == pytest.approx(4.0)
    assert [one.words for one in found.within(2.2)][0] == "6 substeps with the exact backend", "with the field 2.3 mm are expected"
    first = found.within(2.4)[0]
    assert (first.words, first.run) == ("6 substeps with sdf", None)
    assert (first.expected_mm, first.expected_ms) == pytest.approx((2.3, 2.0))
    assert found.within(0.4) == [] and not any("null" in one.words for one in found.within(100))


def test_what_was_run_is_not_guessed(tmp_path):
    """The field with the scene's own loop is 3.8 mm off, though 0.2 mm from the exact run."""
    _, found = choices_with(tmp_path, {"collision-sdf": 3.8})
    first = found.within(3.9)[0]
    assert first.words == "3 substeps with sdf" and first.run is not None and first.expected_mm == pytest.approx(3.8)


def test_the_same_said_twice_is_one_candidate(tmp_path):
    _, found = choices_with(tmp_path)
    for run in found.backends.values():
        run.record["state_hash"] = "same"
    faster = moved(tmp_path / "faster", 4.3, 5e5, "sdf")
    faster.record["state_hash"] = "same"
    twice = replace(found, backends=found.backends | {replace(case, stride=2): faster for case in found.backends if case.configuration.backend == "sdf"})
    ours, theirs = twice.within(100), found.within(100)
    assert sorted(one.words for one in ours) == sorted(one.words for one in theirs)
    assert min(one.expected_ms for one in ours if "sdf" in one.words) < min(one.expected_ms for one in theirs if "sdf" in one.words)


def held(tmp_path, off_mm, bound_mm=2.4, status="ok", scenes=("lhdl/iliacus",)):
    """Sentences and the groups that were run, where every run with a chosen backend is so far off; None: it fails."""
    found, asked = dict(choices_with(tmp_path, name=name) for name in scenes), []

    def run_all(wanted):
        asked.extend(wanted.items())
        return {scene: moved(tmp_path / f"run{len(asked)}-{scene.key}", off_mm, 2e6, "sdf", status) for scene in wanted if off_mm is not None}

    tried = choice.hold(found, bound_mm, pattern_of(next(iter(found))), run_all)
    return [choice.in_words(found[scene], bound_mm, some) for scene, some in tried.items()], asked


def test_what_is_told_to_hold_was_run(tmp_path):
    (text,), ((_, group),) = held(tmp_path, 2.1)
    assert text.startswith("lhdl/iliacus: 2.4 mm: 6 substeps with sdf. Its run is 1.6 mm from 24 substeps, and 24 substeps themselves may be off by "
                           "0.5 mm. It takes about 1 times")
    assert (group.backends, group.times_substeps, group.times_iterations) == (("sdf",), (2.0,), (1.0,))


@pytest.mark.parametrize(("off_mm", "status", "told"), [
    (2.6, "ok", "its run is 2.6 mm off"), (2.1, "suspect", "the run ended suspect"), (2.1, "diverged", "the run ended diverged"),
    (None, "ok", "the run failed")])
def test_what_does_not_hold_is_told_beside_what_does(tmp_path, off_mm, status, told):
    """The exact backend with 6 substeps was run already."""
    (text,), asked = held(tmp_path, off_mm, status=status)
    assert text.startswith("lhdl/iliacus: 2.4 mm: 6 substeps with the exact backend. Its run is 1.5 mm from 24 substeps")
    assert f"Of 6 substeps with sdf 2.3 mm were expected, and {told}" in text and asked


def test_tries_that_fail_end_with_what_was_run_already(tmp_path):
    """Many fields are expected to hold, and none does."""
    scene, found = choices_with(tmp_path)
    backends = {replace(case, stride=1 + number): moved(tmp_path / f"field{number}", 4.1, 1e5 * (1 + number), "sdf")
                for case in found.backends if case.configuration.backend == "sdf" for number in range(9)}
    for number, run in enumerate(backends.values()):
        run.record["state_hash"] = str(number)
    many = replace(found, backends=backends)
    tried = choice.hold({scene: many}, 2.4, pattern_of(scene), lambda wanted: {of: moved(tmp_path / f"t{len(list(tmp_path.iterdir()))}", 9.0) for of in wanted})
    assert len(tried[scene]) == choice.MOST_ROUNDS + 1
    text = choice.in_words(many, 2.4, tried[scene])
    assert "2.4 mm: 6 substeps with the exact backend. Its run is 1.5 mm" in text and "faster ones that should hold were not run" in text


def test_bounds_that_nothing_can_hold(tmp_path):
    (text,), asked = held(tmp_path, 0.1, bound_mm=0.4)
    assert "nothing that was run holds 0.4 mm; the smallest error is 0.5 mm" in text and not asked
    _, found = choices_with(tmp_path / "floor")
    quiet = replace(found, budget=replace(found.budget, floors=[{"shape_mm": 3.0}]))
    scene = fake_registry.scene("lhdl/iliacus")
    assert choice.hold({scene: quiet}, 2.4, pattern_of(scene), lambda wanted: {}) == {scene: []}, "nothing is run for it"
    assert "rounding alone moves the shape by 3 mm" in choice.in_words(quiet, 2.4, [])


def test_frames_that_are_all_warm_up_have_no_time(tmp_path):
    scene, found = choices_with(tmp_path)
    for run in [*found.loops.values(), *found.backends.values()]:
        run.frames["warm_up"] = 1
    tried = choice.hold({scene: found}, 4.2, pattern_of(scene), lambda wanted: {})
    assert "The times are not known" in choice.in_words(found, 4.2, tried[scene])


def test_a_finest_run_that_is_suspect_is_called_so(tmp_path):
    _, found = choices_with(tmp_path)
    found.steps.reference.run.record["status"] = "suspect"
    assert "24 substeps (suspect) themselves may be off" in choice.in_words(found, 2.2, [])


def test_where_refining_has_not_settled_it_is_said(tmp_path):
    _, found = choices_with(tmp_path, {"substeps=3": 10.0, "substeps=6": 8.71, "substeps=12": 7.58, "substeps=24": 6.6})
    assert "or more, since refining has not settled" in choice.in_words(found, 1.0, [])


@pytest.mark.long
def test_chosen_cases_are_run_by_name_and_judged_by_scene(study, tmp_path, monkeypatch):
    """Each scene asks for another number of substeps, with a field that nobody ran yet."""
    def within(self, bound_mm):
        loop = choice.Loop(2.0 if "iliacus" in self.budget.scene else 1.0)
        case = next(iter(self.backends))
        return [choice.Candidate(loop, "some", case.configuration, 0.5, 1.0)]

    monkeypatch.setattr(choice.Choices, "within", within)
    code, text, errors, called = study("--error-mm", "1", "--muscle", "gluteus_medius")
    assert code == 0, errors
    assert [name for name in called if "-chosen-" in name] == [
        "gluteus_medius-chosen-sdf-substeps=x1,iterations=x1", "iliacus-chosen-sdf-substeps=x2,iterations=x1"]
    assert text.count(" 1 mm, as far as can be told: some with sdf") == 2 and any("resolution-sdf" in name for name in called)
    assert (tmp_path / "out" / "tables" / "budget.txt").read_text().count(" 1 mm, as far as can be told: some with sdf") == 2
    code, text, errors, called = study("--error-mm", "1")
    assert code == 0 and called == [] and text.count(" 1 mm, as far as can be told: some with sdf") == 1, errors
    assert study("--error-mm", "-1")[2].count("\n") == 1
