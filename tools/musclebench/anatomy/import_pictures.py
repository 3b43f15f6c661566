"""A picture of each imported muscle on its bones, from two sides, with the nodes that are attached. Needs a display."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from ..pictures.rendering import Scene3d
from ..pictures.views import views_along_shorter_axes
from ..results.ply import PlyMesh, read_ply
from .scene_files import AREAS_FILE

WIDTH, HEIGHT, CAPTION = 560, 900, 44
MUSCLE, ORIGIN, INSERTION = (178, 76, 63), (0, 114, 178), (0, 158, 115)
MARGIN = 1.1
DOT_M = 0.0009


def draw_import(folder: Path, say: Callable[[str], None]) -> list[Path]:
    """`folder`: as tools/import makes it."""
    about = json.loads((folder / "import.json").read_text(encoding="utf-8"))
    areas = json.loads((folder / AREAS_FILE).read_text(encoding="utf-8"))["attachments"]
    meshes = {one["name"]: read_ply(folder / "meshes" / f"{one['name']}.ply") for one in about["meshes"]}
    bones = [one["name"] for one in about["meshes"] if one["kind"] == "bone"]
    scene = Scene3d(WIDTH, HEIGHT)
    for name in bones:
        scene.set_bone(name, meshes[name].vertices_m, meshes[name].triangles)
    (folder / "pictures").mkdir(exist_ok=True)
    files = []
    for name in dict.fromkeys(area["muscle"] for area in areas):
        say(name)
        own = [area for area in areas if area["muscle"] == name]
        views = views_along_shorter_axes(meshes[name].vertices_m, MARGIN)
        image = Image.new("RGB", (WIDTH * len(views), HEIGHT + CAPTION), "white")
        _put(scene, meshes[name], own)
        for index, view in enumerate(views):
            image.paste(Image.fromarray(scene.picture(view)), (index * WIDTH, 0))
        scene.clear_muscle()
        draw = ImageDraw.Draw(image)
        draw.text((8, HEIGHT + 4), f"{name.replace('_', ' ')}: blue dots are the origin, green dots the insertion", fill="black")
        draw.text((8, HEIGHT + 22), f"{about['title']}. {about['licence']}{', not for commercial use' if about['non_commercial'] else ''}", fill="black")
        files.append(folder / "pictures" / f"{name}.png")
        image.save(files[-1])
    return files


def _put(scene: Scene3d, muscle: PlyMesh, areas: list[dict[str, Any]]) -> None:
    scene.add_muscle(muscle.vertices_m, muscle.triangles, np.tile(MUSCLE, (len(muscle.vertices_m), 1)), 0.75)
    for area in areas:
        points = np.array(area["points_m"]).reshape(-1, 3)
        scene.add_points(points, DOT_M, np.tile(ORIGIN if area["role"] == "origin" else INSERTION, (len(points), 1)))
