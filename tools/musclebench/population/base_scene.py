"""The scene whose members a population has: its tables, and its shapes at rest in the scene's frame."""

import json
import os
import subprocess
import tempfile
import tomllib
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..anatomy.surface import Points, Surface
from ..cases.project_scenes import project_scenes
from ..program.cli import Problem
from ..program.registry import read_registry
from ..results.ply import read_ply

READING_SECONDS = 600
PLACING = ("unit", "scale", "rotate_deg", "translate_m")
ONE_STEP = ("start_noise_m=0", "rest_frames=0", "settle_substeps=0", "substeps=1", "iterations=1")
AS_IN_THE_FILE = ("split_muscles=0", "smooth_bones=0")
ENDED = (0, 1, 3)  # exit codes of a run that read its scene

Table = dict[str, Any]


@dataclass
class BaseScene:
    """In metres."""

    name: str
    tables: Table
    bones: dict[str, Surface]
    muscles: dict[str, Surface]
    outlines: list[Points] = field(default_factory=list)  # by attachment
    fibres: dict[str, list[Points]] = field(default_factory=dict)  # by muscle, of landmark files


def listed(tables: Table, key: str) -> list[Table]:
    """A table or a list of tables."""
    found = tables.get(key, [])
    every = found if isinstance(found, list) else [found]
    return [one for one in every if isinstance(one, dict)]


def scene_file(scene: str) -> Path:
    """Of a scene by name, too. Raises Problem."""
    if scene.endswith(".toml"):
        return Path(scene).resolve()
    found = project_scenes().get(scene)
    if found is None:
        raise Problem(f"{scene}: neither a scene of `musclebench list` nor a .toml file")
    return found


def read_base_scene(scene: str, program: Path, data: Path | None) -> BaseScene:
    """Raises Problem."""
    path = scene_file(scene)
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Problem(f"{path}: {error}") from None
    if asks_by_trial(tables):
        raise Problem(f"{scene}: effects = \"auto\": each member would get effects of its own; write those of the scene with `musclebench check "
                      f"{scene} --trial --out FILE.toml`, and name that file")
    data = (data or Path(os.environ["MUSCLEBENCH_DATA"])).resolve() if data or os.environ.get("MUSCLEBENCH_DATA") else None
    with tempfile.TemporaryDirectory() as folder:
        bones, muscles = _shapes(scene, program, data, Path(folder) / "rest")
    if "attachment" in tables and not listed(tables, "attachment"):
        raise Problem(f"{path}: key 'attachment': what touches at first is not the same in every member; write [[attachment]] tables")
    base = BaseScene(Path(scene).stem if scene.endswith(".toml") else scene.replace("/", "-"), tables, bones, muscles)
    _read_landmarks(base, path.parent, data)
    for bone in listed(tables, "bone"):
        for motion in motions_of(bone):
            if "table" in motion:
                motion["table"] = str(_file(motion["table"], path.parent, data))
    return base


def asks_by_trial(tables: Table) -> bool:
    effects = tables.get("effects")
    return effects == "auto" or (isinstance(effects, dict) and effects.get("auto") is True)


def with_backends(tables: Table) -> list[str]:
    """Names of what has a backend of its own, which no setting changes."""
    bodies = [one["name"] for one in listed(tables, "bone") if "backend" in one]
    pairs = [" and ".join(one.get("muscles", [str(one.get("muscle")), str(one.get("bone"))])) for one in listed(tables, "pair") if "backend" in one]
    return bodies + pairs


def motions_of(bone: Table) -> list[Table]:
    return listed(bone, "motion")


def _shapes(scene: str, program: Path, data: Path | None, out: Path) -> tuple[dict[str, Surface], dict[str, Surface]]:
    """As the program has read, placed and welded them: it writes them with the first snapshot."""
    registry = read_registry(program)
    control = registry.control or registry.backends[0]
    command = [str(program), "run", scene, "--backend", control.name, "--frames", "1", "--no-referee", "--snapshots", "0", "--out", str(out)]
    for option, word in [("--loop", one) for one in ONE_STEP] + [("--meshes", one) for one in AS_IN_THE_FILE]:
        command += [option, word]
    command += ["--data", str(data)] if data else []
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=READING_SECONDS)
    except subprocess.TimeoutExpired:
        raise Problem(f"{scene}: was not read within {READING_SECONDS} s") from None
    lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
    if done.returncode not in ENDED or not (out / "run.json").is_file():
        raise Problem(lines[-1].removeprefix("musclebench: "))
    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    bones = {one["name"]: _surface(out / "meshes" / f"{one['name']}.ply") for one in record["bones"]}
    every = _surface(out / record["snapshots"][0]["file"])
    told = record.get("muscles") or [record["muscle"]]
    muscles, first = {}, 0
    for one in told:
        last = first + int(one["vertices"])
        mine = np.all((every.triangles >= first) & (every.triangles < last), axis=1)
        muscles[one["name"]] = Surface(every.vertices[first:last], every.triangles[mine] - first)
        first = last
    if first != len(every.vertices):
        raise Problem(f"{scene}: its first snapshot has {len(every.vertices)} vertices, its muscles {first}; please report this")
    return bones, muscles


def _surface(path: Path) -> Surface:
    mesh = read_ply(path)
    return Surface(mesh.vertices_m, mesh.triangles)


def _file(word: str, folder: Path, data: Path | None) -> Path:
    if word.startswith("${data}/"):
        if data is None:
            raise Problem(f"{word}: add --data, the folder of the anatomical data")
        return data / word.removeprefix("${data}/")
    return (folder / word).resolve()


def _read_landmarks(base: BaseScene, folder: Path, data: Path | None) -> None:
    """Outlines and fibres of landmark files, in the scene's frame."""
    bones = {one["name"]: one for one in listed(base.tables, "bone")}
    muscles = {one["name"]: one for one in listed(base.tables, "muscle")}
    for area in listed(base.tables, "attachment"):
        if "outline_m" in area:
            base.outlines.append(np.array(area["outline_m"], dtype=float).reshape(-1, 3))
        else:
            word, _, selector = area["outline"].partition("#")
            base.outlines.append(_placed(_outline(_file(word, folder, data), selector), bones[area["bone"]]))
    for name, muscle in muscles.items():
        word, separator, selector = str(muscle.get("fibres", "")).partition("#")
        if separator:
            lines = [np.array(line, dtype=float) for one in _json(_file(word, folder, data))["fibres"] if one["muscle"] == selector
                     for line in one["polylines_m"]]
            base.fibres[name] = [_placed(line, muscle) for line in lines]


def _json(path: Path) -> Table:
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Problem(f"{path}: {error}") from None
    return told if isinstance(told, dict) else {}


def _outline(path: Path, selector: str) -> Points:
    """Of MUSCLE/ROLE, maybe /PART or a number in the file's order (core/scene/landmarks.cpp)."""
    counts: dict[str, int] = {}
    for one in _json(path).get("attachments", []):
        site = f"{one['muscle']}/{one['role']}"
        name = f"{site}/{one['part']}" if isinstance(one.get("part"), str) else site
        counts[name] = counts.get(name, 0) + 1
        if selector in (site, name, f"{name}/{counts[name]}"):
            return np.array(one["points_m"], dtype=float).reshape(-1, 3)
    raise Problem(f"{path}: has no attachment '{selector}'")


def _placed(points: Points, body: Table) -> Points:
    """Rz Ry Rx (scale * point) + translate_m, as the program places landmarks with their mesh."""
    scale = np.broadcast_to(np.array(body.get("scale", 1.0), dtype=float), 3)
    placed = points * scale
    for axis, degrees in enumerate(body.get("rotate_deg", [0, 0, 0])):
        cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turned = placed.copy()
        turned[:, i], turned[:, j] = placed[:, i] * cos - placed[:, j] * sin, placed[:, i] * sin + placed[:, j] * cos
        placed = turned
    result: Points = placed + np.array(body.get("translate_m", [0, 0, 0]), dtype=float)
    return result


def without_places(base: BaseScene) -> Table:
    """The tables as a member takes them over: its meshes are in the scene's frame."""
    tables = deepcopy(base.tables)
    for body in [*listed(tables, "bone"), *listed(tables, "muscle")]:
        for key in PLACING:
            body.pop(key, None)
    return tables
