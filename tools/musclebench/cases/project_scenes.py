"""The scene files that the program carries, by the names that `musclebench list` tells."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[3]
FOLDERS = (PROJECT / "datasets" / "scenes", PROJECT / "datasets" / "ankle" / "scenes")


def project_scenes() -> dict[str, Path]:
    found = {path.relative_to(folder).with_suffix("").as_posix(): path for folder in FOLDERS for path in folder.rglob("*.toml")}
    return found | {f"effects/{path.parent.name}": path for path in (PROJECT / "core" / "effects").glob("*/scene.toml")}
