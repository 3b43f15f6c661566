"""Forces of a run: the program's table, what the study makes of it, what the page shows."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import fake_runs
from fake_study import SCENES, Truth, write_coupled
from musclebench.accuracy import cases, report
from musclebench.accuracy.aggregates import aggregates_of, of_mode
from musclebench.accuracy.force_errors import force_errors
from musclebench.page.scene_data import _arrows
from musclebench.results.damage import damage
from musclebench.results.force_differences import bone_pressures, force_differences, maps_off_percent
from musclebench.results.run_folder import read_run
from musclebench.results.snapshots import read_snapshots
from musclebench.tables.force_table import force_table
from program import call, needs_program

COLUMNS = ("frame", "muscle", "source", "other", *(f"force_{axis}_n" for axis in "xyz"), "force_n",
           *(f"at_{axis}_m" for axis in "xyz"), "peak_pressure_pa", "torque_n_m")


def add_forces(folder, factor: float, muscle: str = "iliacus") -> None:
    """Of 24 frames: a bone presses with 2 N and 100 Pa and turns with 3 N m, all times the factor."""
    rows = []
    for frame in range(1, 25):
        push = dict(zip(COLUMNS, (frame, muscle, "bone", "femur", 0.0, 0.0, 2 * factor, 2 * factor, 0.01, 0.02, 0.03, 100 * factor, "")))
        joint = dict(zip(COLUMNS, (frame, "", "joint", "femur", 0.0, 0.0, -2 * factor, 2 * factor, 0, 0, 0, "", 3 * factor)))
        rows += [push, joint]
    fake_runs.write_rows(folder / "forces.csv", COLUMNS, rows)


@pytest.fixture
def study(tmp_path):
    raw = tmp_path / "raw"
    for scene in SCENES:
        name = scene.split("/")[-1]
        for mark, backend, truth, factor in (("e", "bvh", Truth(15), 1), ("s", "sdf", Truth(0.3, parameters={"cells": 64}), 1.1),
                                             ("v", "voxel", Truth(0.2), 0.5)):
            write_coupled(raw / f"{name}-{mark}-arms", scene, backend, replace(truth, arm_off_mm=1))
            told = write_coupled(raw / f"{name}-{mark}", scene, backend, truth)
            add_forces(told, factor, name)
            record = json.loads((told / "run.json").read_text())
            record["case"]["forces"] = True
            (told / "run.json").write_text(json.dumps(record))
            if backend != "voxel":
                fake_runs.press_bones(told, {("femur", 3): 300.0, ("femur", 4): 400.0 * factor})
    return tmp_path


def test_errors_are_percent_of_the_exact_runs_forces(study):
    aggregates = aggregates_of(cases.read_cases(study))
    errors = force_errors(of_mode(aggregates, "forces"), of_mode(aggregates, "forces_floor"))
    found = {chosen.name: error for (scene, chosen), error in errors.items() if scene == SCENES[0]}
    assert found["bvh"]["torque_percent"] == 0
    voxel, = (error for name, error in found.items() if name.startswith("voxel"))
    for what in ("torque", "contact", "pressure"):
        assert found["sdf 64"][f"{what}_percent"] == pytest.approx(10), what
        assert voxel[f"{what}_percent"] == pytest.approx(50), what
    assert found["sdf 64"]["map_percent"] == pytest.approx(100 * 40 / 500) and np.isnan(voxel["map_percent"])
    assert np.isnan(voxel["torque_floor_percent"])
    table = force_table(of_mode(aggregates, "arms"), errors)
    assert set(table.rows["configuration"]) == set(found) and len(found) == 3


@pytest.mark.long
def test_the_study_writes_their_table_and_fronts(study):
    files = report.write_report(study).files
    assert {"force_errors.csv", "pareto_torque.png", "pareto_pressure.png", "pareto_map.png"} <= {path.name for path in files}
    assert "percent of the root mean square" in (study / "figures" / "pareto_torque.md").read_text()


def test_a_bone_that_stands_still_has_no_torque_to_be_off(study):
    run, other = (read_run(study / "raw" / f"{SCENES[0].split('/')[-1]}-{name}") for name in ("e", "s"))
    for one in (run, other):
        one.forces.drop(one.forces.index[one.forces["source"] == "joint"], inplace=True)
    found = force_differences(other, run)
    assert np.isnan(found["torque_percent"]) and found["contact_percent"] == pytest.approx(10)
    run.forces.drop(run.forces.index, inplace=True)
    assert force_differences(other, run) == {}


def told_map(folder, pressures_pa: dict) -> pd.DataFrame:
    folder.mkdir()
    (folder / "snapshots").mkdir()
    (folder / "run.json").write_text(json.dumps({"snapshots": [{"frame": 9}]}))
    fake_runs.press_bones(folder, pressures_pa)
    return bone_pressures(SimpleNamespace(folder=folder, record=json.loads((folder / "run.json").read_text())))


def test_maps_are_off_where_only_one_presses(tmp_path):
    exact = told_map(tmp_path / "exact", {("tibia", 3): 300.0, ("tibia", 4): 400.0})
    same = told_map(tmp_path / "same", {("tibia", 4): 400.0, ("tibia", 3): 300.0})
    beside = told_map(tmp_path / "beside", {("tibia", 3): 300.0, ("fibula", 4): 400.0})
    nothing = told_map(tmp_path / "nothing", {})
    assert maps_off_percent(same, exact) == 0
    assert maps_off_percent(beside, exact) == pytest.approx(100 * (2 * 400**2)**0.5 / 500)
    assert maps_off_percent(nothing, exact) == pytest.approx(100)
    assert np.isnan(maps_off_percent(exact, nothing))


def test_arrows_are_of_the_muscle(study):
    run = read_run(study / "raw" / f"{SCENES[0].split('/')[-1]}-s")
    assert _arrows(run, 3) == [[0.01, 0.02, 0.03, 0, 0, pytest.approx(2.2), 0]]
    run.forces["source"] = "attachment"
    assert _arrows(run, 3)[0][-1] == 1


@needs_program
def test_the_program_writes_forces_and_says_what_it_leaves_out(tmp_path):
    out = tmp_path / "out"
    ran = call("run", "hard/loaded_plate", "--backend", "bvh", "--no-referee", "--forces", "--loop", "frames=5", "--snapshots", "0,5",
               "--out", str(out))
    assert ran.returncode == 0 and "bending" in ran.stderr and "cure: a compliance" in ran.stderr
    run = read_run(out)
    assert set(run.forces["source"]) == {"bone"} and run.forces["frame"].tolist() == [1, 2, 3, 4, 5]
    assert run.record["forces"]["contacts_left_out"] == "" and "iterations" in run.record["forces"]["attachments_left_out"]
    assert damage(out) == ""
    lines = (out / "forces.csv").read_text().splitlines(keepends=True)
    (out / "forces.csv").write_text("".join(lines[:-1]))
    assert damage(out) == "forces.csv has 4 of 5 rows"


@needs_program
def test_snapshots_hold_the_pressure_that_adds_up_to_the_force(tmp_path):
    from musclebench.export.paraview import export_runs
    from musclebench.results.ply import read_ply
    out = tmp_path / "out"
    assert call("run", "hard/loaded_plate", "--backend", "bvh", "--no-referee", "--forces", "--snapshots", "0,50", "--out", str(out)).returncode == 0
    told = read_run(out).forces
    mesh = read_ply(out / "snapshots" / "frame_0050.ply")
    assert mesh.extra["force_z_n"].sum() == pytest.approx(told[told["frame"] == 50]["force_z_n"].sum(), rel=1e-9)
    assert mesh.extra["pressure_pa"].max() == pytest.approx(told[told["frame"] == 50]["peak_pressure_pa"].max(), rel=1e-9)
    assert not read_ply(out / "snapshots" / "frame_0000.ply").extra["pressure_pa"].any()
    on_plate = pd.read_csv(out / "snapshots" / "bones_0050.csv")
    assert on_plate["force_z_n"].sum() == pytest.approx(-told[told["frame"] == 50]["force_z_n"].sum(), rel=1e-6)
    assert read_snapshots(read_run(out))[1].bone_pressures_pa["plate"].max() == on_plate["pressure_pa"].max() > 0
    assert pd.read_csv(out / "snapshots" / "bones_0000.csv").empty
    export_runs([read_run(out)], tmp_path / "vtk")
    text = next((tmp_path / "vtk").glob("out/muscle_0050.vtp")).read_bytes()
    assert b'Name="contact_force_n"' in text and b'Name="pressure_pa"' in text and b'Name="force_x_n"' not in text
    assert b'Name="pressure_pa"' in next((tmp_path / "vtk").glob("out/plate_0050.vtp")).read_bytes()


def test_a_table_without_forces_is_empty(tmp_path):
    folder = fake_runs.write_run(tmp_path / "run", "synthetic/iliacus", "bvh", 5)
    assert read_run(folder).forces.equals(pd.DataFrame())
