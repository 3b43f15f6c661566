"""The scenes that everyone can have: those that the program carries."""

from ..cases.project_scenes import project_scenes

KNOWN = frozenset(project_scenes())


def is_of_project(scene: str) -> bool:
    return scene in KNOWN
