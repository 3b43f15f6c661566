"""The scenes that everyone can have: those that the program carries."""

from pathlib import Path

DATASETS = Path(__file__).resolve().parents[3] / "datasets"
FOLDERS = (DATASETS / "scenes", DATASETS / "ankle" / "scenes")
KNOWN = frozenset(str(path.relative_to(folder).with_suffix("")) for folder in FOLDERS for path in folder.rglob("*.toml"))


def is_of_project(scene: str) -> bool:
    return scene in KNOWN
