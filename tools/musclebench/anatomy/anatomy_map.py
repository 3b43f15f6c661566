"""The map: a small TOML file that says which file is which part, what moves, and where the data come from."""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from ..program.cli import Problem
from .joint_axis import Axis
from .map_table import MapTable
from .rings import ROOM_MM
from .surface import Points

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}  # millimetres in each
KINDS = ("bone", "cartilage", "muscle")
FITS = ("cylinder", "sphere")
NON_COMMERCIAL = re.compile(r"\bNC\b|non-?commercial", re.IGNORECASE)
MOST_TONE = 0.6  # as that of the effect `activation`


@dataclass
class TendonWords:
    """Of one tendon. Places are in the unit and frame of the files."""

    to: str
    at: Points
    through: Points
    radius: float  # millimetres
    rings: list[tuple[str, Points, float]] = field(default_factory=list)  # (bone that carries it, where about, room in millimetres)


@dataclass
class MuscleWords:
    name: str
    origin: list[str] = field(default_factory=list)  # bones; none: what is near
    insertion: list[str] = field(default_factory=list)
    near_mm: float | None = None
    tendon: TendonWords | None = None
    tone: float = 0.0  # share of its length by which it wants to be shorter, which takes up slack
    scene: str = ""  # tables of the scenes that have this muscle alone


@dataclass
class JointWords:
    """A hinge: `moves` turn about an axis."""

    name: str
    moves: list[str]
    axis: Points | None = None  # and centre; or a fit
    centre: Points | None = None
    opensim: str = ""  # model below the folder
    coordinate: str = ""  # of it
    fit: str = ""
    surface: str = ""  # that is fitted, where it faces `facing`
    facing: str = ""
    axis_towards: Points | None = None  # which of its two directions is positive
    otherwise: Axis | None = None  # of the reference, carried to this body, in millimetres: where its own surfaces tell none, or a wrong one
    from_deg: float = 0.0
    to_deg: float = 0.0


@dataclass
class AnatomyMap:
    path: Path
    title: str
    licence: str
    cite: list[str]
    source: str = ""
    is_non_commercial: bool = False
    unit: str = ""
    side: str = ""  # what the group `side` of a pattern has to be
    rules: list[tuple[str, re.Pattern[str]]] = field(default_factory=list)  # (kind, pattern with a group `name`)
    renamed: dict[str, str] = field(default_factory=dict)
    error_mm: float = 0.1
    near_mm: float = 1.5
    muscles: list[MuscleWords] = field(default_factory=list)
    joints: list[JointWords] = field(default_factory=list)
    scene: str = ""  # tables of each scene, instead of those that ask by trial
    together: str = ""  # tables of the scenes of several muscles
    reference: Path | None = None  # meshes of the body that places were read off
    reference_unit: str = "mm"  # of these places


def read_map(path: Path) -> AnatomyMap:
    """Raises Problem with file, key and cure."""
    try:
        table = MapTable(path, "", tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Problem(f"{path}: is not valid TOML ({error})") from None
    table.allow_only("title", "licence", "non_commercial", "cite", "source", "unit", "side", "error_mm", "near_mm", "files", "muscle", "joint",
                     "scene", "together", "reference")
    files = table.table("files")
    files.allow_only(*KINDS, "names")
    rules = [(kind, _pattern(files, kind, text)) for kind in KINDS for text in files.words(kind)]
    if not rules:
        raise Problem(f"{path}: [files] has no pattern; give bone, cartilage or muscle = 'regular expression with (?P<name>...)'")
    unit = table.word("unit", "")
    if unit and unit not in UNITS:
        raise Problem(f"{path}: unit '{unit}' has to be one of {', '.join(UNITS)}")
    licence, is_non_commercial = table.word("licence"), table.get("non_commercial")
    if is_non_commercial is None and NON_COMMERCIAL.search(licence):
        raise Problem(f"{path}: licence '{licence}' seems to forbid commercial use; write non_commercial = true, or false")
    if not isinstance(is_non_commercial, bool | None):
        raise Problem(f"{path}: non_commercial: has to be true or false")
    names = files.table("names")
    renamed = {key: names.name(key) for key in names.values}
    muscles, joints = [_muscle(one) for one in table.tables("muscle")], [_joint(one) for one in table.tables("joint")]
    for kind, named in (("muscle", [one.name for one in muscles]), ("joint", [one.name for one in joints])):
        if twice := next((name for name in named if named.count(name) > 1), None):
            raise Problem(f"{path}: {kind} '{twice}' stands there twice; write one table for it")
    reference = table.table("reference")
    reference.allow_only("meshes", "unit")
    meshes = (path.parent / reference.word("meshes")).resolve() if reference.values else None
    if meshes is not None and not meshes.is_dir():
        raise Problem(f"{reference.at('meshes')}: {meshes} is no folder; name the folder `meshes` of an import, from the map's folder on")
    if (reference_unit := reference.word("unit", "mm")) not in UNITS:
        raise Problem(f"{reference.at('unit')}: has to be one of {', '.join(UNITS)}")
    return AnatomyMap(
        path, table.word("title"), licence, table.words("cite"), table.word("source", ""), bool(is_non_commercial), unit, table.word("side", ""), rules,
        renamed, table.positive("error_mm", 0.1), table.positive("near_mm", 1.5), muscles, joints,
        table.tables_text("scene"), table.tables_text("together"), meshes, reference_unit)


def _pattern(files: MapTable, kind: str, text: str) -> re.Pattern[str]:
    try:
        pattern = re.compile(text)
    except re.error as error:
        raise Problem(f"{files.at(kind)}: '{text}' is no regular expression ({error})") from None
    if "name" not in pattern.groupindex:
        raise Problem(f"{files.at(kind)}: '{text}' has no group (?P<name>...), which says what the part is called")
    return pattern


def _muscle(table: MapTable) -> MuscleWords:
    table.allow_only("name", "origin", "insertion", "near_mm", "tendon", "tone", "scene")
    near = table.positive("near_mm") if table.get("near_mm") is not None else None
    tendon = None
    if table.get("tendon") is not None:
        words = table.table("tendon")
        words.allow_only("to", "at", "through", "radius_mm", "rings")
        rings = []
        for ring in words.tables("rings"):
            ring.allow_only("bone", "at", "room_mm")
            rings.append((ring.word("bone"), ring.point("at"), ring.positive("room_mm", ROOM_MM)))
        tendon = TendonWords(words.word("to"), words.point("at"), words.points("through"), words.positive("radius_mm"), rings)
    tone = table.number("tone", 0.0)
    if not 0 <= tone <= MOST_TONE:
        raise Problem(f"{table.at('tone')}: has to be from 0 to {MOST_TONE:g}, a share of the muscle's length")
    return MuscleWords(table.word("name"), table.words("origin"), table.words("insertion"), near, tendon, tone, table.tables_text("scene"))


def _joint(table: MapTable) -> JointWords:
    table.allow_only("name", "moves", "axis", "centre", "opensim", "coordinate", "fit", "surface", "facing", "axis_towards", "from_deg", "to_deg")
    joint = JointWords(table.name("name"), table.words("moves"), from_deg=table.number("from_deg"), to_deg=table.number("to_deg"))
    if not joint.moves:
        raise Problem(f"{table.at('moves')}: names no bone")
    if len(ways := [key for key in ("axis", "opensim", "fit") if table.get(key) is not None]) > 1:
        raise Problem(f"{table.at(ways[0])}: stands there with {ways[1]}; keep one of the two")
    if max(abs(joint.from_deg), abs(joint.to_deg)) > 360:
        raise Problem(f"{table.at('to_deg')}: a joint turns by at most 360 degrees")
    if table.get("axis") is not None:
        joint.axis, joint.centre = table.direction("axis"), table.point("centre")
        return joint
    if table.get("opensim") is not None:
        joint.opensim, joint.coordinate = table.word("opensim"), table.word("coordinate")
        return joint
    joint.fit, joint.surface, joint.facing = table.word("fit"), table.word("surface"), table.word("facing", "")
    joint.axis_towards = table.direction("axis_towards")
    if joint.fit not in FITS:
        raise Problem(f"{table.at('fit')}: '{joint.fit}' has to be one of {', '.join(FITS)}")
    return joint
