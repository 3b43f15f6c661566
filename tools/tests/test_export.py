"""Runs for ParaView, read again with VTK's own reader."""

import xml.etree.ElementTree as xml

import numpy as np
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import fake_page
import fake_runs
import report
from musclebench.export.paraview import export_runs, runs_of
from musclebench.results.run_folder import ResultProblem
from musclebench.results.snapshots import read_snapshots
from program import call, needs_program


def read(path) -> vtk.vtkPolyData:
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return fake_page.write_paper(tmp_path_factory.mktemp("export") / "paper", ("iliacus",))


def test_a_run_is_a_series_of_muscle_and_posed_bones(results, tmp_path):
    backend = fake_runs.backends()[1]
    series, = export_runs(runs_of(results / "raw" / f"iliacus-{backend}"), tmp_path)
    entries = xml.parse(series).getroot().findall("./Collection/DataSet")
    assert len(entries) == 3 * len(fake_page.KEPT)
    assert {entry.get("name") for entry in entries} == {"muscle", "pelvis", "femur"}
    assert [float(entry.get("timestep")) for entry in entries[::3]] == list(fake_page.KEPT)
    files = {(entry.get("name"), int(entry.get("timestep"))): tmp_path / entry.get("file") for entry in entries}
    muscle, shot = read(files["muscle", 6]), fake_page.snapshots()[2]
    assert vtk_to_numpy(muscle.GetPoints().GetData()) == pytest.approx(shot.vertices_m)
    assert (vtk_to_numpy(muscle.GetPolys().GetConnectivityArray()).reshape(-1, 3) == fake_page.MUSCLE.triangles).all()
    assert vtk_to_numpy(muscle.GetPointData().GetArray("depth_m")) == pytest.approx(shot.depth_m)
    assert (vtk_to_numpy(muscle.GetPointData().GetArray("attached")) == shot.attached).all() and shot.attached.any()
    assert vtk_to_numpy(muscle.GetFieldData().GetArray("angle_deg"))[0] == pytest.approx(90)
    rotation, translation_m = shot.poses[1]
    femur = vtk_to_numpy(read(files["femur", 6]).GetPoints().GetData())
    assert femur == pytest.approx(fake_page.BONES["femur"].vertices_m @ rotation.T + translation_m)
    assert not np.allclose(femur, fake_page.BONES["femur"].vertices_m)


def test_the_command_exports_all_runs_and_can_be_repeated(results, tmp_path, capsys):
    for _ in range(2):
        assert report.main([str(results), "--export", "vtk", "--out", str(tmp_path / "vtk")]) == 0
    assert sorted(path.name for path in (tmp_path / "vtk").iterdir() if path.suffix == ".pvd") == sorted(
        f"iliacus-{backend}.pvd" for backend in fake_runs.backends())
    assert not list((tmp_path / "vtk").glob(".*")) and "iliacus" in capsys.readouterr().out


def test_runs_without_shapes_are_one_line(tmp_path, capsys):
    fake_runs.write_run(tmp_path / "raw" / "a", "synthetic/iliacus", fake_runs.backends()[0])
    assert report.main([str(tmp_path), "--export", "vtk"]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "--snapshots" in told and not (tmp_path / "vtk").exists()


@needs_program
def test_what_nobody_judged_has_no_depth(folder):
    for name, words in (("judged", []), ("unjudged", ["--no-referee"])):
        done = call("run", folder / "scene.toml", "--backend", "bvh", "--snapshots", "0,12", "--out", folder / name, *words)
        assert done.returncode == 0, done.stderr
    columns = []
    for name in ("judged", "unjudged"):
        run, = runs_of(folder / name)
        series, = export_runs([run], folder / "vtk")
        first = xml.parse(series).getroot().find("./Collection/DataSet").get("file")
        data = read(folder / "vtk" / first).GetPointData()
        columns.append({data.GetArrayName(i) for i in range(data.GetNumberOfArrays())})
        assert [shape.get("surface_depth_complete") for shape in run.record["snapshots"]] == 2 * [name == "judged" or None]
    assert columns == [{"depth_m", "surface_depth_m", "attached"}, {"attached"}]
    shape = read_snapshots(run)[-1]
    assert np.array_equal(shape.mesh.vertices_m, read_snapshots(runs_of(folder / "judged")[0])[-1].mesh.vertices_m)
    with pytest.raises(ResultProblem, match="not judged"):
        shape.depth_mm.max()


def test_two_runs_of_one_name_are_refused(results, tmp_path, capsys):
    assert report.main([str(results), str(results), "--export", "vtk", "--out", str(tmp_path / "vtk")]) == 2
    assert "two runs are named" in capsys.readouterr().err and not (tmp_path / "vtk").exists()
