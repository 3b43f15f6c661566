"""Pressure over the bones where the motion is farthest, from the exact configuration to the worst. Needs a display."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
from matplotlib import cm, colors

from ..figures import looks, style
from ..figures.paper_figures import caption
from ..figures.style import plt
from ..pictures.rendering import BONE_COLOUR, Scene3d, View
from ..pictures.surface_pictures import DEPTH_COLOURS, PICTURE_PIXELS
from ..program.registry import saved_registry
from ..results.ply import PlyMesh
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones, read_snapshots
from ..results.statistics import percentile
from .aggregates import Aggregate, aggregates_of, exact_aggregate, of_mode
from .cases import read_cases
from .configurations import Configuration
from .force_errors import force_errors

MOST_SHOWN = 6  # configurations of a scene
TOP_PERCENT = 99  # of pressed vertices of the exact run: upper end of the scale
LEAST_SHARE = 1e-3  # of the scale: less is not pressed
MARGIN = 1.2
OTHER_BONES = 0.15  # opacity
Numbers = npt.NDArray[np.float64]


def draw_bone_pressures(out_dir: Path, say: Callable[[str], None]) -> list[Path]:
    """A row a scene. `out_dir`: of an accuracy study whose runs with forces kept their shapes; else nothing is drawn."""
    looks.know(saved_registry(out_dir))
    told = of_mode(aggregates_of(read_cases(out_dir)), "forces")
    errors = {key: error["map_percent"] for key, error in force_errors(told, []).items()}
    rows = {scene: shown for scene in dict.fromkeys(one.scene for one in told)
            if (shown := _chosen(told, errors, scene)) and _shots([_run_of(one) for one in shown])}
    if not rows:
        return []
    style.apply_style()
    columns = max(len(shown) for shown in rows.values())
    width, left, right = style.PAGE_INCHES, 0.25, 0.75
    height = (width - left - right) / columns * len(rows) * 1.25 + 0.75
    figure, panels = plt.subplots(len(rows), columns, figsize=(width, height), squeeze=False)
    figure.subplots_adjust(left=left / width, right=1 - right / width, top=1 - 0.55 / height, bottom=0.3 / height, wspace=0.03, hspace=0.2)
    table, runs = [], []
    for row, (scene, shown) in zip(panels, rows.items()):
        for panel in row:
            panel.set_axis_off()
        say(f"pressure on bones, {style.muscle_label(shown[0].muscle)}")
        pictures, most_pa = _pictures(read_bones(_run_of(shown[0])), _shots([_run_of(one) for one in shown]))
        for panel, one, picture in zip(row, shown, pictures):
            runs.append(_run_of(one))
            off = errors[(scene, one.configuration)]
            panel.imshow(picture, interpolation="antialiased")
            panel.set_title(one.configuration.name, fontsize=7, fontweight="bold", color=looks.colour(one.backend))
            panel.text(0.5, -0.02, f"off by {float(f'{off:.2g}'):g} %" if off > 0 else "exact", ha="center", va="top", fontsize=7, transform=panel.transAxes)
            table.append({"muscle": one.muscle, "configuration": one.configuration.name, "map_percent": off, "scale_pa": most_pa})
        row[0].text(-0.04, 0.5, f"{style.muscle_label(shown[0].muscle)}\n0 to {most_pa:g} Pa", rotation=90, ha="right", va="center",
                    fontsize=7, transform=row[0].transAxes)
    figure.suptitle("Pressure on the bone beneath the muscle, where the motion is farthest", x=0.05 / width,
                    y=1 - 0.05 / height, ha="left", va="top")
    bar = figure.colorbar(cm.ScalarMappable(colors.Normalize(0, 1), DEPTH_COLOURS), extend="max",
                          cax=figure.add_axes((1 - 0.6 / width, 0.25, 0.1 / width, 0.5)))
    bar.set_label("share of the row's scale")
    style.add_note(figure, caption(runs), y=0.0)
    stem = out_dir / "figures" / "bone_pressure"
    pd.DataFrame(table).to_csv(stem.with_suffix(".csv"), index=False)
    return [*style.save_figure(figure, stem), stem.with_suffix(".csv")]


def _chosen(told: list[Aggregate], errors: dict[tuple[str, Configuration], float], scene: str) -> list[Aggregate]:
    """The exact one, then others from near to far, evenly by rank; without those that tell no map or none that differs."""
    exact = exact_aggregate(told, scene)
    known = [one for one in told if one.scene == scene and errors.get((scene, one.configuration), np.nan) > 0 and one.status == "ok"]
    if exact is None or (scene, exact.configuration) not in errors or np.isnan(errors[(scene, exact.configuration)]):
        return []
    known.sort(key=lambda one: errors[(scene, one.configuration)])
    places = np.unique(np.linspace(0, len(known) - 1, min(MOST_SHOWN - 1, len(known))).round().astype(int)) if known else []
    return [exact, *(known[place] for place in places)]


def _run_of(one: Aggregate) -> Run:
    return next(case.run for case in one.ok if len(case.run.forces))


def _pictures(bones: dict[str, PlyMesh], shots: list[Snapshot]) -> tuple[list[npt.NDArray[np.uint8]], float]:
    """Of all alike, and the pressure at the end of their scale, which is that of the first."""
    exact = shots[0]
    bone = max(exact.bone_pressures_pa, key=lambda name: float(exact.bone_pressures_pa[name].sum()))
    pressed_pa = exact.bone_pressures_pa[bone]
    most_pa = float(f"{percentile(pressed_pa[pressed_pa > 0], [TOP_PERCENT])[0]:.2g}")
    view = _view(bones[bone].vertices_m, bones[bone].triangles, pressed_pa, exact.poses[list(bones).index(bone)])
    scene, pictures = Scene3d(PICTURE_PIXELS, PICTURE_PIXELS), []
    for shot in shots:
        for name, surface in bones.items():
            share = shot.bone_pressures_pa[name] / most_pa
            scale = 255 * DEPTH_COLOURS(np.clip(share, 0, 1))[:, :3]
            colours = np.where((share > LEAST_SHARE)[:, None], scale, 255 * np.array(BONE_COLOUR))
            scene.set_bone(name, surface.vertices_m, surface.triangles, colours, 1.0 if name == bone else OTHER_BONES)
        for name, (rotation, translation_m) in zip(bones, shot.poses):
            scene.pose_bone(name, rotation, translation_m)
        pictures.append(scene.picture(view))
    return pictures, most_pa


def _shots(runs: list[Run]) -> list[Snapshot]:
    """Of each run the moment, among those in which the first one presses, that is farthest from rest."""
    kept = [{shot.frame: shot for shot in read_snapshots(run)} for run in runs]
    pressed = [shot for shot in kept[0].values() if any(values.any() for values in shot.bone_pressures_pa.values())
               and all(shot.frame in other for other in kept)]
    rest = min(kept[0].values(), key=lambda shot: shot.frame)
    if not pressed:
        return []
    farthest = max(pressed, key=lambda shot: (abs(shot.angle_deg - rest.angle_deg), shot.frame))
    return [shots[farthest.frame] for shots in kept]


def _view(vertices_m: Numbers, triangles: npt.NDArray[np.int64], pressed_pa: Numbers, pose: tuple[Numbers, Numbers]) -> View:
    """On all that is pressed, against its mean normal."""
    rotation, translation_m = pose
    posed_m = vertices_m @ rotation.T + translation_m
    corners = posed_m[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    eye = (normals * pressed_pa[triangles].mean(axis=1)[:, None]).sum(axis=0)
    eye = eye / np.linalg.norm(eye) if np.linalg.norm(eye) > 0 else np.array([0.0, 0.0, 1.0])
    pressed_m = posed_m[pressed_pa > 0]
    up = np.eye(3)[np.abs(eye).argmin()]
    up = up - eye * (up @ eye)
    up /= np.linalg.norm(up)
    across = np.cross(up, eye)
    focus = (pressed_m.min(axis=0) + pressed_m.max(axis=0)) / 2
    half_m = max(float(np.abs((pressed_m - focus) @ axis).max()) for axis in (across, up))
    return View(focus, eye, up, MARGIN * half_m)
