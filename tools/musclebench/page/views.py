"""Runs in space: bones, and the muscle at every moment that a run kept, with the depth of each node."""

import hashlib
import math
from dataclasses import dataclass, field

import numpy as np

from ..figures import looks
from ..pictures.surface_figures import DEEPEST_SHOWN_MM
from ..pictures.surface_pictures import Snapshot, first_view, read_bones, read_snapshots, sight_cut
from ..results.ply import PlyMesh
from ..results.run_folder import Run
from ..results.statistics import percentile
from .packed import neighbours_order, packed_depths, packed_mesh, packed_shapes, packed_triangles, packed_words

MARGIN, SEEN_PERCENTS = 1.3, [0.5, 99.5]
BUDGET_CHARACTERS = 7_000_000  # of all moments of a page; beyond it every second moment goes
WORDS = (
    "Drag to turn, + and - to come closer (or turn the wheel with Ctrl, or after a click); all runs have one camera. From the "
    "keyboard: arrow keys turn, 0 is the first view, space plays. A click on a node tells its depth in a bone, by the Referee, "
    "and its distance from the nearest bone, by the meshes shown; positions are rounded to 0.03 mm. Bound nodes and those that "
    "are free have no depth."
)


@dataclass(frozen=True)
class Sight:
    """Where the first look comes from: unit vectors, `eye` from the muscle towards it."""

    eye: np.ndarray
    up: np.ndarray
    cut_normal: np.ndarray  # bones are drawn where (x - cut_m) . cut_normal >= 0
    cut_m: np.ndarray | None = None  # through the middle of the muscle unless told


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


def views_of(cases: dict[tuple[str, str], Run], title: str, sight: Sight | None = None) -> Views:
    """`cases`: {(muscle, backend): run}, of which those without snapshots are left out; a scene a muscle. `sight`: by
    default that of Fig. 6, from where the muscle lies on its bones."""
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
                                       {backend: kept for (_, backend), kept in mine.items()}, views.meshes, sight))
        if views.characters <= BUDGET_CHARACTERS or max(map(len, shots.values())) <= 3 * stride:
            return views
        stride *= 2


def _thinned(shots: list[Snapshot], stride: int) -> list[Snapshot]:
    """The one that is turned farthest and the last always stay."""
    farthest = max(range(len(shots)), key=lambda index: abs(shots[index].angle_deg - shots[0].angle_deg))
    kept = {*range(0, len(shots), stride), farthest, len(shots) - 1}
    return [shots[index] for index in sorted(kept)]


def _scene(muscle: str, runs: dict[str, Run], shots: dict[str, list[Snapshot]], meshes: dict,
           sight: Sight | None) -> dict:
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
        **_seen(sight or _usual_sight(runs[first], bones, shots[first]), shapes_m),
        "runs": [_run(backend, runs[backend], kept, order) for backend, kept in same.items()],
    }


def _usual_sight(run: Run, bones: dict[str, PlyMesh], shots: list[Snapshot]) -> Sight:
    view, plane = first_view(run, bones, shots), sight_cut(run, bones, shots)
    return Sight(view.towards_eye, view.up, plane.normal, plane.origin_m)


def _seen(sight: Sight, shapes_m: np.ndarray) -> dict:
    """A camera on nearly all nodes at all moments, and the plane before which bones are cut away."""
    nodes, across = shapes_m.reshape(-1, 3), np.cross(sight.up, sight.eye)
    focus, half_m = nodes.mean(axis=0), []
    for direction in (across, sight.up):
        low, high = percentile(nodes @ direction, SEEN_PERCENTS)
        focus = focus + direction * ((low + high) / 2 - focus @ direction)
        half_m.append(MARGIN * (high - low) / 2)
    cut_m = focus if sight.cut_m is None else sight.cut_m
    return {"camera": {"focus_m": focus.tolist(), "eye": sight.eye.tolist(), "up": sight.up.tolist(),
                       "half_width_m": float(half_m[0]), "half_height_m": float(half_m[1])},
            "cut": {"origin_m": cut_m.tolist(), "normal": sight.cut_normal.tolist()}}


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
