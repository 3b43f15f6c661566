"""One scene in space for the page: bones, and the muscle of each run at the moments that are shown, with the depth of each
node."""

import hashlib
import math
from dataclasses import dataclass

import numpy as np

from ..figures import looks
from ..pictures.surface_figures import DEEPEST_SHOWN_MM
from ..pictures.surface_pictures import first_view, sight_cut
from ..results.ply import PlyMesh
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones
from ..results.statistics import percentile
from .packed import neighbours_order, packed_depths, packed_mesh, packed_shapes, packed_triangles, packed_words

MARGIN, SEEN_PERCENTS = 1.3, [0.5, 99.5]
# What colours may show. Runs of earlier programs kept the depth of nodes only; pressures are of runs with --forces.
DEPTHS = {"node": "depth_m", "surface": "surface_depth_m"}
PRESSURE = {"pressure": "pressure_pa"}
TOP_PRESSURE_PERCENT = 99.5  # of pressed nodes: a few of them stand out


@dataclass(frozen=True)
class Sight:
    """Where the first look comes from: unit vectors, `eye` from the muscle towards it."""

    eye: np.ndarray
    up: np.ndarray
    cut_normal: np.ndarray  # bones are drawn where (x - cut_m) . cut_normal >= 0
    cut_m: np.ndarray | None = None  # through the middle of the muscle unless told


def scene_data(muscle: str, runs: dict[str, Run], shots: dict[str, list[Snapshot]], meshes: dict,
               sight: Sight | None) -> dict:
    """As tools/page/run_data.js reads it. `runs`, `shots`: by backend; bones are added to `meshes`. `sight`: by default that of
    Fig. 6, from where the muscle lies on its bones."""
    first = next(iter(shots))
    surface, bones = shots[first][0].mesh, read_bones(runs[first])
    same = {backend: kept for backend, kept in shots.items() if np.array_equal(kept[0].mesh.triangles, surface.triangles)}
    order = neighbours_order(len(surface.vertices_m), surface.triangles)
    shapes_m = np.concatenate([np.stack([shot.mesh.vertices_m for shot in kept]) for kept in same.values()])
    most_pa = _most_pa(same)
    most_bone_pa = _largest_shown_pa([pa for kept in same.values() for shot in kept for pa in shot.bone_pressures_pa.values()])
    return {
        "muscle": muscle, "vertices": len(order), "triangles": len(surface.triangles),
        "corners": packed_triangles(surface.triangles, order), "order": packed_words(np.diff(order, prepend=0), 32),
        "attached": packed_words(surface.extra["attached"][order], 8),
        "bones": [{"name": name, "mesh": _shared(mesh, meshes)} for name, mesh in bones.items()],
        "deepest_mm": _deepest_mm(same), "most_pa": most_pa, "most_n": _most_n(runs, same),
        "most_bone_pa": most_bone_pa,
        **_seen(sight or _usual_sight(runs[first], bones, shots[first]), shapes_m),
        "runs": [_run(backend, runs[backend], kept, order, most_pa) | {"bone_pressures": _bone_pressures(bones, kept, most_bone_pa)}
                 for backend, kept in same.items()],
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


def _run(backend: str, run: Run, shots: list[Snapshot], order: np.ndarray, most_pa: float) -> dict:
    shapes = packed_shapes(np.stack([shot.mesh.vertices_m for shot in shots]), order)
    return {
        "backend": backend, "name": run.folder.name, "status": run.status,
        "frames": [shot.frame for shot in shots], "angles_deg": [round(shot.angle_deg, 4) for shot in shots],
        "poses": [[[*np.round(rotation.ravel(), 9).tolist(), *np.round(translation_m, 9).tolist()]
                   for rotation, translation_m in shot.poses] for shot in shots],
        "step_m": shapes.step_m, "origin_m": shapes.origin_m, "positions": shapes.text,
        "no_pressure": (run.record.get("forces") or {}).get("contacts_left_out") or "run without --forces",
        "depths": {kind: _depths(column, shots, order, most_pa) for kind, column in (DEPTHS | PRESSURE).items()
                   if column in shots[0].mesh.extra and (kind in PRESSURE or run.record["case"].get("judged", True))},
        "arrows": [_arrows(run, shot.frame) for shot in shots],
        "tells_bones": all(shot.bone_pressures_pa for shot in shots),
        "open_surface_frames": [shot.frame for shot in shots if not shot.surface_is_complete],
    }


def _arrows(run: Run, frame: int) -> list[list[float]]:
    """[where it acts in m, force in N, 1: an attachment's] of what acts on the muscles in a frame."""
    if run.forces.empty:
        return []
    rows = run.forces[(run.forces["frame"] == frame) & (run.forces["source"] != "joint") & (run.forces["force_n"] > 0)]
    return [[*(round(float(row[f"at_{axis}_m"]), 6) for axis in "xyz"), *(float(f"{row[f'force_{axis}_n']:.4g}") for axis in "xyz"),
             int(row["source"] == "attachment")] for _, row in rows.iterrows()]


def _most_n(runs: dict[str, Run], shots: dict[str, list[Snapshot]]) -> float:
    """The force of the longest arrow."""
    return max((float(np.linalg.norm(arrow[3:6])) for backend, kept in shots.items() for shot in kept
                for arrow in _arrows(runs[backend], shot.frame)), default=0.0)


def _bone_pressures(bones: dict[str, PlyMesh], shots: list[Snapshot], most_pa: float) -> list[dict]:
    """Of each bone that muscles press: its number and the pressures on its vertices at each moment."""
    told = []
    for number, (name, mesh) in enumerate(bones.items()):
        pressures_pa = [shot.bone_pressures_pa[name] for shot in shots if name in shot.bone_pressures_pa]
        if len(pressures_pa) < len(shots) or not any(values.any() for values in pressures_pa):
            continue
        step_pa, text = packed_depths(np.minimum(np.stack(pressures_pa), 10 * most_pa), neighbours_order(len(mesh.vertices_m), mesh.triangles))
        told.append({"bone": number, "step_pa": step_pa, "text": text})
    return told


def _most_pa(shots: dict[str, list[Snapshot]]) -> float:
    return _largest_shown_pa([shot.mesh.extra["pressure_pa"] for kept in shots.values() for shot in kept if "pressure_pa" in shot.mesh.extra])


def _largest_shown_pa(pressures: list[np.ndarray]) -> float:
    """Upper end of a colour scale."""
    pressed = np.concatenate(pressures) if pressures else np.zeros(0)
    pressed = pressed[pressed > 0]
    return float(f"{percentile(pressed, [TOP_PRESSURE_PERCENT])[0]:.2g}") if len(pressed) else 0.0


def _depths(column: str, shots: list[Snapshot], order: np.ndarray, most_pa: float) -> dict:
    """Pressures that stand out far are cut off, so that the steps of the others stay fine."""
    values = np.stack([shot.mesh.extra[column] for shot in shots])
    step_m, text = packed_depths(np.minimum(values, 10 * most_pa) if column in PRESSURE.values() else values, order)
    return {"step_m": step_m, "text": text}


def _shared(mesh: PlyMesh, meshes: dict) -> str:
    key = hashlib.sha256(mesh.vertices_m.tobytes() + mesh.triangles.tobytes()).hexdigest()[:12]
    if key not in meshes:
        meshes[key] = packed_mesh(mesh)
    return key


def _deepest_mm(shots: dict[str, list[Snapshot]]) -> float:
    """Upper end of the colour scale, by the rule of Fig. 6 over all moments and both depths."""
    depths = [1e3 * shot.mesh.extra[column].max() for backend, kept in shots.items() for shot in kept
              for column in DEPTHS.values() if column in shot.mesh.extra and not looks.backend(backend).is_control]
    return min(math.ceil(max([1.0, *depths])), DEEPEST_SHOWN_MM)
