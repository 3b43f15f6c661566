"""Makes a bundle of results that are here, and reads it back before it is kept."""

import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from ..program.cli import Problem
from .bundle import HEADER, Bundle, write_bundle
from .made import bundle_of
from .reading import read_bundle


def is_bundle(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as file:
            return HEADER in file.namelist()
    except (OSError, zipfile.BadZipFile):
        return False


def pack(folder: Path, out: Path | None = None, licences: Mapping[str, str] | None = None, sources: Mapping[str, str] | None = None,
         with_shapes: bool = True) -> tuple[Path, Bundle]:
    """`out`: FOLDER.zip next to the folder unless told. Raises Problem where whoever gets it would refuse it."""
    out = out or folder.resolve().with_name(f"{folder.resolve().name}.zip")
    if out.exists() and not is_bundle(out):
        raise Problem(f"{out}: is there already and is no bundle; name another file with --out")
    made = bundle_of(folder, licences, sources, with_shapes)
    with tempfile.TemporaryDirectory() as scratch:
        write_bundle(made, Path(scratch) / out.name)
        read = read_bundle(Path(scratch) / out.name)
    write_bundle(made, out)
    return out, read
