"""The tables and figures that a study wrote; those of an earlier report that the last one has no more are removed."""

import json
from collections.abc import Iterable
from pathlib import Path

from ..program.fingerprint import write_whole

FILE_NAME = "written.json"
FOLDERS = ("tables", "figures")


def forget_old_files(out_dir: Path, files: Iterable[Path]) -> None:
    """`files`: of the report that was just made. Only what a report noted is removed, never what others put there."""
    written = sorted(name for path in files if (name := _name_in(out_dir, path)))
    for name in set(_noted(out_dir)) - set(written):
        (out_dir / name).unlink(missing_ok=True)
    write_whole(out_dir / FILE_NAME, json.dumps(written, indent=1) + "\n")


def _name_in(out_dir: Path, path: Path) -> str:
    """Empty for a file elsewhere."""
    path = Path(path).absolute()
    inside = path.is_relative_to(out_dir) and path.relative_to(out_dir).parts[0] in FOLDERS
    return path.relative_to(out_dir).as_posix() if inside else ""


def _noted(out_dir: Path) -> list[str]:
    try:
        told = json.loads((out_dir / FILE_NAME).read_text())
    except (OSError, ValueError):
        return []
    return [name for name in told if isinstance(name, str) and _name_in(out_dir, out_dir / name) and ".." not in name.split("/")]
