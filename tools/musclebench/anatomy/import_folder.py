"""What an import writes."""

import json
from pathlib import Path

import numpy as np

from ..lhdl.write_ply import write_ply
from .anatomy_map import AnatomyMap
from .importing import Anatomy
from .joints import Joint
from .map_table import TOGETHER
from .scene_files import AREAS_FILE, MusclePart, areas_json, scene_text

MARK = "import.json"
# The first run asks the scene by trial which effects it needs.
EFFECTS = """
[wanted]
surface_mm = 0.1

[effects]
auto = true
"""
ALL_EFFECTS = """
[contact]
muscle_contact = true
""" + EFFECTS


def write_import(folder: Path, result: Anatomy, anatomy: AnatomyMap) -> list[Path]:
    """Into an empty folder. The scenes, below it."""
    (folder / "meshes").mkdir()
    comments = (anatomy.title, f"licence {anatomy.licence}; see README.md", "units metre")
    for name, part in result.parts.items():
        write_ply(folder / "meshes" / f"{name}.ply", part.surface.vertices / 1000, part.surface.triangles.astype(np.int32), comments)
    (folder / AREAS_FILE).write_text(areas_json(result.muscles), encoding="utf-8")
    scenes = []
    joints: list[Joint | None] = [*result.joints] or [None]
    for joint in joints if result.muscles else []:
        moved = [muscle for muscle in result.muscles if joint is None or is_moved(muscle, joint)]
        kind = Path("scenes") / (joint.name if joint else "rest")
        (folder / kind).mkdir(parents=True)
        own = {words.name: words.scene for words in anatomy.muscles}
        texts = {muscle.name: scene_text(anatomy, joint, [muscle], _tables(anatomy.scene or EFFECTS, own.get(muscle.name, ""))) for muscle in moved}
        if len(moved) > 1:
            together = _tables(anatomy.scene, anatomy.together) if anatomy.scene or anatomy.together else ALL_EFFECTS
            texts[TOGETHER] = scene_text(anatomy, joint, moved, together)
        for name, text in texts.items():
            scenes.append(kind / f"{name}.toml")
            (folder / scenes[-1]).write_text(text, encoding="utf-8")
    (folder / "README.md").write_text(readme(result, anatomy), encoding="utf-8")
    (folder / MARK).write_text(json.dumps(as_json(result, anatomy), indent=1) + "\n", encoding="utf-8")
    return scenes


def _tables(*texts: str) -> str:
    return "\n\n".join(text.strip() for text in texts if text.strip())


def is_moved(muscle: MusclePart, joint: Joint) -> bool:
    """Whether it crosses the joint."""
    bones = {area.bone for area in muscle.areas}
    return bool(bones & set(joint.moves)) and bool(bones - set(joint.moves))


def as_json(result: Anatomy, anatomy: AnatomyMap) -> dict[str, object]:
    return {
        "title": anatomy.title, "licence": anatomy.licence, "non_commercial": anatomy.is_non_commercial, "cite": anatomy.cite,
        "source": anatomy.source, "unit": result.unit,
        "meshes": [{"name": name, "kind": part.found.kind, "file": part.found.path.name, "triangles_in_file": part.raw_triangles,
                    "triangles": len(part.surface.triangles), "error_mm": part.error_mm, "volume_ml": part.surface.volume / 1000,
                    "repairs": part.repairs, "has_tendon": part.tendon is not None} for name, part in result.parts.items()],
        "attachments": [{"muscle": muscle.name, "role": area.role, "bone": area.bone, "nodes": len(area.nodes), "mean_gap_mm": area.mean_gap}
                        for muscle in result.muscles for area in muscle.areas],
        "joints": [{"name": joint.name, "moves": joint.moves, "axis": joint.axis.direction.tolist(), "centre_mm": joint.axis.centre.tolist(),
                    "radius_mm": joint.axis.radius, "rms_mm": joint.axis.rms, "from_deg": joint.from_deg, "to_deg": joint.to_deg,
                    "deepest_mm": joint.deepest, "axis_carried_because": joint.carried} for joint in result.joints],
        "overlaps": [{"muscle": one.muscle, "other": one.other, "triangles": one.triangles, "nodes": one.nodes,
                      "deepest_mm": one.deepest} for one in result.overlaps],
        "passing_triangles": sum(one.triangles for one in result.left), "carried": result.carried,
        "not_imported": result.problems,
    }


def readme(result: Anatomy, anatomy: AnatomyMap) -> str:
    lines = [f"# {anatomy.title}", "", f"Licence: {anatomy.licence}{' (not for commercial use)' if anatomy.is_non_commercial else ''}. "
             f"Made by `tools/import` from the published meshes{f' ({anatomy.source})' if anatomy.source else ''}, which it changed as listed here.", ""]
    lines += ["Cite:", "", *(f"- {one}" for one in anatomy.cite), ""] if anatomy.cite else []
    lines += ["| mesh | kind | triangles in the file | here | largest error (mm) | changes |", "| --- | --- | ---: | ---: | ---: | --- |"]
    for name, part in result.parts.items():
        tendon = ["tendon added"] if part.tendon is not None else []
        deep = [f"which is {part.tendon_in_bone[1]:.1f} mm deep in {part.tendon_in_bone[0]}"] if part.tendon_in_bone[0] else []
        words = [*part.repairs, *tendon, *deep]
        lines.append(f"| {name} | {part.found.kind} | {part.raw_triangles} | {len(part.surface.triangles)} | {part.error_mm:.3f} | {'; '.join(words) or '-'} |")
    if result.carried:
        lines += ["", f"Places of the map were read off another body and carried to this one: {result.carried}."]
    lines += ["", "| muscle | end | bone | nodes | mean distance (mm) |", "| --- | --- | --- | ---: | ---: |"] if result.muscles else []
    lines += [f"| {muscle.name} | {area.role} | {area.bone} | {len(area.nodes)} | {area.mean_gap:.2f} |"
              for muscle in result.muscles for area in muscle.areas]
    for joint in result.joints:
        carried = f", about the axis of the map's reference, carried to this body ({joint.carried})" if joint.carried else ""
        fitted = f", fitted with a radius of {joint.axis.radius:.1f} mm, {joint.axis.rms:.2f} mm off (RMS)" if joint.axis.rms is not None else carried
        pairs = "; ".join(f"{pair} by {depth:.1f} mm" for pair, depth in joint.deepest.items())
        lines += ["", f"Joint {joint.name}: {joint.from_deg:g} to {joint.to_deg:g} degrees{fitted}. "
                  f"Bones come deeper into each other than at rest: {pairs or 'nowhere'}."]
        if stays := [muscle.name for muscle in result.muscles if not is_moved(muscle, joint)]:
            lines += ["", f"These do not cross it and have no scene: {', '.join(stays)}."]
    if result.overlaps:
        passing = sum(one.triangles for one in result.left)
        left = f"{passing} of their triangles still pass through each other" if result.left else "nothing passes through another muscle now"
        lines += ["", f"These overlapped, and were moved apart; {left}.", ""]
        lines += ["| muscle | and | triangles that passed | nodes inside | deepest (mm) |", "| --- | --- | ---: | ---: | ---: |"]
        lines += [f"| {one.muscle} | {one.other} | {one.triangles} | {one.nodes} | {one.deepest:.2f} |" for one in result.overlaps]
    if result.problems:
        lines += ["", "Not imported, or not as told:", "", *(f"- {problem}" for problem in result.problems)]
    return "\n".join(lines) + "\n"
