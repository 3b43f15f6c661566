"""Scenes at random: muscles that are flung, swept along and shut in, in which nothing intersects as they begin."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .judge import passing, winding
from .shapes import SHAPES, Mesh, Points, room, shape, turn, write_stl

KINDS = ("room", "sweep", "throw")
TRIES = 60  # to find room for a body
ROOM_M, WALL_M = (0.03, 0.05), 0.004
SPEEDS = (-1.0, 2.0)  # powers of ten of m/s
STEPS_S = (-4.0, -2.3)  # the same of s
FRAMES = 8
FLIGHT_M = 0.6  # of what meets nothing: what flies far off ends the run
TURN_DEG = (1.0, 30.0)  # of a bone in a frame
PROBED_TURNS = 40  # at which a turning bone has to miss the others


@dataclass
class Body:
    name: str
    kind: str
    mesh: Mesh
    velocity_m_per_s: Points = field(default_factory=lambda: np.zeros(3))
    motion: str = ""  # TOML


@dataclass
class RandomScene:
    number: int
    kind: str
    bones: list[Body]
    muscles: list[Body]
    carriers: dict[str, set[str]]  # bones that carry nodes, by muscle
    attachments: list[str]  # TOML
    effects: list[str]  # TOML
    loop: str  # TOML
    half_room_m: float = 0.0  # to the outside of its wall; 0: no room

    @property
    def has_moving_bones(self) -> bool:
        return any(bone.motion for bone in self.bones)

    @property
    def words(self) -> str:
        fastest = max(float(np.linalg.norm(muscle.velocity_m_per_s)) for muscle in self.muscles)
        return (f"{self.kind}: {' '.join(muscle.kind for muscle in self.muscles)} at {fastest:.2g} m/s, "
                f"bones {' '.join(bone.kind for bone in self.bones)}")


def random_scene(seed: int, number: int) -> RandomScene:
    """The same for the same two numbers, on every machine with the same numpy."""
    random = np.random.default_rng([seed, number])
    kind = KINDS[random.integers(len(KINDS))]
    bones: list[Body] = []
    muscles: list[Body] = []
    half_m, outer_m = float(random.uniform(*ROOM_M)), 0.0
    if kind == "room":
        bones.append(Body("room", "room", room(half_m, WALL_M, int(random.integers(1, 5)))))
        outer_m = half_m + WALL_M
    for number_of_bone in range(random.integers(kind != "room", 3)):
        _add_body(bones, f"bone_{number_of_bone}", half_m, [*bones], random, 12)
    for number_of_muscle in range(random.integers(1, 4)):
        _add_body(muscles, f"muscle_{number_of_muscle}", half_m, [*bones, *muscles], random, 7)
    if not muscles or not bones:
        return random_scene(seed, number + 1_000_000)  # no room was found
    for muscle in muscles:
        aim = -muscle.mesh.points.mean(axis=0) + random.normal(size=3) * half_m / 3
        if random.random() < 0.85:
            muscle.velocity_m_per_s = aim / np.linalg.norm(aim) * 10**random.uniform(*SPEEDS)
    if kind == "sweep":
        _turn(bones, random)
    fastest = max(float(np.linalg.norm(muscle.velocity_m_per_s)) for muscle in muscles)
    carriers: dict[str, set[str]] = {}
    attachments = _attachments(bones, muscles, carriers, random)
    if attachments and random.random() < 0.8:
        attachments.append("[effects.attachment]\n")
    return RandomScene(number, kind, bones, muscles, carriers, attachments, _effects(random), _loop(fastest, random), outer_m)


def _add_body(bodies: list[Body], name: str, half_m: float, others: list[Body], random: np.random.Generator, cells: int) -> None:
    """Where it meets none of the others; without one where no room is found."""
    kind = list(SHAPES)[random.integers(len(SHAPES))]
    for _ in range(TRIES):
        size_m = half_m * float(random.uniform(0.15, 0.6))
        mesh = shape(kind, size_m, int(random.integers(2, cells + 1)), random)
        mesh = mesh.placed(turn(random), random.uniform(-half_m, half_m, size=3))
        if all(_are_apart(mesh, other.mesh) for other in others) and not passing(mesh.points, mesh.triangles, mesh.points, mesh.triangles):
            bodies.append(Body(name, kind, mesh))
            return


def _are_apart(one: Mesh, other: Mesh) -> bool:
    return (not passing(one.points, one.triangles, other.points, other.triangles)
            and abs(winding(one.points[0], other.points, other.triangles)) < 0.5
            and abs(winding(other.points[0], one.points, one.triangles)) < 0.5)


def _turn(bones: list[Body], random: np.random.Generator) -> None:
    """The first that misses the others all the way."""
    for bone in bones:
        axis, per_frame_deg = random.normal(size=3), float(random.uniform(*TURN_DEG))
        axis /= np.linalg.norm(axis)
        centre_m = bone.mesh.points.mean(axis=0) + random.normal(size=3) * random.choice([0.0, 0.02, 0.1])
        whole_deg = per_frame_deg * FRAMES
        others = [other for other in bones if other is not bone]
        if all(_are_apart(_turned(bone.mesh, axis, centre_m, np.radians(whole_deg * step / PROBED_TURNS)), other.mesh)
               for step in range(PROBED_TURNS + 1) for other in others):
            bone.motion = (f"axis = {_list(axis)}\ncentre_m = {_list(centre_m)}\nfrom_deg = 0\nto_deg = {whole_deg:.6g}\n"
                           f"course = \"there\"\n")
            return


def _turned(mesh: Mesh, axis: Points, centre_m: Points, angle_rad: float) -> Mesh:
    """Rodrigues' formula."""
    across = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(angle_rad) * across + (1 - np.cos(angle_rad)) * across @ across
    return mesh.placed(rotation, centre_m - rotation @ centre_m)


def _attachments(bones: list[Body], muscles: list[Body], carriers: dict[str, set[str]], random: np.random.Generator) -> list[str]:
    """Some hang on a bone by their nodes that are nearest to it; tells `carriers` so."""
    texts = []
    for muscle in muscles:
        if random.random() > 0.25:
            continue
        bone = bones[random.integers(len(bones))]
        carriers[muscle.name] = {bone.name}
        away = np.linalg.norm(muscle.mesh.points[:, None] - bone.mesh.points[None], axis=2).min(axis=1)
        nodes = muscle.mesh.points[np.argsort(away, kind="stable")[:max(3, len(away) // 8)]]
        texts.append(f"[[attachment]]\nname = \"hold_{muscle.name}\"\nmuscle = \"{muscle.name}\"\nbone = \"{bone.name}\"\nnear = \"points\"\n"
                     f"outline_m = [{', '.join(_list(node) for node in nodes)}]\ndistance_m = 1e-5\n")
    return texts


def _effects(random: np.random.Generator) -> list[str]:
    """What may be beside the effect that is tried."""
    texts = [f"[effects.edge_length]\ncompliance_m_per_n = {10**random.uniform(-6, -2):.3g}\n"]
    if random.random() < 0.7:
        texts.append("[effects.volume]\n")
    if random.random() < 0.5:
        texts.append("[effects.bending]\ncompliance_rad_per_n_m = 1e4\n")
    if random.random() < 0.3:
        texts.append(f"[effects.damping]\nrate_per_s = {10**random.uniform(-1, 2):.3g}\n")
    if random.random() < 0.3:
        texts.append("[effects.gravity]\n")
    if random.random() < 0.3:
        texts.append(f"[effects.friction]\ncoefficient = {random.uniform(0.1, 1):.2g}\n")
    if random.random() < 0.2:
        texts.append("[effects.surface_contact]\n")
    if random.random() < 0.2:
        texts.append("[effects.self_contact]\n")
    return texts


def _loop(fastest_m_per_s: float, random: np.random.Generator) -> str:
    motion, substeps = ("interpolated", "per_frame")[random.integers(2)], random.choice([1, 1, 2, 5, 20])
    step_s = 10**random.uniform(*STEPS_S)
    if fastest_m_per_s > 0:
        step_s = min(step_s, FLIGHT_M / (fastest_m_per_s * substeps * FRAMES))
    return (f"[loop]\nframes = {FRAMES}\nsubsteps = {substeps}\ntime_step_s = {step_s:.3g}\n"
            f"iterations = {random.choice([1, 1, 3])}\ndensity_kg_per_m3 = 1060\nbone_motion = \"{motion}\"\n")


def _list(values: Points) -> str:
    return "[" + ", ".join(f"{value:.9g}" for value in values) + "]"


def write_scene(scene: RandomScene, folder: Path, tried: list[str]) -> Path:
    """The scene's file, beside its meshes. `tried`: effects that every scene has."""
    folder.mkdir(parents=True, exist_ok=True)
    text = f"title = \"Random scene {scene.number}\"\n"
    for table, bodies in (("bone", scene.bones), ("muscle", scene.muscles)):
        for body in bodies:
            write_stl(folder / f"{body.name}.stl", body.mesh)
            text += f"[[{table}]]\nname = \"{body.name}\"\nmesh = \"{body.name}.stl\"\nunit = \"mm\"\n"
            if body.velocity_m_per_s.any():
                text += f"velocity_m_per_s = {_list(body.velocity_m_per_s)}\n"
            if body.motion:
                text += f"[bone.motion]\n{body.motion}"
    text += "".join(scene.attachments)
    if len(scene.muscles) > 1:
        text += "[contact]\nmuscle_contact = true\n"
    text += "".join(scene.effects) + "".join(f"[effects.{name}]\n" for name in tried) + scene.loop
    path = folder / "scene.toml"
    path.write_text(text)
    return path
