"""Which files of a folder a map names, and as what."""

import re
from dataclasses import dataclass
from pathlib import Path

from ..program.cli import Problem
from .anatomy_map import AnatomyMap
from .map_table import is_name
from .mesh_file import READERS


@dataclass
class Found:
    """A mesh file and what it is."""

    path: Path
    kind: str
    name: str


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
        elif not is_name(name):
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
