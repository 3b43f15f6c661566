"""What `musclebench list --json` prints, from registry_fixture.json and the project's own studies. FAKE_REGISTRY names a
file that is printed in its place."""

from __future__ import annotations

import json
import os
import tomllib
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # stand-ins for the program start a thousand times and need neither
    from musclebench.cases.scene import Scene
    from musclebench.program.registry import Registry

NODES = {"adductor_brevis": 502, "gluteus_maximus": 9878, "gluteus_medius": 5313, "iliacus": 6931}
OWN_EFFECTS = ("damping", "attachment", "edge_length", "volume", "bending")  # of the presets
FIXTURE = Path(__file__).resolve().parent / "registry_fixture.json"
BACKENDS = Path(__file__).resolve().parents[2] / "backends"


def listed() -> dict:
    found = json.loads(FIXTURE.read_text())
    for backend in found["backends"]:
        backend["study"] = study_of(backend["name"])
    return found


def study_of(backend: str) -> dict:
    return deepcopy(_read_study(backend))


@cache
def _read_study(backend: str) -> dict:
    return tomllib.loads((BACKENDS / backend / "study.toml").read_text())


@dataclass(frozen=True)
class Roles:
    """Names of backends by what they are to an experiment."""

    control: str  # the loop without collision
    unit: str  # by whose time the others' are divided; a grid without a depth of its own
    field: str  # has a resolution, a clearance cache, and a depth
    exact: str  # with a clearance cache
    reference: str  # exact without anything that makes it fast
    choices: str  # no resolution, but many choices


@cache
def roles() -> Roles:
    backends = {backend["name"]: backend for backend in listed()["backends"]}
    parameter_roles = {name: {one["role"] for one in about["parameters"]} for name, about in backends.items()}

    def first(fits) -> str:
        return next(name for name in backends if fits(name, backends[name], parameter_roles[name]))

    return Roles(first(lambda name, about, has: about["study"].get("control")),
                 first(lambda name, about, has: "unit_of_price" in about["study"].get("advise", {})),
                 first(lambda name, about, has: {"resolution", "clearance_cache"} <= has and about["capabilities"]["depth"]),
                 first(lambda name, about, has: about["exact"] and "clearance_cache" in has),
                 first(lambda name, about, has: about["exact"] and not about["parameters"]),
                 first(lambda name, about, has: "choice" in {one["kind"] for one in about["parameters"]}
                       and not about["exact"] and "resolution" not in has))


def with_studies(studies: dict[str, dict]) -> str:
    """The same with these studies only, by the name of the backend; the others have none and are left out."""
    found = listed()
    found["backends"] = [backend | {"study": studies[backend["name"]]} for backend in found["backends"]
                         if backend["name"] in studies]
    return json.dumps(found)


def text() -> str:
    """What the fake program prints."""
    path = os.environ.get("FAKE_REGISTRY")
    return Path(path).read_text() if path else json.dumps(listed())


def registry() -> Registry:
    """Of the whole project."""
    from musclebench.program.registry import parse_registry

    return parse_registry(json.dumps(listed()), "fixture")


def survey_record(scene: str, frames: int) -> dict:
    """What a probe tells of a scene, as far as experiments ask: half of the motion there, half back."""
    motion = {"axis": [-1, 0, 0], "centre_m": [0, 0, 0], "times": [0, 1], "angles_rad": [0, 1.5708],
              "there_and_back": True}
    return {"schema_version": 2, "build": {"git": "abc"}, "machine": {"cpu": "A processor", "cores": 2},
            "case": {"scene": scene, "preset": "paper", "effects": dict.fromkeys(OWN_EFFECTS, {}),
                     "loop": {"frames": frames, "rest_frames": 0, "substeps": 3, "iterations": 1, "time_step_s": 1e-3}},
            "muscle": {"vertices": NODES.get(scene.split("/")[-1], 1000), "mesh_sha256": "00aa"},
            "bones": [{"name": "pelvis", "motion": {"angles_rad": []}}, {"name": "femur", "motion": motion}]}


def write_survey(folder: Path, scene: str, frames: int) -> None:
    folder.mkdir(parents=True)
    (folder / "run.json").write_text(json.dumps(survey_record(scene, frames)))


def names_with_many_choices() -> list[str]:
    return [backend.name for backend in registry().backends if backend.has_many_choices]


def scene(name: str, frames: int | None = None) -> Scene:
    """As a survey tells it."""
    from musclebench.cases.scene import Scene, told

    probed_on = "" if name.endswith(".toml") else f"{name.split('/')[0]}/{min(NODES)}"
    asked = Scene(name, frames_limit=frames, probed_on=probed_on, asks_preset=not name.endswith(".toml"))
    return told(asked, survey_record(name, frames or 314))


def scenes(data_set: str) -> tuple[Scene, ...]:
    return tuple(scene(f"{data_set}/{muscle}") for muscle in NODES)
