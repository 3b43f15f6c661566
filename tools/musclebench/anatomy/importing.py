"""From a folder of meshes and a map to surfaces, attachments, joints and scenes."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from ..program.cli import Problem
from .anatomy_map import UNITS, AnatomyMap, MuscleWords
from .attaching import Area, areas_near_bones, check_muscle, distances_to, end_of_tendon, moved_out
from .carried import carried
from .found_files import Found
from .joints import Joint, made_joint
from .mesh_file import FORKED, Mended, mend, read_mesh
from .overlaps import Overlap, moved_apart, overlaps_of
from .resolution import decimated
from .rings import ring_around
from .scene_files import MusclePart
from .surface import Points, Surface, sample_points
from .tendon import BESIDE_TIP, Tendon, deepest_in_bones, reach_of_blend, reach_of_tendon, tendon_path, with_tendon
from .units import unit_of

FARTHEST_END_MM = 15.0  # that a tendon's end is moved onto its bone; it is read off by eye
HARDLY_MM = 0.3  # that the middle of a tendon may be in a bone: places are a step apart
REACH_MM = 30.0  # how far distances to bones are looked for
BESIDE_MM = 15.0  # a bone whose box comes nearer than that may be touched

Say = Callable[[str], None]


@dataclass
class Part:
    """Of one file, in millimetres."""

    found: Found
    raw_triangles: int
    surface: Surface
    repairs: list[str]
    error_mm: float = 0.0  # of what was decimated and drawn anew; largest, without the tendon
    tendon: Points | None = None  # its path
    tendon_in_bone: tuple[str, float] = ("", 0.0)  # bone, how deep (mm)


@dataclass
class Anatomy:
    unit: str
    parts: dict[str, Part]
    muscles: list[MusclePart]
    joints: list[Joint]
    overlaps: list[Overlap]  # before they were moved apart
    problems: list[str] = field(default_factory=list)
    left: list[Overlap] = field(default_factory=list)  # after it
    carried: str = ""  # what was done with the map's places
    without_tendons: dict[str, tuple[Surface, float]] = field(default_factory=dict)  # what a muscle was, and its tendon's radius

    def surfaces(self, *kinds: str) -> dict[str, Surface]:
        return {name: part.surface for name, part in self.parts.items() if part.found.kind in kinds}


def import_anatomy(files: list[Found], anatomy: AnatomyMap, problems: list[str], say: Say, is_whole: bool = True) -> Anatomy:
    """What can be imported, and a line for each file that can't. Raises Problem where nothing can. `is_whole`: no muscle was left out
    of `files` on purpose."""
    raw = _read(files, problems, say)
    if not raw:
        raise Problem(f"{anatomy.path}: no mesh of the folder can be used")
    unit = unit_of({str(found.path): surface.diagonal for found, surface in raw}, anatomy.unit)
    parts = _mended(raw, UNITS[unit], problems, say)
    _check_names(anatomy, parts, is_whole, problems)
    result = Anatomy(unit, parts, [], [], [], problems)
    if anatomy.reference is not None:
        say("carrying the map's places to this body")
        if other := carried(anatomy, result.surfaces("bone"), unit):
            anatomy, result.carried = other.anatomy, other.words
    _add_tendons(result, anatomy, say)
    _decimate(result, anatomy.error_mm, say)
    say("fitting joints")
    result.joints = [made_joint(words, result.surfaces("bone", "cartilage"), result.surfaces("bone"), unit) for words in anatomy.joints]
    problems += [f"{anatomy.path}: {problem}" for joint in result.joints for problem in joint.problems]
    say("finding attachments")
    for name, part in list(parts.items()):
        if part.found.kind == "muscle":
            _attach(result, anatomy, name, part)
    result.overlaps = overlaps_of(result.surfaces("muscle"))
    if result.overlaps:
        say("moving muscles apart that overlap")
        _move_apart(result)
        problems += [f"{anatomy.path}: {one.muscle} and {one.other} still overlap{_near(one.at)}, with {one.triangles} triangles and {one.nodes} nodes, "
                     f"{one.deepest:.1f} mm deep: lead their tendons beside each other, or attach fewer nodes (near_mm). Scenes of one muscle are not affected"
                     for one in result.left]
    _add_rings(result, anatomy)
    return result


def _near(place: Points | None) -> str:
    return "" if place is None else f" near ({', '.join(f'{x:.0f}' for x in place)}) mm"


def _move_apart(result: Anatomy) -> None:
    muscles = {muscle.name: muscle.surface for muscle in result.muscles}
    held = {muscle.name: np.isin(np.arange(len(muscle.surface.vertices)), np.concatenate([area.nodes for area in muscle.areas])) for muscle in result.muscles}
    moves = moved_apart(muscles, held, result.surfaces("bone", "cartilage"), result.overlaps)
    for muscle in result.muscles:
        if farthest := moves.get(muscle.name, 0.0):
            result.parts[muscle.name].repairs.append(f"nodes moved out of other muscles, by up to {farthest:.2f} mm")
            muscle.surface.vertices = moved_out(muscle.surface, result.surfaces("bone", "cartilage"), muscle.areas)[0].vertices
    result.left = overlaps_of(muscles)


def _read(files: list[Found], problems: list[str], say: Say) -> list[tuple[Found, Surface]]:
    raw = []
    for found in files:
        say(f"reading {found.path.name}")
        try:
            raw.append((found, read_mesh(found.path)))
        except Problem as problem:
            problems.append(str(problem))
    return raw


def _mended(raw: list[tuple[Found, Surface]], factor: float, problems: list[str], say: Say) -> dict[str, Part]:
    parts = {}
    for found, surface in raw:
        say(f"repairing {found.name}")
        try:
            mended: Mended = mend(Surface(surface.vertices * factor, surface.triangles), str(found.path))
        except Problem as problem:
            problems.append(str(problem))
            continue
        parts[found.name] = Part(found, len(surface.triangles), mended.surface, mended.repairs)
    return parts


def _check_names(anatomy: AnatomyMap, parts: dict[str, Part], is_whole: bool, problems: list[str]) -> None:
    """Raises Problem for a bone that the folder has not; a muscle of the map that is not there is told."""
    solid = [name for name, part in parts.items() if part.found.kind != "muscle"]
    # A surface that is missing here may be the reference's.
    others = [path.stem for path in anatomy.reference.glob("*.ply")] if anatomy.reference is not None else []
    for place, name in [(f"joint {joint.name}", name) for joint in anatomy.joints for name in (*joint.moves, joint.surface, joint.facing) if name]:
        if name not in solid and (name not in others or any(name in joint.moves for joint in anatomy.joints)):
            raise Problem(f"{anatomy.path}: {place} names '{name}', and there is no such bone or cartilage; there are {', '.join(sorted(solid))}")
    for words in anatomy.muscles:
        if words.name not in parts and is_whole:
            problems.append(f"{anatomy.path}: there is no muscle '{words.name}' in the folder")
        for name in (*words.origin, *words.insertion, *([words.tendon.to, *(ring[0] for ring in words.tendon.rings)] if words.tendon else [])):
            if words.name in parts and name not in solid:
                raise Problem(f"{anatomy.path}: muscle {words.name} names '{name}', and there is no such bone; there are {', '.join(sorted(solid))}")


def _words_of(anatomy: AnatomyMap, name: str) -> MuscleWords:
    return next((words for words in anatomy.muscles if words.name == name), MuscleWords(name))


def _add_tendons(result: Anatomy, anatomy: AnatomyMap, say: Say) -> None:
    bones = result.surfaces("bone", "cartilage")
    for words in anatomy.muscles:
        part = result.parts.get(words.name)
        if part is None or words.tendon is None:
            continue
        say(f"adding the tendon of {words.name}")
        factor = UNITS[result.unit]
        at = bones[words.tendon.to].distance.nearest(words.tendon.at * factor)
        tendon = Tendon(words.tendon.to, at, words.tendon.through * factor, words.tendon.radius)
        try:
            if (moved := float(np.linalg.norm(at - words.tendon.at * factor))) > FARTHEST_END_MM:
                raise Problem(f"its tendon's `at` is {moved:.0f} mm away from {words.tendon.to}; is the map for meshes in this place and unit?")
            others = {name: other for name, other in result.surfaces("muscle").items() if name != words.name}
            part.tendon = tendon_path(part.surface, tendon, bones, others)
            part.tendon_in_bone = deepest_in_bones(part.tendon, tendon, bones)
            bone, depth = deepest_in_bones(part.tendon, tendon, bones, BESIDE_TIP)
            if depth > words.tendon.radius + HARDLY_MM:  # its middle is in the bone
                raise Problem(f"its tendon leads {depth:.1f} mm deep through {bone}; lead it around by places of `through`")
            without, part.surface = part.surface, with_tendon(part.surface, part.tendon, tendon.radius)
            result.without_tendons[words.name] = (without, tendon.radius)
        except Problem as problem:
            result.problems.append(f"{part.found.path}: {problem}")
            del result.parts[words.name]


def _decimate(result: Anatomy, error_mm: float, say: Say) -> None:
    names = list(result.parts)
    say(f"decimating {len(names)} meshes to {error_mm:g} mm")
    try:
        with ProcessPoolExecutor(mp_context=FORKED) as pool:
            for name, (surface, gap) in zip(names, pool.map(decimated, [result.parts[name].surface for name in names], [error_mm] * len(names))):
                result.parts[name].surface, result.parts[name].error_mm = surface, gap
                say(f"decimated {name}")
    except BrokenProcessPool:
        raise Problem("a process that decimates was ended from outside; was there memory enough?") from None
    for name, (muscle, radius) in result.without_tendons.items():
        if name in result.parts:
            result.parts[name].error_mm = _gap_beside_tendon(muscle, result.parts[name], radius)


def _gap_beside_tendon(muscle: Surface, part: Part, radius: float) -> float:
    """The largest distance of the given muscle's points from the surface that has a tendon, and of that surface's from the muscle, where there is none."""
    assert part.tendon is not None
    gaps = []
    for points, other in ((sample_points(muscle), part.surface), (sample_points(part.surface), muscle)):
        to_tendon = cKDTree(part.tendon).query(points, distance_upper_bound=reach_of_tendon(radius) + 1.0)[0]
        gaps.append(float(np.abs(other.distance(points[~np.isfinite(to_tendon)])).max()))
    return max(gaps)


def _attach(result: Anatomy, anatomy: AnatomyMap, name: str, part: Part) -> None:
    words = _words_of(anatomy, name)
    near = words.near_mm or anatomy.near_mm
    bones = result.surfaces("bone", "cartilage")
    distances = distances_to(part.surface, bones, REACH_MM)
    try:
        areas = _areas(part, words, near, distances)
        check_muscle(name, part.surface, distances, areas, near)
    except Problem as problem:
        result.problems.append(f"{part.found.path}: {problem}")
        del result.parts[name]
        return
    part.surface, told = moved_out(part.surface, bones, areas)
    part.repairs += told
    result.muscles.append(MusclePart(name, part.surface, areas, _bones_beside(result, part.surface, areas), tone=words.tone))


def _areas(part: Part, words: MuscleWords, near: float, distances: dict[str, Points]) -> list[Area]:
    roles = dict.fromkeys(words.insertion, "insertion") | dict.fromkeys(words.origin, "origin")
    if bool(words.origin) != bool(words.insertion) and words.tendon is None:  # the other end is where it touches
        other = "insertion" if words.origin else "origin"
        roles = dict.fromkeys(distances, other) | roles
    allowed = np.ones(len(part.surface.vertices), dtype=bool)
    ends = []
    if part.tendon is not None and words.tendon is not None:
        allowed = ~np.isfinite(cKDTree(part.tendon).query(part.surface.vertices, distance_upper_bound=reach_of_blend(words.tendon.radius))[0])
        ends.append(end_of_tendon(part.surface, words.tendon.to, distances[words.tendon.to], part.tendon[-1], words.tendon.radius))
        if not len(ends[0].nodes):
            raise Problem(f"its tendon does not reach {words.tendon.to}; give `at` on the bone")
    areas = areas_near_bones(part.surface, distances, near, roles, allowed)
    if ends and not words.origin:
        areas = [Area(area.bone, "origin", area.nodes, area.mean_gap) for area in areas]
    return areas + ends


def _add_rings(result: Anatomy, anatomy: AnatomyMap) -> None:
    """A ring that can't be placed is told; the muscle goes without it."""
    for muscle in result.muscles:
        part, words = result.parts[muscle.name], _words_of(anatomy, muscle.name)
        if words.tendon is None or part.tendon is None:
            continue
        for bone, at, room in words.tendon.rings:
            try:
                muscle.rings.append(ring_around(muscle.surface, part.tendon, bone, at * UNITS[result.unit], room))
            except Problem as problem:
                result.problems.append(f"{part.found.path}: {muscle.name} has no ring on {bone}: {problem}")
        muscle.bones += [ring.bone for ring in muscle.rings if ring.bone not in muscle.bones]


def _bones_beside(result: Anatomy, muscle: Surface, areas: list[Area]) -> list[str]:
    low, high = muscle.vertices.min(axis=0) - BESIDE_MM, muscle.vertices.max(axis=0) + BESIDE_MM
    attached = {area.bone for area in areas}
    found = []
    for name, bone in result.surfaces("bone", "cartilage").items():
        is_solid = result.parts[name].found.kind == "bone" or name in attached
        places = [bone.vertices]
        for joint in result.joints:
            if name in joint.moves:
                places += joint.places(bone.vertices, 3)
        if name in attached or (is_solid and any(bool(np.all((place > low) & (place < high), axis=1).any()) for place in places)):
            found.append(name)
    return found
