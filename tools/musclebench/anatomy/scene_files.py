"""Scenes as TOML files, and the places where muscles are attached."""

import json
import tomllib
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from ..program.cli import Problem
from .anatomy_map import AnatomyMap
from .attaching import Area
from .joints import Joint
from .rings import SLIDE_MM, Ring
from .surface import Points, Surface

AREAS_FILE = "attachments.json"


@dataclass
class MusclePart:
    name: str
    surface: Surface
    areas: list[Area]
    bones: list[str]  # that it may touch
    rings: list[Ring] = field(default_factory=list)
    tone: float = 0.0  # share of its length by which it wants to be shorter


def scene_text(anatomy: AnatomyMap, joint: Joint | None, muscles: list[MusclePart], effects: str) -> str:
    """`effects`: lines of the scene's effects."""
    bones = list(dict.fromkeys(bone for muscle in muscles for bone in muscle.bones))
    names = ", ".join(muscle.name.replace("_", " ") for muscle in muscles)
    lines = [f"title = {_quoted(f'{anatomy.title}: {names}')}", 'preset = "standard"', "", *source_lines(anatomy), ""]
    for bone in bones:
        lines += ["[[bone]]", f"name = {_quoted(bone)}", f"mesh = {_quoted(f'../../meshes/{bone}.ply')}"]
        if joint is not None and bone in joint.moves:
            lines += ["[bone.motion]", f"axis = {_point(joint.axis.direction)}", f"centre_m = {_point(joint.axis.centre / 1000)}",
                      f"from_deg = {joint.from_deg:g}", f"to_deg = {joint.to_deg:g}", 'course = "rest_to_rest"']
        lines.append("")
    tone = max(muscle.tone for muscle in muscles)
    for muscle in muscles:
        lines += ["[[muscle]]", f"name = {_quoted(muscle.name)}", f"mesh = {_quoted(f'../../meshes/{muscle.name}.ply')}", 'fibres = "between_attachments"']
        lines += [f"activation = {muscle.tone / tone:.4g}"] if muscle.tone < tone else []
        lines.append("")
    for muscle in muscles:
        for area in muscle.areas:
            lines += ["[[attachment]]", f"name = {_quoted(f'{muscle.name}_{area.name}' if len(muscles) > 1 else area.name)}",
                      f"muscle = {_quoted(muscle.name)}", f"bone = {_quoted(area.bone)}", f"end = {_quoted(area.role)}", 'near = "points"',
                      f"outline = {_quoted(f'../../{AREAS_FILE}#{muscle.name}/{area.role}/{area.bone}')}",
                      f"distance_m = {reach_m(muscle.surface, area):.4g}", ""]
    for muscle in muscles:
        for number, ring in enumerate(muscle.rings, start=1):
            lines += ["[[retinaculum]]", f"name = {_quoted(f'{muscle.name}_{ring.bone}_{number}')}", f"muscle = {_quoted(muscle.name)}",
                      f"bone = {_quoted(ring.bone)}", f"centre_m = {_point(ring.centre / 1000)}", f"axis = {_point(ring.axis)}",
                      f"radius_m = {ring.radius / 1000:.4g}", f"half_width_m = {ring.half_width / 1000:.4g}", f"slide_m = {SLIDE_MM / 1000:g}", ""]
    if tone:
        effects = f"{effects.rstrip()}\n\n[effects.activation]     # a tone that takes up the slack\nshortening = {tone:g}\nrise_s = 0.0\n"
    if any(muscle.rings for muscle in muscles) and "[effects.retinaculum]" not in effects:
        effects = effects.rstrip() + "\n\n[effects.retinaculum]\n"
    text = "\n".join([*lines, effects.strip(), ""])
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Problem(f"{anatomy.path}: the tables of `scene` do not fit together in the scene of {names} ({error}); name each table once") from None
    return text


def source_lines(anatomy: AnatomyMap) -> list[str]:
    lines = ["[source]", f"licence = {_quoted(anatomy.licence)}", f"non_commercial = {str(anatomy.is_non_commercial).lower()}"]
    lines += [f"cite = {json.dumps(anatomy.cite, ensure_ascii=False)}"] if anatomy.cite else []
    return lines + ([f"url = {_quoted(anatomy.source)}"] if anatomy.source else [])


def reach_m(surface: Surface, area: Area) -> float:
    """That binds the nodes of the area and no other one: half the way to the next, and at most half an edge."""
    corners = surface.corners
    half_edge = float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2))) / 2
    others = np.delete(surface.vertices, area.nodes, axis=0)
    to_next = cKDTree(surface.vertices[area.nodes]).query(others)[0].min(initial=2 * half_edge)
    return float(min(half_edge, to_next / 2)) / 1000


def areas_json(muscles: list[MusclePart]) -> str:
    entries = [{"muscle": muscle.name, "role": area.role, "part": area.bone,
                "points_m": np.round(muscle.surface.vertices[area.nodes] / 1000, 7).tolist()} for muscle in muscles for area in muscle.areas]
    return json.dumps({"attachments": entries}) + "\n"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _point(values: Points) -> str:
    return f"[{', '.join(f'{value:.9g}' for value in values)}]"
