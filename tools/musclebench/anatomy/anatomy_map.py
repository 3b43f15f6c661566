"""The map: a small TOML file that says which file is which part, what moves, and where the data come from."""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..program.cli import Problem
from .mesh_file import READERS
from .surface import Points

LARGEST = 1e9  # of a number in a map
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}  # millimetres in each
KINDS = ("bone", "cartilage", "muscle")
FITS = ("cylinder", "sphere")
NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")
TOGETHER = "all"  # the scene of all muscles
CONTROL = re.compile(r"[\x00-\x1f\x7f]")
NON_COMMERCIAL = re.compile(r"\bNC\b|non-?commercial", re.IGNORECASE)


@dataclass
class TendonWords:
    """Of one tendon; millimetres in the frame of the files, or their unit where that is another."""

    to: str
    at: Points
    through: Points
    radius: float


@dataclass
class MuscleWords:
    name: str
    origin: list[str] = field(default_factory=list)  # bones; none: what is near
    insertion: list[str] = field(default_factory=list)
    near_mm: float | None = None
    tendon: TendonWords | None = None
    sheaths: list[dict[str, Any]] = field(default_factory=list)


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


@dataclass
class Found:
    """A mesh file and what it is."""

    path: Path
    kind: str
    name: str


def read_map(path: Path) -> AnatomyMap:
    """Raises Problem with file, key and cure."""
    try:
        table = _Table(path, "", tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Problem(f"{path}: is not valid TOML ({error})") from None
    table.allow_only("title", "licence", "non_commercial", "cite", "source", "unit", "side", "error_mm", "near_mm", "files", "muscle", "joint")
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
    return AnatomyMap(
        path, table.word("title"), licence, table.words("cite"), table.word("source", ""), bool(is_non_commercial), unit, table.word("side", ""), rules,
        renamed, table.positive("error_mm", 0.1), table.positive("near_mm", 1.5), muscles, joints)


def find_files(folder: Path, anatomy: AnatomyMap, without: Path | None = None) -> tuple[list[Found], list[str]]:
    """The meshes that the map names, and one line for each that two rules or two files claim: none of these is taken. Raises Problem
    where two sides are there and none is chosen. `without`: a folder in it that is not searched."""
    if anatomy.side and not any("side" in rule.groupindex for _, rule in anatomy.rules):
        raise Problem(f"{anatomy.path}: no pattern has a group (?P<side>...), so that side '{anatomy.side}' chooses nothing; add one, or leave the side out")
    found: dict[str, list[Found]] = {}
    problems = []
    sides: dict[str, Path] = {}
    for path in sorted(one for one in folder.rglob("*") if one.suffix.lower() in READERS and one.is_file()):
        if without is not None and path.resolve().is_relative_to(without):
            continue
        inside = path.relative_to(folder).as_posix()
        matches = [(kind, match) for kind, rule in anatomy.rules if (match := rule.search(inside))]
        if not matches:
            continue
        kind, match = matches[0]
        side = match.groupdict().get("side") or ""
        if side and anatomy.side and side.lower() != anatomy.side.lower():
            continue
        if side:
            sides.setdefault(side.lower(), path)
        raw = match.group("name") or ""
        name = anatomy.renamed.get(raw, _simple(raw)) + ("_cartilage" if kind == "cartilage" else "")
        if len({(kind, match.group("name")) for kind, match in matches}) > 1:
            problems.append(f"{path}: matches several patterns of {anatomy.path.name}, such as {matches[0][0]} and {matches[1][0]}; make them narrower")
        elif not NAME.fullmatch(name) or name == TOGETHER:
            problems.append(f"{path}: '{name}' can be no name of a part; give it one of letters, digits, _ and - in [files.names]")
        else:
            found.setdefault(name, []).append(Found(path, kind, name))
    if len(sides) > 1:
        raise Problem(f"{folder}: has {' and '.join(sides)}, such as {' and '.join(path.name for path in sides.values())}: choose one by --side or by `side` "
                      f"of {anatomy.path.name}")
    for name, several in found.items():
        if len(several) > 1:
            others = ", ".join(one.path.name for one in several[1:])
            problems.append(f"{several[0].path}: '{name}' is {others}, too; tell them apart by [files.names] or a narrower pattern")
    return [several[0] for several in found.values() if len(several) == 1], problems


def _simple(raw: str) -> str:
    """soleus, tibialis_anterior: of whatever way of writing a name of several words."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", raw)
    return re.sub(r"[\s./()-]+", "_", words.lower()).strip("_.")


class _Table:
    """A table of the map, which knows where it stands."""

    def __init__(self, path: Path, place: str, values: dict[str, Any]):
        self.path, self.place, self.values = path, place, values

    def at(self, key: str) -> str:
        return f"{self.path}: {self.place}{key}"

    def get(self, key: str, default: Any = None) -> Any:
        return self.values.get(key, default)

    def allow_only(self, *known: str) -> None:
        for key in self.values:
            if key not in known:
                raise Problem(f"{self.at(key)}: is no key of the map; there are {', '.join(known)}")

    def word(self, key: str, default: str | None = None) -> str:
        value = self.get(key, default)
        if not isinstance(value, str) or (default is None and not value.strip()):
            raise Problem(f"{self.at(key)}: is missing or no text; write {key} = \"...\"")
        return self._in_one_line(key, value)

    def _in_one_line(self, key: str, value: str) -> str:
        if CONTROL.search(value):
            raise Problem(f"{self.at(key)}: has a line break or another control character; write it in one line")
        return value

    def name(self, key: str) -> str:
        value = self.word(key)
        if not NAME.fullmatch(value) or value == TOGETHER:
            raise Problem(f"{self.at(key)}: '{value}' can be no name; take letters, digits, _ and -")
        return value

    def words(self, key: str) -> list[str]:
        value = self.get(key, [])
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise Problem(f"{self.at(key)}: has to be a text or a list of texts")
        return [self._in_one_line(key, one) for one in value]

    def number(self, key: str, default: float | None = None) -> float:
        value = self.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < LARGEST:
            raise Problem(f"{self.at(key)}: has to be a number")
        return float(value)

    def positive(self, key: str, default: float | None = None) -> float:
        if (value := self.number(key, default)) <= 0:
            raise Problem(f"{self.at(key)}: has to be above 0")
        return value

    def point(self, key: str) -> Points:
        return self._points(key, self.get(key), 1)

    def points(self, key: str) -> Points:
        return self._points(key, self.get(key, []), 2)

    def table(self, key: str) -> "_Table":
        value = self.get(key, {})
        if not isinstance(value, dict):
            raise Problem(f"{self.at(key)}: has to be a table")
        return _Table(self.path, f"{self.place}{key}.", value)

    def tables(self, key: str) -> list["_Table"]:
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise Problem(f"{self.at(key)}: has to be written as [[{key}]] tables")
        return [_Table(self.path, f"{self.place}{key}[{i}].", one) for i, one in enumerate(value)]

    def _points(self, key: str, value: Any, dimensions: int) -> Points:
        rows = [value] if dimensions == 1 else value
        is_right = isinstance(rows, list) and all(
            isinstance(row, list) and len(row) == 3 and all(type(one) in (int, float) and abs(one) < LARGEST for one in row) for row in rows)
        if is_right:
            return np.array(value, dtype=float).reshape((3,) if dimensions == 1 else (-1, 3))
        raise Problem(f"{self.at(key)}: has to be {'a point [x, y, z]' if dimensions == 1 else 'a list of points [x, y, z]'}")

    def direction(self, key: str) -> Points:
        found = self.point(key)
        if not np.linalg.norm(found) > 0:
            raise Problem(f"{self.at(key)}: has no length; give a direction")
        return found


def _pattern(files: _Table, kind: str, text: str) -> re.Pattern[str]:
    try:
        pattern = re.compile(text)
    except re.error as error:
        raise Problem(f"{files.at(kind)}: '{text}' is no regular expression ({error})") from None
    if "name" not in pattern.groupindex:
        raise Problem(f"{files.at(kind)}: '{text}' has no group (?P<name>...), which says what the part is called")
    return pattern


def _muscle(table: _Table) -> MuscleWords:
    table.allow_only("name", "origin", "insertion", "near_mm", "tendon")
    near = table.positive("near_mm") if table.get("near_mm") is not None else None
    tendon = None
    if table.get("tendon") is not None:
        words = table.table("tendon")
        words.allow_only("to", "at", "through", "radius_mm")
        tendon = TendonWords(words.word("to"), words.point("at"), words.points("through"), words.positive("radius_mm"))
    return MuscleWords(table.word("name"), table.words("origin"), table.words("insertion"), near, tendon)


def _joint(table: _Table) -> JointWords:
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
