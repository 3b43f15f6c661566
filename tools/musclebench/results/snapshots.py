"""The shapes that a run kept."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from .ply import PlyMesh, read_ply
from .run_folder import ResultProblem, Run


@dataclass
class Snapshot:
    """One frame of a run."""

    frame: int
    angle_deg: float
    mesh: PlyMesh
    poses: list[tuple[np.ndarray, np.ndarray]]  # rotation (3, 3) and translation_m (3,) of each bone
    surface_is_complete: bool = True  # else surface_depth_m may be deeper in places
    bone_pressures_pa: dict[str, np.ndarray] = field(default_factory=dict)  # by bone and vertex; empty without --forces

    @property
    def depth_mm(self) -> np.ndarray:
        if "depth_m" not in self.mesh.extra:
            raise ResultProblem(f"frame {self.frame}: its shape has no depths, the run was not judged; run it without --no-referee")
        return 1e3 * self.mesh.extra["depth_m"]


def read_snapshots(run: Run, entries: list[dict] | None = None) -> list[Snapshot]:
    """By frame; those with positions that are not numbers are left out. `entries`: of the record's snapshots those that are
    wanted, all by default."""
    snapshots = []
    vertices: dict[str, int] = {}
    for entry in run.record.get("snapshots", []) if entries is None else entries:
        poses = [(np.reshape(p["rotation"], (3, 3)), np.array(p["translation_m"])) for p in entry["bone_poses"]]
        mesh = read_ply(run.folder / entry["file"])
        if "attached" not in mesh.extra:
            raise ResultProblem(f"{run.folder / entry['file']}: lacks attached; run the case again")
        if "bone_pressure" in entry and not vertices:
            vertices = {bone: len(surface.vertices_m) for bone, surface in read_bones(run).items()}
        pressures_pa = _bone_pressures_pa(run, entry["bone_pressure"], vertices) if "bone_pressure" in entry else {}
        if np.isfinite(mesh.vertices_m).all():
            snapshots.append(Snapshot(entry["frame"], entry["angle_deg"], mesh, poses, entry.get("surface_depth_complete", True), pressures_pa))
    return sorted(snapshots, key=lambda snapshot: snapshot.frame)


def _bone_pressures_pa(run: Run, file: str, vertices: dict[str, int]) -> dict[str, np.ndarray]:
    rows = pd.read_csv(run.folder / file, dtype={"bone": str})
    pressures_pa = {bone: np.zeros(count) for bone, count in vertices.items()}
    for bone, pressed in rows.groupby("bone"):
        if bone not in pressures_pa or pressed["vertex"].max() >= vertices[bone]:
            raise ResultProblem(f"{run.folder / file}: is not of these bones; run the case again")
        pressures_pa[bone][pressed["vertex"]] = pressed["pressure_pa"]
    return pressures_pa


def read_bones(run: Run) -> dict[str, PlyMesh]:
    """{name: mesh in the rest pose}, in the order of the poses."""
    return {bone["name"]: read_ply(run.folder / "meshes" / f"{bone['name']}.ply") for bone in run.record["bones"]}
