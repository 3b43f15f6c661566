"""Makes the members of a population: each is a scene file with its meshes."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..anatomy.surface import Points
from ..lhdl.write_ply import write_ply
from ..program.cli import Problem
from ..program.fingerprint import file_digest
from .base_scene import BaseScene, Table, listed, motions_of, with_backends, without_places
from .deformation import Deformation, Frame, Map, bent, frame_of, jacobian, scaled, stretches, twisted, with_carry
from .modes import Modes, read_modes
from .refitting import joints_of, moved_axis
from .shape_words import Shape
from .shapes import drawn_amounts
from .toml_text import toml_text

LANDMARKS = "landmarks.json"
ABOUT = "member.json"


@dataclass
class Member:
    number: int  # 0: the scene as it is
    scene: Path
    amounts: list[list[float]]  # by shape
    axes_moved: list[dict[str, float]] = field(default_factory=list)  # {mm, deg} by joint


class Family:
    """A scene, the shapes in which its members differ, and what of these is the same for all."""

    def __init__(self, base: BaseScene, shapes: list[Shape], seed: int):
        """Raises Problem."""
        self.base, self.shapes, self.seed = base, shapes, seed
        kinds = [(shape.kind, shape.bone) for shape in shapes]
        if twice := next((shape for shape in shapes if kinds.count((shape.kind, shape.bone)) > 1), None):
            raise Problem(f"--shape {twice.words}: {twice.kind} is given twice{f' for {twice.bone}' if twice.bone else ''}; keep one")
        for shape in shapes:
            if shape.bone and shape.bone not in base.bones:
                raise Problem(f"--shape {shape.words}: the scene has no bone '{shape.bone}'; there are {', '.join(base.bones)}")
        self.joints = joints_of(base)
        self.whole = frame_of([*base.bones.values(), *base.muscles.values()])
        self.frames = {shape.bone: frame_of([base.bones[shape.bone]], self._pivot(shape.bone)) for shape in shapes if shape.bone}
        self.modes: dict[str, Modes] = {shape.words: read_modes(shape.folder, base.bones[shape.bone], shape.bone)
                                        for shape in shapes if shape.folder is not None}

    def member(self, number: int, folder: Path, name: str = "") -> Member:
        """Writes it below `folder`, which must not be there. `name`: of the scene file (default: the folder's)."""
        amounts = drawn_amounts(self.shapes, number, self.seed) if number else []
        deformation = self.deformation(amounts)
        tables = without_places(self.base)
        member = Member(number, folder / f"{name or folder.name}.toml", amounts)
        for kind in ("bones", "muscles"):
            (folder / "meshes" / kind).mkdir(parents=True)
        tables["title"] = f"{tables.get('title', self.base.name)}, member {number}" if number else tables.get("title", self.base.name)
        self._write_bodies(tables, deformation, folder)
        self._write_areas(tables, deformation, folder)
        self._move_joints(tables, deformation, member)
        self._move_rings(tables, deformation)
        # What the scene names beside its meshes counts for whether a run is complete: by its digest in the text.
        beside = [folder / LANDMARKS, *(Path(motion["table"]) for bone in listed(tables, "bone") for motion in motions_of(bone) if "table" in motion)]
        digests = [f"# {path.name} {file_digest(path)}" for path in beside if path.is_file()]
        member.scene.write_text("\n".join([*digests, toml_text(tables)]), encoding="utf-8")
        about = {"scene": self.base.name, "member": number, "seed": self.seed, "shapes": [shape.words for shape in self.shapes],
                 "amounts": dict(zip((c for shape in self.shapes for c in shape.columns), (a for one in amounts for a in one))),
                 "axes_moved": member.axes_moved}
        (folder / ABOUT).write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
        return member

    def deformation(self, amounts: list[list[float]]) -> Deformation:
        """`amounts`: none for the scene as it is."""
        made = Deformation()
        for shape, own in zip(self.shapes, amounts):
            apply = self._map(shape, own, self.frames[shape.bone] if shape.bone else self.whole)
            if shape.bone:
                made.own.setdefault(shape.bone, []).append(apply)
            else:
                made.whole.append(apply)
        return with_carry(made, self.base.bones)

    def _map(self, shape: Shape, amounts: list[float], frame: Frame) -> Map:
        if shape.kind in ("size", "scale"):
            return scaled(amounts, frame)
        if shape.kind == "twist":
            return twisted(amounts[0], frame)
        if shape.kind == "bend":
            return bent(amounts[0], amounts[1], frame)
        return self.modes[shape.words].map_of(amounts)

    def _pivot(self, bone: str) -> Points | None:
        """The nearest joint about which the bone turns, or in which it stands still, stays where it is."""
        own = [joint.centre for joint in self.joints if bone in joint.bones] or [joint.centre for joint in self.joints]
        middle = self.base.bones[bone].vertices.mean(axis=0)
        return min(own, key=lambda centre: float(np.linalg.norm(centre - middle)), default=None)

    def _write_bodies(self, tables: Table, deformation: Deformation, folder: Path) -> None:
        source = tables.get("source", {})
        comments = [f"licence {' '.join(source['licence'].split())}"] if "licence" in source else []
        for bone in listed(tables, "bone"):
            surface = self.base.bones[bone["name"]]
            bone["mesh"] = f"meshes/bones/{bone['name']}.ply"
            write_ply(folder / bone["mesh"], deformation.of_bone(bone["name"], surface.vertices), surface.triangles.astype(np.int32), comments)
        for muscle in listed(tables, "muscle"):
            surface = self.base.muscles[muscle["name"]]
            muscle["mesh"] = f"meshes/muscles/{muscle['name']}.ply"
            write_ply(folder / muscle["mesh"], deformation.of_space(surface.vertices), surface.triangles.astype(np.int32), comments)

    def _write_areas(self, tables: Table, deformation: Deformation, folder: Path) -> None:
        """Outlines go with the bone that nodes are near to, else with the muscle. Distances grow as the space there does; those of
        points that were picked on the muscle only shrink, so that they bind no other node."""
        for area, points in zip(listed(tables, "attachment"), self.base.outlines):
            near = area.get("near", "bone")
            move: Map = _of_bone(deformation, area["bone"]) if near == "bone" else deformation.of_space
            if not deformation.is_none:
                matrix = jacobian(move, points.mean(axis=0), self.whole.diagonal)
                distance, margin = (min(stretches(matrix)[0], 1.0), 1.0) if near == "points" else stretches_of_area(matrix, points)
                for key, factor in (("distance_m", distance), ("margin_m", margin)):
                    if key in area:
                        area[key] = float(area[key]) * factor
            area.pop("outline", None)
            area["outline_m"] = move(points).tolist()
        for body in listed(tables, "muscle"):
            if body["name"] in self.base.fibres:
                body["fibres"] = f"{LANDMARKS}#{body['name']}"
        if not self.base.fibres:
            return
        fibres = [{"muscle": name, "polylines_m": [deformation.of_space(line).tolist() for line in lines]}
                  for name, lines in self.base.fibres.items()]
        (folder / LANDMARKS).write_text(json.dumps({"attachments": [], "fibres": fibres}) + "\n", encoding="utf-8")

    def _move_joints(self, tables: Table, deformation: Deformation, member: Member) -> None:
        if deformation.is_none:
            return
        moved = [moved_axis(joint, deformation, self.whole.diagonal) for joint in self.joints]
        for joint, (axis, centre) in zip(self.joints, moved):
            shift = deformation.of_bone(joint.bones[0], joint.centre[None])[0] - centre
            across = shift - (shift @ axis) * axis
            member.axes_moved.append({"off_carried_mm": 1000 * float(np.linalg.norm(across)),
                                      "turned_deg": float(np.degrees(np.arccos(np.clip(abs(axis @ joint.axis), 0, 1))))})
        for bone in listed(tables, "bone"):
            for motion in motions_of(bone):
                axis, centre = moved[self._joint_of(motion)]
                motion["axis"], motion["centre_m"] = axis.tolist(), centre.tolist()

    def _joint_of(self, motion: Table) -> int:
        axis, centre = np.array(motion["axis"], dtype=float), np.array(motion["centre_m"], dtype=float)
        axis = axis / np.linalg.norm(axis)
        return next(i for i, one in enumerate(self.joints) if np.allclose(one.axis, axis) and np.allclose(one.centre, centre))

    def _move_rings(self, tables: Table, deformation: Deformation) -> None:
        """A ring opens as the space across it grows."""
        if deformation.is_none:
            return
        for ring in listed(tables, "retinaculum"):
            centre, axis = np.array(ring["centre_m"], dtype=float), np.array(ring["axis"], dtype=float)
            axis = axis / np.linalg.norm(axis)
            matrix = jacobian(deformation.of_space, centre, self.whole.diagonal)
            across = np.linalg.svd(np.eye(3) - np.outer(axis, axis))[0][:, :2]
            along, wide = float(np.linalg.norm(matrix @ axis)), float(np.linalg.svd(matrix @ across, compute_uv=False)[0])
            ring["centre_m"] = deformation.of_space(centre[None])[0].tolist()
            ring["axis"] = (matrix @ axis / along).tolist()
            for key, factor in (("radius_m", wide), ("half_width_m", along), ("slide_m", along)):
                if key in ring:
                    ring[key] = float(ring[key]) * factor


def stretches_of_area(matrix: Points, points: Points) -> tuple[float, float]:
    """By a Jacobian (3, 3), at right angles to the area through the points and in it."""
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=True)[2]
    return float(np.linalg.norm(matrix @ axes[2])), float(np.sqrt(np.prod(np.linalg.svd(matrix @ axes[:2].T, compute_uv=False))))


def _of_bone(deformation: Deformation, bone: str) -> Map:
    return lambda points: deformation.of_bone(bone, points)


def words_of(family: Family) -> list[str]:
    """What a user has to know of how members are made."""
    joints = [f"axis of {', '.join(joint.bones)}: {joint.words}" for joint in family.joints]
    modes = [f"{words}: {len(one.directions)} modes with {sum(one.explained):.0%} of the variance; the mean shape, {one.scale:.3g} times as large, is "
             f"{one.off:.1%} of the diagonal off" for words, one in family.modes.items()]
    fixed = [f"the backend of {name} is the scene's own: no setting changes it" for name in with_backends(family.base.tables)]
    return joints + modes + fixed
