"""The shapes that a run kept."""

from dataclasses import dataclass

import numpy as np

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

    @property
    def depth_mm(self) -> np.ndarray:
        if "depth_m" not in self.mesh.extra:
            raise ResultProblem(f"frame {self.frame}: its shape has no depths, the run was not judged; run it without --no-referee")
        return 1e3 * self.mesh.extra["depth_m"]


def read_snapshots(run: Run, entries: list[dict] | None = None) -> list[Snapshot]:
    """By frame; those with positions that are not numbers are left out. `entries`: of the record's snapshots those that are
    wanted, all by default."""
    snapshots = []
    for entry in run.record.get("snapshots", []) if entries is None else entries:
        poses = [(np.reshape(p["rotation"], (3, 3)), np.array(p["translation_m"])) for p in entry["bone_poses"]]
        mesh = read_ply(run.folder / entry["file"])
        if "attached" not in mesh.extra:
            raise ResultProblem(f"{run.folder / entry['file']}: lacks attached; run the case again")
        if np.isfinite(mesh.vertices_m).all():
            snapshots.append(Snapshot(entry["frame"], entry["angle_deg"], mesh, poses, entry.get("surface_depth_complete", True)))
    return sorted(snapshots, key=lambda snapshot: snapshot.frame)


def read_bones(run: Run) -> dict[str, PlyMesh]:
    """{name: mesh in the rest pose}, in the order of the poses."""
    return {bone["name"]: read_ply(run.folder / "meshes" / f"{bone['name']}.ply") for bone in run.record["bones"]}
