"""Runs as series that ParaView opens: RUN.pvd names a file a moment for the muscle and for each bone in its pose."""

import os
import shutil
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from ..pictures.rendering import poly_data
from ..program.cli import Problem
from ..results.run_folder import Run, read_all, read_run
from ..results.snapshots import Snapshot, read_bones, read_snapshots

MUSCLE = "muscle"
FORCE = ("force_x_n", "force_y_n", "force_z_n")


def runs_of(folder: Path) -> list[Run]:
    """Of one run's folder or of an experiment's: those that kept their shape. Raises Problem where none did."""
    if (folder / "run.json").is_file():
        runs = [read_run(folder)]
    else:
        runs = read_all(sorted(path.parent for path in (folder / "raw").glob("*/run.json") if not path.parent.name.startswith(".")))
    kept = [run for run in runs if run.record.get("snapshots")]
    if not kept:
        raise Problem(f"{folder}: no run there stored shapes; run one with --snapshots, such as 0,10,20")
    return kept


def export_runs(runs: list[Run], out: Path) -> list[Path]:
    """The .pvd files in `out`, one a run; each run's folder beside it is there whole or as it was. Raises Problem for two
    runs of one name."""
    names = [run.folder.resolve().name for run in runs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise Problem(f"{out}: two runs are named {twice}; export each folder with its own --out")
    out.mkdir(parents=True, exist_ok=True)
    return [_export_run(run, out) for run in runs]


def _export_run(run: Run, out: Path) -> Path:
    """Times are frames. Lengths are in metres, as ParaView takes them."""
    name, part = run.folder.resolve().name, out / f".{run.folder.resolve().name}.{os.getpid()}"
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    bones, entries = read_bones(run), []
    for shot in read_snapshots(run):
        files = {MUSCLE: _muscle(shot)}
        for (bone, mesh), (rotation, translation_m) in zip(bones.items(), shot.poses):
            files[bone] = poly_data(mesh.vertices_m @ rotation.T + translation_m, mesh.triangles)
            if bone in shot.bone_pressures_pa:
                _add_values(files[bone], "pressure_pa", shot.bone_pressures_pa[bone])
        for number, (what, surface) in enumerate(files.items()):
            file = f"{what}_{shot.frame:04d}.vtp"
            _add_number(surface, "angle_deg", shot.angle_deg)
            _write(surface, part / file)
            entries.append(f'    <DataSet timestep="{shot.frame}" part="{number}" name={quoteattr(what)} file={quoteattr(f"{name}/{file}")}/>')
    shutil.rmtree(out / name, ignore_errors=True)
    os.replace(part, out / name)
    series = out / f"{name}.pvd"
    series.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n  <Collection>\n'
                      + "\n".join(entries) + "\n  </Collection>\n</VTKFile>\n")
    return series


def _muscle(shot: Snapshot) -> vtk.vtkPolyData:
    """With attached of each node and, of a judged run, depth_m (> 0 inside a bone; 0 for free and bound nodes) and
    surface_depth_m; of a run with --forces, pressure_pa and the vector contact_force_n."""
    surface = poly_data(shot.mesh.vertices_m, shot.mesh.triangles)
    columns = dict(shot.mesh.extra)
    if set(FORCE) <= set(columns):
        columns["contact_force_n"] = np.column_stack([columns.pop(name) for name in FORCE])
    for name, values in columns.items():
        _add_values(surface, name, values)
    surface.GetPointData().SetActiveScalars("depth_m")
    return surface


def _add_values(surface: vtk.vtkPolyData, name: str, values: npt.NDArray[np.float64]) -> None:
    """A value a vertex."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    surface.GetPointData().AddArray(array)


def _add_number(surface: vtk.vtkPolyData, name: str, value: float) -> None:
    array = numpy_to_vtk(np.array([value]), deep=True)
    array.SetName(name)
    surface.GetFieldData().AddArray(array)


def _write(surface: vtk.vtkPolyData, path: Path) -> None:
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(surface)
    if not writer.Write() or writer.GetErrorCode():
        raise Problem(f"{path}: cannot be written; is the disk full or the folder write-protected?")
