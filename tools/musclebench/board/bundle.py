"""A bundle: one zip with what was measured, on what machine, by which program. The same content makes the same bytes."""

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ..program.fingerprint import write_whole

Told = dict[str, Any]  # a table of JSON

FORMAT = 1
HEADER, ROWS, SHAPES = "bundle.json", "rows.csv", "shapes.json"
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip knows


@dataclass(frozen=True)
class Bundle:
    """`header`: format, title, measured (date), commit, command, machine, build, state, backends and scenes, each with licence."""

    header: Told
    rows: pd.DataFrame  # columns.COLUMNS
    shapes: Told | None = None  # runs in space, as tools/page/view.js reads them
    source: str = ""  # where it was read from

    @property
    def machine(self) -> str:
        """For people: two machines may have one processor's name, so times compare within one bundle only."""
        machine, build = self.header["machine"], self.header["build"]
        cores = f", {machine['cores']} cores" if machine["cores"] else ""
        return f"{self.header['title']}: {machine['cpu']}{cores}, {build['compiler']}"


def bundle_bytes(bundle: Bundle) -> bytes:
    parts = {ROWS: bundle.rows.to_csv(index=False).encode()}
    if bundle.shapes is not None:
        parts[SHAPES] = _json(bundle.shapes)
    header = bundle.header | {"format": FORMAT, "files": {name: hashlib.sha256(data).hexdigest() for name, data in parts.items()}}
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, data in {HEADER: _json(header), **parts}.items():
            file.writestr(zipfile.ZipInfo(name, LONG_AGO), data, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def write_bundle(bundle: Bundle, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, bundle_bytes(bundle))


def _json(value: Told) -> bytes:
    return (json.dumps(value, indent=1, ensure_ascii=True, allow_nan=False) + "\n").encode()
