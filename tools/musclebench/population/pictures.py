"""Pictures of runs that did not hold: at rest, and where they were worst, from two sides. Needs a display."""

import textwrap
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ..pictures.rendering import Scene3d
from ..pictures.views import views_along_shorter_axes
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones, read_snapshots
from .report import FRAME

WIDTH, HEIGHT, CAPTION = 420, 620, 62
MUSCLE, DEEP = (178, 76, 63), (255, 214, 0)
DEEP_MM = 0.1  # from here a node in a bone is shown in the other colour
MARGIN, LETTERS = 1.05, 130


def draw_broken(runs: list[Run], folder: Path, say: Callable[[str], None]) -> list[Path]:
    """A picture each, named like its run."""
    files = []
    for run in runs:
        say(run.folder.name)
        shown = _shown(run)
        if not shown:
            continue
        scene = Scene3d(WIDTH, HEIGHT)
        bones = read_bones(run)
        for name, bone in bones.items():
            scene.set_bone(name, bone.vertices_m, bone.triangles)
        views = views_along_shorter_axes(shown[0].mesh.vertices_m, MARGIN)
        image = Image.new("RGB", (WIDTH * len(views) * len(shown), HEIGHT + CAPTION), "white")
        place = 0
        for snapshot in shown:
            for name, (rotation, shift) in zip(bones, snapshot.poses):
                scene.pose_bone(name, rotation, shift)
            depths = snapshot.mesh.extra.get("depth_m", np.zeros(len(snapshot.mesh.vertices_m)))
            colours = np.where((1000 * depths > DEEP_MM)[:, None], DEEP, MUSCLE)
            scene.add_muscle(snapshot.mesh.vertices_m, snapshot.mesh.triangles, colours)
            for view in views:
                image.paste(Image.fromarray(scene.picture(view)), (place * WIDTH, 0))
                place += 1
            scene.clear_muscle()
        _write(ImageDraw.Draw(image), run, shown)
        files.append(folder / f"{run.folder.name}.png")
        image.save(files[-1])
    return files


def _shown(run: Run) -> list[Snapshot]:
    """Rest and the worst moment, which its status names; else rest and end."""
    snapshots = read_snapshots(run)
    told = FRAME.search(str(run.record.get("status_detail", "")))
    worst = [one for one in snapshots if told and one.frame == int(told[1])] or snapshots[-1:]
    return list({one.frame: one for one in [*snapshots[:1], *worst]}.values())


def _write(draw: ImageDraw.ImageDraw, run: Run, shown: list[Snapshot]) -> None:
    moments = ", then ".join(f"frame {one.frame} ({one.angle_deg:.0f} degrees)" for one in shown)
    source = run.record.get("source") or {}
    licence = f" Shapes: {source['licence']}{', not for commercial use' if source.get('non_commercial') else ''}." if source.get("licence") else ""
    words = (f"{run.folder.name}: {run.status}: {run.record.get('status_detail', '')}. From two sides, {moments}; "
             f"yellow: deeper than {DEEP_MM} mm in a bone.{licence}")
    for number, line in enumerate(textwrap.wrap(words, LETTERS * len(shown))[:4]):
        draw.text((8, HEIGHT + 3 + 14 * number), line, fill="black")
