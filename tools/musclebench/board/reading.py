"""Reads bundles that strangers send. What is not exactly as it should be is refused in one line."""

import csv
import hashlib
import io
import json
import math
import re
import zipfile
import struct
import zlib
from datetime import date, timedelta
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd

from ..program.cli import Problem
from .bundle import FORMAT, HEADER, ROWS, SHAPES, Bundle, Told
from .columns import COLUMNS, HASH, MOST_CHARACTERS, NAME, NAMES, STATUSES, Column

LARGEST_ZIP = 16_000_000  # bytes
LARGEST_PARTS = {HEADER: 200_000, ROWS: 5_000_000, SHAPES: 4_000_000}
MOST_ROWS = 5_000
LARGEST_NUMBER = 1e15
MOST_COUNT = 2**53  # a browser's numbers are whole up to here
DEEPEST = 12  # tables in tables
MOST_LEAVES = 300_000  # of JSON
MOST_IN_A_KEY = 160  # characters
TEXTS = ("title", "measured", "commit", "command")
TABLES = {"machine": ("cpu", "cores"), "build": ("compiler", "flags")}
ABOUT: dict[str, tuple[str, ...]] = {"backends": ("implementation", "source", "licence"), "scenes": ("licence",)}
Cell = str | float | int | bool
# What has no sign, turns the direction of a text, or is half a character.
CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ud800-\udfff\ufeff]")
MARKUP = re.compile("[<>&\"`]")  # a browser gets shapes as they are
VALUE = re.compile(r"[A-Za-z0-9 _.+-]{0,80}")  # of a parameter
NUMBER = re.compile(r"[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?", re.IGNORECASE)


def read_bundle(path: Path) -> Bundle:
    """Raises Problem with the file, the place and what is wrong."""
    try:
        parts = _parts(path)
        header = _json(parts[HEADER], HEADER)
        _check_header(header)
        for name, data in parts.items():
            if name != HEADER and header["files"].get(name) != hashlib.sha256(data).hexdigest():
                raise Problem(f"{name} is not the one that {HEADER} names (sha256)")
        rows = _rows(parts[ROWS])
        _check_told(header, rows)
        shapes = _shapes(parts[SHAPES], header) if SHAPES in parts else None
        return Bundle(header, rows, shapes, str(path))
    except Problem as problem:
        raise Problem(f"{path}: {problem}; ask whoever sent it for one of tools/bundle") from None


def _parts(path: Path) -> dict[str, bytes]:
    try:
        if path.stat().st_size > LARGEST_ZIP:
            raise Problem(f"has more than {LARGEST_ZIP / 1e6:g} MB")
        with zipfile.ZipFile(path) as file:
            names = [info.filename for info in file.infolist()]
            if strange := sorted(set(names) - set(LARGEST_PARTS)):
                raise Problem(f"holds {strange[0][:80]!r}, and only {', '.join(LARGEST_PARTS)} belong into it")
            if len(names) != len(set(names)):
                raise Problem("holds a file twice")
            if any(info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1 for info in file.infolist()):
                raise Problem("is packed in a way that no bundle is (encrypted, or not deflated)")
            if missing := {HEADER, ROWS} - set(names):
                raise Problem(f"lacks {sorted(missing)[0]}")
            return {name: _unpacked(file, name) for name in names}
    except OSError as problem:
        raise Problem(f"can't be read ({problem.strerror or problem})") from None
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, ValueError, OverflowError, struct.error) as problem:
        raise Problem(f"is no zip that can be read ({problem})") from None


def _unpacked(file: zipfile.ZipFile, name: str) -> bytes:
    """What the zip says of its own sizes may be a lie."""
    with file.open(name) as part:
        data = part.read(LARGEST_PARTS[name] + 1)
    if len(data) > LARGEST_PARTS[name]:
        raise Problem(f"{name} has more than {LARGEST_PARTS[name] / 1e6:g} MB")
    return data


def _json(data: bytes, name: str) -> Told:
    def refuse(word: str) -> None:
        raise Problem(f"{name} holds {word}, which is no number")

    try:
        told: Told = json.loads(data.decode(), parse_constant=refuse)
    except (ValueError, RecursionError) as problem:
        raise Problem(f"{name} is not JSON ({str(problem)[:80]})") from None
    if not isinstance(told, dict):
        raise Problem(f"{name} is not a table of keys")
    for count, (key, value, depth) in enumerate(_leaves(told, name, 0)):
        if depth > DEEPEST:
            raise Problem(f"{name} has tables in tables deeper than {DEEPEST}")
        if count > MOST_LEAVES or len(key) > MOST_IN_A_KEY:
            raise Problem(f"{name} has more than {MOST_LEAVES} values, or a key of more than {MOST_IN_A_KEY} characters")
        if isinstance(value, (int, float)) and not abs(value) < LARGEST_NUMBER:
            raise Problem(f"{name}, {key[:80]!r}, is no number")
        if CONTROL.search(key) or (isinstance(value, str) and CONTROL.search(value)):
            raise Problem(f"{name}, {key[:80]!r}, has control characters")
    return told


def _shapes(data: bytes, header: Told) -> Told:
    """Their numbers are a browser's to read: what it can't draw stays on the page of that scene."""
    told = _json(data, SHAPES)
    for scene, about in told.items():
        if scene not in header["scenes"] or not isinstance(about, dict) or set(about) != {"scenes", "meshes"}:
            raise Problem(f"{SHAPES} tells of {scene[:60]!r}, which is no scene of the bundle")
        runs = about["scenes"]
        if not isinstance(runs, list) or not runs or not isinstance(runs[0], dict) or not NAME.fullmatch(str(runs[0].get("muscle"))):
            raise Problem(f"{SHAPES}, {scene[:60]}: lacks its muscle")
    if strange := next((value for _, value, _ in _leaves(told, SHAPES, 0) if isinstance(value, str) and MARKUP.search(value)), None):
        raise Problem(f"{SHAPES} holds markup: {strange[:60]!r}")
    return told


def _leaves(value: object, key: str, depth: int) -> Iterator[tuple[str, object, int]]:
    """With the key under which each stands."""
    yield key, value, depth
    if depth > DEEPEST:
        return
    if isinstance(value, dict):
        for name, one in value.items():
            yield from _leaves(one, name, depth + 1)
    elif isinstance(value, list):
        for one in value:
            yield from _leaves(one, key, depth + 1)


def _check_header(header: Told) -> None:
    if header.get("format") != FORMAT:
        raise Problem(f"{HEADER} has format {str(header.get('format'))[:20]}, and this tool reads {FORMAT}")
    for key in TEXTS:
        _check_text(header, key)
    try:
        is_past = date.fromisoformat(header["measured"]) <= date.today() + timedelta(days=1)  # anywhere on earth
    except ValueError:
        is_past = False
    if not is_past:
        raise Problem(f"{HEADER}, measured: {header['measured'][:20]!r} is no date of the past, like 2026-11-30")
    for table in (*TABLES, "state", "backends", "scenes", "files"):
        if not isinstance(header.get(table), dict):
            raise Problem(f"{HEADER} lacks the table {table!r}")
        for key in TABLES.get(table, ()):
            if key == "cores" and _is_count(header[table].get(key)):
                continue
            _check_text(header[table], key, f"{table}.")
    for table, keys in ABOUT.items():
        for name, about in header[table].items():
            if not NAME.fullmatch(name) or not isinstance(about, dict):
                raise Problem(f"{HEADER}, {table}: {name[:60]!r} is no name")
            for key in keys:
                _check_text(about, key, f"{table}.{name}.")


def _check_text(table: Told, key: str, where: str = "") -> None:
    value = table.get(key)
    if not isinstance(value, str) or not value or len(value) > MOST_CHARACTERS:
        raise Problem(f"{HEADER} lacks {where}{key}, a text of at most {MOST_CHARACTERS} characters")


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MOST_COUNT


def _rows(data: bytes) -> pd.DataFrame:
    try:
        lines = csv.reader(io.StringIO(data.decode()), strict=True)
        heads: list[str] = next(lines, [])
        if heads != list(NAMES):
            wrong = sorted(set(heads) ^ set(NAMES))
            raise Problem(f"{ROWS} has other columns than format {FORMAT} ({wrong[0][:60] if wrong else 'their order'})")
        rows = []
        for number, cells in enumerate(lines, 2):
            if number > MOST_ROWS + 1:
                raise Problem(f"{ROWS} has more than {MOST_ROWS} rows")
            if len(cells) != len(NAMES):
                raise Problem(f"{ROWS}, line {number}, has {len(cells)} cells, not {len(NAMES)}")
            rows.append([_value(column, cell, number) for column, cell in zip(COLUMNS, cells)])
    except (csv.Error, UnicodeDecodeError) as problem:
        raise Problem(f"{ROWS} is no table ({problem})") from None
    if not rows:
        raise Problem(f"{ROWS} has no row")
    table = pd.DataFrame(rows, columns=list(NAMES))
    for keys in (["scene", "backend", "configuration", "threads"], ["scene", "backend", "parameters", "threads"]):
        if table.duplicated(keys).any():
            raise Problem(f"{ROWS} has a configuration twice")
    return table


def _value(column: Column, cell: str, line: int) -> Cell:
    if cell == "":
        if column.is_required:
            raise Problem(f"{ROWS}, line {line}, lacks {column.name}")
        return False if column.kind == "flag" else "" if column.kind in ("name", "text", "status", "hash") else math.nan
    try:
        return _READ[column.kind](column, cell)
    except ValueError:
        raise Problem(f"{ROWS}, line {line}, {column.name}: {cell[:60]!r} is no {column.kind}") from None


def _of(is_right: object, value: Cell) -> Cell:
    if not is_right:
        raise ValueError
    return value


def _are_parameters(told: object) -> bool:
    return isinstance(told, dict) and all(NAME.fullmatch(key) and isinstance(value, str) and VALUE.fullmatch(value) for key, value in told.items())


def _number(column: Column, cell: str) -> Cell:
    """A time is more than nothing."""
    value = float(_of(NUMBER.fullmatch(cell), cell))
    least = 0.0 if not column.name.endswith("_ms") else 1e-9
    return _of(least <= value < 1e15, value)


_READ: dict[str, Callable[[Column, str], Cell]] = {
    "name": lambda column, cell: _of(NAME.fullmatch(cell), cell),
    "text": lambda column, cell: _of(len(cell) <= MOST_CHARACTERS and not CONTROL.search(cell)
                                     and (column.name != "parameters" or _are_parameters(json.loads(cell))), cell),
    "status": lambda column, cell: _of(cell in STATUSES, cell),
    "hash": lambda column, cell: _of(HASH.fullmatch(cell), cell),
    "count": lambda column, cell: _of(NUMBER.fullmatch(cell) and float(cell).is_integer() and 0 <= float(cell) <= MOST_COUNT, int(float(cell))),
    "number": _number,
    "flag": lambda column, cell: _of(cell in ("True", "False"), cell == "True"),
}


def _check_told(header: Told, rows: pd.DataFrame) -> None:
    """Every backend and scene of the rows has its licence; an interval holds its median."""
    for table, column in (("backends", "backend"), ("scenes", "scene")):
        if missing := sorted(set(rows[column]) - set(header[table])):
            raise Problem(f"{HEADER}, {table}, does not tell of {missing[0][:60]}")
    for name in ("time_ms", "own_ms"):
        low, value, high = rows[f"{name}_low"], rows[name], rows[f"{name}_high"]
        if ((low > value) | (value > high) | (value.isna() & (low.notna() | high.notna()))).any():
            raise Problem(f"{ROWS}: {name} lies outside its interval")
