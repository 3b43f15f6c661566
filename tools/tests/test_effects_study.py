"""The study of effects runs as the others do, asks for each set of effects once, and its tables say what the runs say."""

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import effects
import fake_registry
import fake_runs
import fake_study
from fake_sweep import expansion, one_of, swept
from musclebench.cases.case import Folders
from musclebench.effects.effect_report import measured_sets, write_report
from musclebench.effects.effect_sets import ALL, KEPT, LOADS, OWN, EffectSet, effect_sets
from musclebench.effects.effect_tables import ARM_MM, cost_table, price_table
from musclebench.effects.guards import guard_table
from musclebench.effects import returns
from musclebench.effects.returns import own_stretch, return_table
from musclebench.experiments.swept_case import AxisValue
from musclebench.figures import effect_figures, style
from musclebench.results.ply import PlyMesh
from printed import check_print, keep_figures

PROGRAM = Path(__file__).resolve().parent / "fake_musclebench.py"
KNOWN = ("gravity", "damping", "attachment", "edge_length", "activation", "fibre_force", "volume", "local_volume", "bending", "margin")
STANDARD = ("damping", "attachment", "edge_length", "volume", "bending")


@pytest.fixture
def study(tmp_path, monkeypatch, capfd):
    log = tmp_path / "log"
    listed = fake_registry.listed()  # each small scene is a process
    small = [scene["name"] for scene in listed["scenes"] if scene["name"].startswith("effects/")]
    listed["scenes"] = [scene for scene in listed["scenes"] if scene["name"] not in small[2:]]
    (tmp_path / "registry.json").write_text(json.dumps(listed))
    monkeypatch.setenv("FAKE_REGISTRY", str(tmp_path / "registry.json"))

    def run(*more):
        monkeypatch.setenv("FAKE_LOG", str(log))
        log.write_text("")
        code = effects.main(["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--muscle", "iliacus",
                             "--frames-limit", "12", *more])
        return code, *capfd.readouterr(), sorted(line.split()[0] for line in log.read_text().splitlines())

    return run


def test_sets_are_the_own_all_each_left_out_and_each_added():
    sets = {one.name: one for one in effect_sets(STANDARD, KNOWN)}
    every = {"damping", "attachment", "edge_length", "volume", "local_volume", "bending", "margin"}
    assert set(sets[OWN].effects) == set(STANDARD) and set(sets[ALL].effects) == every
    assert {one.left_out for one in sets.values()} - {""} == every - set(KEPT)
    assert {one.added for one in sets.values()} - {""} == {"gravity", "activation", "fibre_force", "local_volume", "margin"}
    assert {name for name, one in sets.items() if one.is_loaded} == {f"own+{load}" for load in LOADS}
    assert set(sets["all-volume"].effects) == every - {"volume"}
    assert all(list(one.effects) == [name for name in KNOWN if name in one.effects] for one in sets.values())


def test_a_load_that_the_scene_has_is_among_all():
    sets = {one.name: one for one in effect_sets((*STANDARD, "gravity"), KNOWN)}
    assert "gravity" in sets[ALL].effects and "all-gravity" in sets and "own+gravity" not in sets


def test_a_set_is_told_to_the_program_as_a_difference():
    assert EffectSet("x", ("damping", "margin")).options(("damping", "bending")) == \
        ["--effect", "margin", "--no-effect", "bending"]
    assert EffectSet(OWN, STANDARD).options(STANDARD) == []


@pytest.mark.long
def test_complete_runs_are_kept_and_every_set_has_a_row(study, tmp_path):
    code, text, errors, called = study("--quick")
    assert code == 0, errors
    every = swept("effects", fake_registry.scene("synthetic/iliacus", 12))
    cases = [case.name for case in every if "-all-" not in case.name or case.name.endswith("-all-r0")]
    assert {name for name in called if name.startswith("iliacus-")} == {name for name in cases if name.startswith("iliacus-")}
    sets = [name for name in cases if name.startswith("iliacus-") and "-guard=" not in name]
    assert [name for name in called if name.startswith("shown-")] == ["shown-activation", "shown-attachment"]
    rows = (tmp_path / "out" / "tables" / "effect_changes.csv").read_text().splitlines()
    assert len(rows) == len(sets)
    assert "own+margin" in text and "effect_scenes.png" in text
    for figure in ("effect_costs", "effect_changes", "effect_scenes"):
        assert (tmp_path / "out" / "figures" / f"{figure}.pdf").is_file()
    assert study("--quick")[3] == []
    assert {name.split("-r")[-1] for name in study("--quick", "--repetitions", "2")[3]} == {"1"}


def test_a_muscle_that_moved_has_not_come_back(tmp_path):
    scene = fake_registry.scene("synthetic/iliacus", 12)
    case, ball = one_of("effects", scene, "-returns"), fake_runs.sphere((0, 0, 0), 0.05)
    assert case.rest_frames == 167 and case.snapshot_frames == [0, 6, 12, 179]  # half a second of frames of 3 ms
    attached = (np.abs(ball.vertices_m[:, 2]) > 0.049).astype("u1")
    apart = ball.vertices_m + np.where(ball.vertices_m[:, 2:] > 0, [0, 0, 0.05], [0, 0, 0])
    moved = ball.vertices_m + [0.003, 0, 0.004]
    shots = [fake_runs.Snapshot(frame, 0.0, shape, 0 * shape[:, 0], attached)
             for frame, shape in ((0, ball.vertices_m), (6, apart), (12, moved), (179, moved))]
    folder = fake_runs.write_run(tmp_path / "run", scene.name, "bvh", 179, triangles=ball.triangles, snapshots=shots)
    fake_runs.add_fibres(folder, "iliacus", stretches=np.linspace(1, 1.25, 180))
    row = return_table({case: folder}).rows.iloc[0]
    assert row.fibre_stretch == 1.25
    assert row.rms_mm == pytest.approx(5, abs=1e-3) and row.largest_mm == pytest.approx(5, abs=1e-3)
    assert row.own_stretch == pytest.approx(1.5, abs=0.01)
    assert np.isnan(own_stretch(*(PlyMesh(shape, ball.triangles, {"attached": 0 * attached})
                                  for shape in (ball.vertices_m, apart))))


def test_a_guard_is_told_by_what_it_keeps(tmp_path):
    whole = expansion("effects", fake_registry.scene("synthetic/iliacus", 12))
    cases = [case for case in whole.firsts() if case.group.name == "guards"]
    assert [(case.frames, case.at("rule").value) for case in cases] == [
        (frames, rule) for frames in (6, 24) for rule in ("none", "angle", "crossing")]
    assert "--effect" not in cases[0].arguments(Folders(tmp_path))
    assert "tunnelling_guard:rule=angle" in cases[1].arguments(Folders(tmp_path))
    folders = {}
    for case, tunnelled in zip(cases, (200, 50, 0, 0, 0, 3)):
        folders[case] = fake_runs.write_run(tmp_path / case.name, case.scene.name, "bvh", case.frames)
        told = folders[case] / "run.json"
        told.write_text(json.dumps(json.loads(told.read_text()) | {"outcome": {"tunnelled_nodes": tunnelled}}))
    few, many = guard_table(folders).rows.to_dict("records")
    assert (few["without"], few["angle_recall"], few["crossing_recall"]) == (200, 75, 100)
    assert np.isnan(many["angle_recall"]) and many["crossing"] == 3


def test_the_small_scenes_are_those_of_the_program():
    shown = [case for case in swept("effects", fake_registry.scene("synthetic/iliacus")) if case.name.startswith("shown-")]
    assert len(shown) > 10 and all(case.scene.name.startswith("effects/") for case in shown)
    assert not any("--preset" in case.arguments(Folders(Path("out"))) for case in shown)  # as they are


@pytest.mark.parametrize("arguments, words", [
    (["--backend", "box2d"], "--backend box2d: not built"), (["--muscle", "biceps"], "'biceps'"),
    (["--jobs", "0"], "--jobs 0"), (["--repetitions", "0"], "--repetitions 0"),
])
def test_bad_input_is_one_line(study, arguments, words):
    code, _, errors, called = study(*arguments)
    assert code == 2 and errors.count("\n") == 1 and words in errors and called == []


def test_the_shell_wrapper_answers_for_help_without_building():
    done = subprocess.run([str(Path(effects.__file__).with_suffix("")), "--help"], capture_output=True, text=True,
                          timeout=60, check=False)
    assert done.returncode == 0 and "usage: tools/effects [" in done.stdout


GOOD = {"max_depth_m": 0.0, "max_surface_depth_m": 5e-5, "max_volume_error": 0.001, "tunnelled_nodes": 0,
        "self_intersecting_triangles": 3, "self_intersecting_triangles_at_rest": 3, "p99_edge_stretch": 1.1}


@pytest.fixture
def measured(tmp_path):
    """Sets by name; each has outcomes of its own and frames of so many ms."""
    def made(runs: dict[str, tuple[float, dict]]):
        scene = fake_registry.scene("synthetic/iliacus", 12)
        sets = {one.name: one for one in effect_sets(STANDARD, KNOWN)}
        ball, folders = fake_runs.sphere((0, 0, 0), 0.05), {}
        for name, (ms, outcome) in runs.items():
            shifted = ball.vertices_m + [0, 0, 0.001 * ms]
            shot = fake_runs.Snapshot(6, 90.0, shifted, 0 * shifted[:, 0], 0 * shifted[:, 0])
            folder = fake_runs.write_run(tmp_path / name, scene.name, "bvh", triangles=ball.triangles, snapshots=[shot])
            record = json.loads((folder / "run.json").read_text()) | {"outcome": GOOD | outcome}
            (folder / "run.json").write_text(json.dumps(record))
            lines = (folder / "frames.csv").read_text().splitlines()
            column = lines[0].split(",").index("frame_ns")
            rows = [line.split(",") for line in lines[1:]]
            lines[1:] = [",".join([*row[:column], str(int(ms * 1e6)), *row[column + 1:]]) for row in rows]
            (folder / "frames.csv").write_text("\n".join(lines) + "\n")
            of_set = AxisValue("effects", name, (), sets[name])
            folders[replace(one_of("effects", scene, "-own-r0"), point=(of_set,))] = folder
        return folders

    return made


def prices_of(folders) -> dict:
    rows = price_table(measured_sets(folders)).rows
    return {row["wanted"]: row for _, row in rows.iterrows()}


def test_the_cheapest_set_that_holds_a_property_is_found(measured):
    deep, folded = {"max_surface_depth_m": 2e-3}, {"self_intersecting_triangles": 9}
    prices = prices_of(measured({
        OWN: (10, deep | folded), ALL: (40, {}), "own+margin": (12, folded), "own+local_volume": (15, deep),
        "own+gravity": (1, {}), "all-margin": (38, deep), "all-local_volume": (39, folded), "all-volume": (39, {})}))
    depth = prices["no surface depth over 0.1 mm"]
    assert (depth["cheapest"], depth["time_ms"], depth["ratio"], depth["needs"]) == ("own+margin", 12, 1.2, "margin")
    assert prices["no fold"]["cheapest"] == "own+local_volume" and prices["no fold"]["needs"] == "local_volume"
    assert prices["volume within 1 %"]["cheapest"] == OWN and prices["volume within 1 %"]["needs"] == "none alone"
    both = prices["all of these"]
    assert both["cheapest"] == "all-volume" and both["needs"] == "margin, local_volume"


def test_an_effect_to_spare_makes_no_set_cheaper(measured):
    """On a busy machine a run with one more may seem faster."""
    prices = prices_of(measured({OWN: (15, {}), ALL: (40, {}), "own+margin": (10, {})}))
    assert prices["volume within 1 %"]["cheapest"] == OWN


def test_effects_that_move_the_moment_arm_are_needed_for_it(measured):
    folders = measured({OWN: (10, {}), ALL: (40, {}), "own+margin": (12, {}), "all-margin": (38, {}), "all-volume": (39, {})})
    words = f"moment arm within {ARM_MM:g} mm of that with all"
    assert words not in prices_of(folders)  # no fibres were followed
    for case, folder in folders.items():
        fake_study.write_fibres(folder / "fibres.csv", case.scene.name, 0.2 if "margin" in case.at("effects").meaning.effects else 3.0)
    row = prices_of(folders)[words]
    assert row["cheapest"] == "own+margin" and row["needs"] == "margin"


def test_what_no_set_holds_says_how_near_the_best_comes(measured):
    prices = prices_of(measured({OWN: (10, {"max_volume_error": 0.2}), ALL: (20, {"max_volume_error": 0.03})}))
    row = prices["volume within 1 %"]
    assert row["cheapest"] == "none" and row["note"] == "the best found: all with volume 3"
    assert row["needs"] == ""


def test_costs_are_columns_and_differences(measured):
    rows = cost_table(measured_sets(measured({
        OWN: (10, {}), ALL: (40, {}), "all-bending": (33, {}), "own+margin": (12, {})}))).rows.set_index("effect")
    assert rows.loc["bending", "own_ms"] == pytest.approx(0.4) and rows.loc["bending", "share_percent"] == pytest.approx(1)
    assert rows.loc["bending", "saved_ms"] == pytest.approx(7) and rows.loc["margin", "added_ms"] == pytest.approx(2)
    assert rows.loc["margin", ["own_ms", "saved_ms"]].isna().all()  # fake runs have no such column


@pytest.mark.long
def test_shapes_are_compared_with_that_of_all_effects(measured, tmp_path):
    tables, _ = write_report(measured({OWN: (10, {}), ALL: (12, {})}), {}, {}, {}, {}, tmp_path / "out")
    changes = next(table for table in tables if table.name == "effect_changes").rows.set_index("set")
    assert changes.loc[OWN, "shape_mm"] == pytest.approx(2) and changes.loc[ALL, "shape_mm"] == 0


@pytest.mark.long
def test_figures_fit_the_page(measured, tmp_path, monkeypatch):
    kept = {}
    keep_figures(monkeypatch, kept)
    sets = measured_sets(measured({OWN: (10, {}), ALL: (40, {}), "own+margin": (12, {}), "all-local_volume": (30, {})}))
    effect_figures.draw_costs(sets, tmp_path / "effect_costs", {"margin": "#F0E442"})
    effect_figures.draw_changes(sets, tmp_path / "effect_changes")
    for figure, paths in kept.values():
        check_print(figure, paths)
        style.plt.close(figure)


def test_the_largest_distance_to_rest_is_that_of_the_farthest_node():
    triangles, none = np.array([[0, 1, 2]]), {}
    rest, moved = PlyMesh(np.zeros((3, 3)), triangles, none), PlyMesh(np.array([[0, 0, 0.001], [0, 0.003, 0.004], [0, 0, 0]]), triangles, none)
    assert returns._largest_mm(moved, rest) == pytest.approx(5)
