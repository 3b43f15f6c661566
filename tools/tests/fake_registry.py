"""What `musclebench list --json` prints, from registry_fixture.json and the project's own studies. FAKE_REGISTRY names a
file that is printed in its place."""

import json
import os
import tomllib
from pathlib import Path

from musclebench.program.registry import Registry, parse_registry

FIXTURE = Path(__file__).resolve().parent / "registry_fixture.json"
BACKENDS = Path(__file__).resolve().parents[2] / "backends"


def told() -> dict:
    listed = json.loads(FIXTURE.read_text())
    for backend in listed["backends"]:
        backend["study"] = study_of(backend["name"])
    return listed


def study_of(backend: str) -> dict:
    return tomllib.loads((BACKENDS / backend / "study.toml").read_text())


def with_studies(studies: dict[str, dict]) -> str:
    """The same with these studies only, by the name of the backend; the others have none and are left out."""
    listed = told()
    listed["backends"] = [backend | {"study": studies[backend["name"]]} for backend in listed["backends"]
                          if backend["name"] in studies]
    return json.dumps(listed)


def text() -> str:
    """What the fake program prints."""
    path = os.environ.get("FAKE_REGISTRY")
    return Path(path).read_text() if path else json.dumps(told())


def registry() -> Registry:
    """Of the whole project."""
    return parse_registry(json.dumps(told()), "fixture")
