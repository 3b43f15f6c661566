"""The scenes that experiments run: a name or a file, what the program tells of them, and how much of their motion."""

import difflib
import json
import math
import subprocess
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..program import fingerprint
from ..program.cli import Problem
from ..program.registry import Registry
from .case import Folders

REFERENCE_NODES = 6931  # of the muscle that guessed times are of
REFERENCE_TRIANGLES = 87_996  # of its bones
PRESET = "paper"  # of the program's own scenes of one muscle; others name theirs
SURVEY_SECONDS = 300
SAME_ANGLE_RAD = 1e-9
ORIGIN_KEYS = ("schema_version", "build", "machine")


@dataclass(frozen=True)
class Scene:
    """What all cases of a scene share. The numbers are the paper's, unless the program was asked."""

    name: str  # as the program takes it: one of its own, or the path of a .toml file
    nodes: int = REFERENCE_NODES
    triangles: int = REFERENCE_TRIANGLES  # of all bones
    frames: int = 314
    iterations: int = 3  # collision steps a frame: substeps times iterations
    substeps: int = 3
    full_flexion_frame: int = 157  # the largest angle either way
    half_flexion_frame: int = 79  # nearest to half of that turn
    preset: str = PRESET
    asks_preset: bool = True  # False: that of the scene file
    frame_time_s: float = 3e-3
    frames_limit: int | None = None  # None: as many as scene and preset have
    probed_on: str = ""  # the scene whose bones are probed for this one, too; empty: this one
    digest: str = ""  # of a scene file and what it names; the program's own scenes change with the program
    muscles: int = 1
    split_muscles: int = 0  # of its [meshes]
    smooth_bones: int = 0
    has_step_changes: bool = False  # [[time_step_change]]
    effects: tuple[str, ...] = ()  # of scene and preset
    has_long_key: bool = False  # where two scenes would share a short one
    below: str = ""  # the path of a scene file that was made for the experiment, below the experiment's folder
    origin: dict = field(default_factory=dict, compare=False)  # ORIGIN_KEYS as the program writes them into a run.json

    @property
    def is_file(self) -> bool:
        return self.name.endswith(".toml")

    @property
    def key(self) -> str:
        """Fit for a folder's name."""
        if self.is_file:
            return Path(self.name).stem
        return self.name.replace("/", "-") if self.has_long_key else self.name.split("/")[-1]

    def word(self, folders: Folders) -> str:
        """As the program is asked for it."""
        return str(folders.out_dir / self.below) if self.below else self.name

    @property
    def probed(self) -> "Scene":
        return replace(self, name=self.probed_on or self.name)

    @property
    def steps(self) -> int:
        return self.iterations * self.frames

    @property
    def size(self) -> float:
        """Nodes over those of the reference muscle."""
        return self.nodes / REFERENCE_NODES

    @property
    def bone_size(self) -> float:
        """Triangles over those of the reference bones."""
        return self.triangles / REFERENCE_TRIANGLES

    def preset_arguments(self) -> list[str]:
        return ["--preset", self.preset] if self.asks_preset else []

    def data_arguments(self, folders: Folders) -> list[str]:
        return ["--data", str(folders.data_dir)] if folders.data_dir is not None else []

    def frames_arguments(self) -> list[str]:
        return ["--frames", str(self.frames_limit)] if self.frames_limit is not None else []


def chosen_names(scenes: list[str] | None, muscles: list[str] | None, data_set: str, registry: Registry,
                 quick_muscle: str | None = None) -> list[str]:
    """Of --scene and --muscle, which together may name no scene twice; without either all of the data set that have one
    muscle, or the one that is quick."""
    known = [scene.name for scene in registry.scenes]
    of_set = [scene.name for scene in registry.scenes
              if scene.name.startswith(f"{data_set}/") and len(scene.muscles) == 1]
    names = [_named(scene, known) for scene in scenes or []]
    for muscle in muscles or []:
        if f"{data_set}/{muscle}" not in known:
            raise Problem(f"--muscle '{muscle}': no {data_set} scene has this muscle; there are: "
                          + ", ".join(name.split("/")[-1] for name in of_set))
        names.append(f"{data_set}/{muscle}")
    if not names and f"{data_set}/{quick_muscle}" in known:
        names = [f"{data_set}/{quick_muscle}"]
    names = list(dict.fromkeys(names or of_set))
    stems = [Path(name).stem for name in names if name.endswith(".toml")]
    twice = next((stem for stem in stems if stems.count(stem) > 1), None)
    if twice:
        raise Problem(f"--scene: two files are named {twice}.toml, and results go by that name; rename one")
    return names


def _named(scene: str, known: list[str]) -> str:
    if scene in known:
        return scene
    path = Path(scene)
    if path.suffix == ".toml" and path.is_file():
        return str(path.resolve())
    near = difflib.get_close_matches(scene, known, 1) or [known[0] if known else "none"]
    if path.suffix == ".toml":
        raise Problem(f"--scene {scene}: no such file")
    raise Problem(f"--scene {scene}: neither a scene of the program nor a .toml file; did you mean '{near[0]}'?")


def survey(names: list[str], program: Path, registry: Registry, folders: Folders, frames_limit: int | None = None,
           preset: str | None = None, of_files: bool = True, own_presets: bool = False) -> list[Scene]:
    """Asks the program how large each scene is and how it moves. `preset`: of all, or, not `of_files`, of the program's
    own scenes; else scene files have their own, and with `own_presets` all."""
    short = [Scene(name).key for name in names]
    of_one_muscle = {scene.name for scene in registry.scenes if len(scene.muscles) == 1}
    forced = {name for name in names if preset and (of_files or not name.endswith(".toml"))}
    scenes = [Scene(name, preset=preset if name in forced else PRESET, asks_preset=name in forced or (name in of_one_muscle and not own_presets),
                    frames_limit=frames_limit, probed_on=_probed_on(name, registry), has_long_key=short.count(key) > 1)
              for name, key in zip(names, short)]
    return [asked(scene, program, registry, folders) for scene in scenes]


def asked(scene: Scene, program: Path, registry: Registry, folders: Folders) -> Scene:
    """With what the program tells of it."""
    backend = registry.control or registry.backends[0]
    with tempfile.TemporaryDirectory() as folder:
        # The cheapest command that reads a scene and tells what it has read: one point, and no collision.
        command = [str(program), "probe", scene.name, "--backend", backend.name, "--points", "1",
                   *scene.preset_arguments(), *scene.frames_arguments(), *scene.data_arguments(folders),
                   "--out", f"{folder}/survey"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=SURVEY_SECONDS)
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise Problem(lines[-1].removeprefix("musclebench: "))
        record = json.loads((Path(folder) / "survey" / "run.json").read_text())
    return told(scene, record)


def told(scene: Scene, record: dict) -> Scene:
    loop, bones = record["case"]["loop"], record["bones"]
    motions = [rotation for bone in bones for rotation in _rotations(bone.get("motion") or {})]
    moving_frames = loop["frames"] - loop["rest_frames"]
    meshes = [part.get("mesh_sha256", "") for part in (record["muscle"], *bones)]
    digest = fingerprint.text_digest(fingerprint.file_digest(Path(scene.name)), *meshes) if scene.is_file else ""
    splits = record["case"].get("meshes") or {}
    return replace(
        scene, nodes=record["muscle"]["vertices"], split_muscles=splits.get("split_muscles", 0), smooth_bones=splits.get("smooth_bones", 0),
        has_step_changes=bool(loop.get("time_step_changes")),
        triangles=sum(bone.get("triangles", 0) for bone in bones) or REFERENCE_TRIANGLES, frames=loop["frames"],
        iterations=loop["substeps"] * loop["iterations"], substeps=loop["substeps"],
        muscles=len(record.get("muscles", [])) or 1, effects=tuple(record["case"].get("effects") or ()),
        full_flexion_frame=full_flexion_frame(motions, moving_frames),
        half_flexion_frame=half_flexion_frame(motions, moving_frames),
        preset=record["case"].get("preset") or "", digest=digest, frame_time_s=loop["substeps"] * loop["time_step_s"],
        origin={key: record[key] for key in ORIGIN_KEYS if key in record})


def _rotations(motion: dict | list[dict]) -> list[dict]:
    """A bone turns about one axis or about several."""
    return motion if isinstance(motion, list) else [motion]


def full_flexion_frame(motions: list[dict], frames: int) -> int:
    """The first frame at which a bone is turned farthest, either way; the last one where nothing turns."""
    largest = np.abs(_turns_rad(motions, frames)).max(axis=0)
    return int(np.argmax(largest >= largest.max() - SAME_ANGLE_RAD)) if largest.any() else frames


def half_flexion_frame(motions: list[dict], frames: int) -> int:
    """Of the bone that turns most: the frame before full flexion that is nearest in angle to half of its turn, the later
    of two that are equally near."""
    full, turns = full_flexion_frame(motions, frames), _turns_rad(motions, frames)
    until_full = turns[np.abs(turns[:, full]).argmax(), :full + 1]
    if not until_full.any():
        return math.ceil(full / 2)
    gaps = np.abs(until_full - (until_full[0] + until_full[-1]) / 2)
    return int(np.flatnonzero(gaps <= gaps.min() + SAME_ANGLE_RAD)[-1])


def _turns_rad(motions: list[dict], frames: int) -> np.ndarray:
    """Angles at each frame, a row a bone that turns; one of zeros where none does."""
    progress = np.arange(frames + 1) / frames
    rows = [_angles_rad(motion, progress) for motion in motions if motion.get("angles_rad")]
    return np.array(rows or [np.zeros(frames + 1)])


def _angles_rad(motion: dict, progress: np.ndarray) -> np.ndarray:
    part = 1 - np.abs(2 * progress - 1) if motion.get("there_and_back") else progress
    angles = motion["angles_rad"]
    times = motion.get("times") or np.linspace(0, 1, len(angles))
    return np.interp(times[0] + part * (times[-1] - times[0]), times, angles)


def _probed_on(name: str, registry: Registry) -> str:
    """The first scene of the same data set with the same bones: whichever muscles are asked for, cases that are
    complete stay so when others are added."""
    entry = next((scene for scene in registry.scenes if scene.name == name), None)
    if entry is None:
        return ""
    data_set = name.split("/")[0]
    return min(scene.name for scene in registry.scenes
               if scene.name.split("/")[0] == data_set and scene.bones == entry.bones)
