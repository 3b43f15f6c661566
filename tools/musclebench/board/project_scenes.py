"""The scenes that everyone can have: those that the program carries."""

from pathlib import Path

SCENES = Path(__file__).resolve().parents[3] / "datasets" / "scenes"
KNOWN = frozenset(str(path.relative_to(SCENES).with_suffix("")) for path in SCENES.rglob("*.toml"))


def is_of_project(scene: str) -> bool:
    return scene in KNOWN
