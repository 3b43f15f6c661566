"""Runs in space: bones, and the muscle at every moment that a run kept, with the depth of each node."""

import hashlib
import math
from dataclasses import dataclass, field

import numpy as np

from ..figures import looks
from ..pictures.rendering import View
from ..pictures.surface_figures import DEEPEST_SHOWN_MM
from ..pictures.surface_pictures import Snapshot, first_view, read_bones, read_snapshots, sight_cut
from ..results.ply import PlyMesh
from ..results.run_folder import Run
from ..results.statistics import percentile
from .packed import neighbours_order, packed_depths, packed_mesh, packed_shapes, packed_triangles, packed_words

MARGIN, SEEN_PERCENTS = 1.12, [0.5, 99.5]
BUDGET_CHARACTERS = 7_000_000  # of all moments of a page; beyond it every second moment goes
WORDS = (
    "Drag to turn, + and - to come closer (or turn the wheel with Ctrl, or after a click); all runs have one camera. From the "
    "keyboard: arrow keys turn, 0 is the first view, space plays. A click on a node tells its depth in a bone, by the Referee, "
    "and its distance from the nearest bone, by the meshes shown; positions are rounded to 0.02 mm. Bound nodes and those that "
    "are free have no depth."
)


@dataclass
class Views:
    """All scenes of a folder; meshes that scenes share are kept once."""

    title: str
    words: str
    scenes: list[dict] = field(default_factory=list)
    meshes: dict[str, dict] = field(default_factory=dict)
    name: str = "view"
    kind_of_part: str = "views"

    @property
    def data(self) -> dict:
        """As tools/page/view.js reads it."""
        return {"scenes": self.scenes, "meshes": self.meshes}

    @property
    def characters(self) -> int:
        return sum(len(run[key]) for scene in self.scenes for run in scene["runs"] for key in ("positions", "depths"))


def views_of(cases: dict[tuple[str, str], Run], title: str) -> Views:
    """`cases`: {(muscle, backend): run}, of which those without snapshots are left out; a scene a muscle."""
    shots = {case: read_snapshots(run) for case, run in cases.items() if run.record.get("snapshots")}
    shots = {case: kept for case, kept in shots.items() if kept}
    if not shots:
        return Views(title, WORDS)
    stride = 1
    while True:
        views = Views(title, WORDS)
        for muscle in dict.fromkeys(muscle for muscle, _ in shots):
            mine = {case: _thinned(kept, stride) for case, kept in shots.items() if case[0] == muscle}
            views.scenes.append(_scene(muscle, {backend: cases[muscle, backend] for _, backend in mine},
                                       {backend: kept for (_, backend), kept in mine.items()}, views.meshes))
        if views.characters <= BUDGET_CHARACTERS or max(map(len, shots.values())) <= 3 * stride:
            return views
        stride *= 2


def _thinned(shots: list[Snapshot], stride: int) -> list[Snapshot]:
    """The one that is turned farthest and the last always stay."""
    farthest = max(range(len(shots)), key=lambda index: abs(shots[index].angle_deg - shots[0].angle_deg))
    kept = {*range(0, len(shots), stride), farthest, len(shots) - 1}
    return [shots[index] for index in sorted(kept)]


def _scene(muscle: str, runs: dict[str, Run], shots: dict[str, list[Snapshot]], meshes: dict) -> dict:
    first = next(iter(shots))
    surface, bones = shots[first][0].mesh, read_bones(runs[first])
    same = {backend: kept for backend, kept in shots.items() if np.array_equal(kept[0].mesh.triangles, surface.triangles)}
    order = neighbours_order(len(surface.vertices_m), surface.triangles)
    shapes_m = np.concatenate([np.stack([shot.mesh.vertices_m for shot in kept]) for kept in same.values()])
    return {
        "muscle": muscle, "vertices": len(order), "triangles": len(surface.triangles),
        "corners": packed_triangles(surface.triangles, order), "order": packed_words(np.diff(order, prepend=0), 32),
        "attached": packed_words(surface.extra["attached"][order], 8),
        "bones": [{"name": name, "mesh": _shared(mesh, meshes)} for name, mesh in bones.items()],
        "deepest_mm": _deepest_mm(same),
        "camera": _camera(first_view(runs[first], bones, shots[first]), shapes_m), "cut": _cut(runs[first], bones, shots[first]),
        "runs": [_run(backend, runs[backend], kept, order) for backend, kept in same.items()],
    }


def _camera(view: View, shapes_m: np.ndarray) -> dict:
    """With the half extents that hold nearly all nodes at all moments, across and upwards."""
    seen = shapes_m.reshape(-1, 3) - view.focus_m
    right = np.cross(view.up, view.towards_eye)
    half_m = [MARGIN * float(np.abs(percentile(seen @ direction, SEEN_PERCENTS)).max()) for direction in (right, view.up)]
    return {"focus_m": view.focus_m.tolist(), "eye": view.towards_eye.tolist(), "up": view.up.tolist(),
            "half_width_m": half_m[0], "half_height_m": half_m[1]}


def _cut(run: Run, bones: dict[str, PlyMesh], shots: list[Snapshot]) -> dict:
    """As in Fig. 6: where bones are drawn while they are cut."""
    plane = sight_cut(run, bones, shots)
    return {"origin_m": plane.origin_m.tolist(), "normal": plane.normal.tolist()}


def _run(backend: str, run: Run, shots: list[Snapshot], order: np.ndarray) -> dict:
    shapes = packed_shapes(np.stack([shot.mesh.vertices_m for shot in shots]), order)
    depth_step_m, depths = packed_depths(np.stack([shot.mesh.extra["depth_m"] for shot in shots]), order)
    return {
        "backend": backend, "name": run.folder.name, "status": run.status,
        "frames": [shot.frame for shot in shots], "angles_deg": [round(shot.angle_deg, 4) for shot in shots],
        "poses": [[[*np.round(rotation.ravel(), 9).tolist(), *np.round(translation_m, 9).tolist()]
                   for rotation, translation_m in shot.poses] for shot in shots],
        "step_m": shapes.step_m, "origin_m": shapes.origin_m, "positions": shapes.text,
        "depth_step_m": depth_step_m, "depths": depths,
    }


def _shared(mesh: PlyMesh, meshes: dict) -> str:
    key = hashlib.sha256(mesh.vertices_m.tobytes() + mesh.triangles.tobytes()).hexdigest()[:12]
    if key not in meshes:
        meshes[key] = packed_mesh(mesh)
    return key


def _deepest_mm(shots: dict[str, list[Snapshot]]) -> float:
    """Upper end of the colour scale, by the rule of Fig. 6 over all moments."""
    depths = [shot.depth_mm.max() for backend, kept in shots.items() for shot in kept
              if not looks.backend(backend).is_control]
    return min(math.ceil(max([1.0, *depths])), DEEPEST_SHOWN_MM)
