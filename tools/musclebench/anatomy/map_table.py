"""A table of a map (TOML), which knows where it stands and refuses what it can't be in one line."""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from ..program.cli import Problem
from .surface import Points

LARGEST = 1e9  # of a number
NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")
TOGETHER = "all"  # the scene of all muscles, and so no name
CONTROL = re.compile(r"[\x00-\x1f\x7f]")


def is_name(text: str) -> bool:
    """Of a part or a joint, and so of files and in scenes."""
    return bool(NAME.fullmatch(text)) and text != TOGETHER


class MapTable:
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
        if not is_name(value):
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

    def tables_text(self, key: str) -> str:
        """TOML that scenes take as it stands; empty where there is none."""
        value = self.get(key, "")
        if not isinstance(value, str):
            raise Problem(f"{self.at(key)}: has to be a text with tables of a scene")
        try:
            tables = tomllib.loads(value)
        except tomllib.TOMLDecodeError as error:
            raise Problem(f"{self.at(key)}: is not valid TOML ({error})") from None
        if loose := [name for name, one in tables.items() if not isinstance(one, (dict, list))]:
            raise Problem(f"{self.at(key)}: '{loose[0]}' is in no table; write it below one, such as [loop]")
        return value.strip()

    def table(self, key: str) -> "MapTable":
        value = self.get(key, {})
        if not isinstance(value, dict):
            raise Problem(f"{self.at(key)}: has to be a table")
        return MapTable(self.path, f"{self.place}{key}.", value)

    def tables(self, key: str) -> list["MapTable"]:
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise Problem(f"{self.at(key)}: has to be written as [[{key}]] tables")
        return [MapTable(self.path, f"{self.place}{key}[{i}].", one) for i, one in enumerate(value)]

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
