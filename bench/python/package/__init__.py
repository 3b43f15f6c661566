"""Scenes, collision backends and measurements of musclebench from Python. Lengths are in metres, distances negative inside.

    import musclebench
    scene = musclebench.load_scene("synthetic/iliacus")
    name = musclebench.catalogue()["backends"][-1]["name"]
    backend = musclebench.Backend(name, scene)
    contacts = backend.detect(scene.nodes, scene.poses(45))      # records: node, bone, depth_m, normal
    run = musclebench.run(scene, name)
    run.frames[["frame", "collision_ns", "max_depth_m"]]         # a data frame; reports/reading_results.md has all columns

A backend may be an object of Python. It takes part wherever a name does, and results mark it "(in Python)":

    class Balls:
        name = "balls"
        implementation = "balls 1.0, MIT"                        # whose code, version, licence
        def build(self, name, vertices, triangles):              # once a bone; returns its structure
            return Ball(vertices)

    class Ball:
        def __init__(self, vertices):
            self.middle = vertices.mean(axis=0)
            away_m = numpy.linalg.norm(vertices - self.middle, axis=1)
            self.radius_m = away_m.mean()                        # how deep a missed point may be, how far out a false one:
            self.bound_m = away_m.max() - self.radius_m, away_m.min() + self.radius_m
        def detect(self, points):                                # (n, 3), rest frame of the bone, finite
            out = points - self.middle
            away_m = numpy.linalg.norm(out, axis=1)
            inside = numpy.flatnonzero((away_m > 0) & (away_m < self.radius_m))
            return inside, self.radius_m - away_m[inside], out[inside] / away_m[inside, None]
"""

import json
import tempfile
import warnings
import weakref
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas

from . import native
from .native import Backend, Bone, InputError, Scene, UnsupportedInput
from .results.run_folder import ResultProblem, Run, read_run
from .results.snapshots import Snapshot, read_snapshots

__all__ = [
    "Backend", "Bone", "InputError", "ResultProblem", "Run", "Scene", "SceneWarning", "Snapshot", "UnsupportedInput", "catalogue", "load_scene",
    "probe", "read_run", "read_snapshots", "record", "replay", "run",
]


def catalogue() -> dict[str, Any]:
    """What this build has: backends with their parameters, effects, loop, presets and scenes (`musclebench list --json`)."""
    return dict(json.loads(native.catalogue()))


class SceneWarning(UserWarning):
    """What is odd about a scene, or what a result lacks that was asked for."""


def load_scene(scene: str | Path, *, preset: str = "", data: str | Path | None = None, loop: dict[str, Any] | None = None,
               motion: dict[str, Any] | None = None, meshes: dict[str, Any] | None = None,
               effects: dict[str, Any] | None = None, fibres: int | None = None) -> Scene:
    """Loads a scene: a name that `musclebench list` prints, or the path of a .toml file. Warns of what is odd about it.

    data: folder of the anatomical data (default: $MUSCLEBENCH_DATA). loop, motion, meshes: values over the scene's. effects: by
    name True, False (not this one) or a dict of parameters. fibres: to follow in each muscle, for lengths and moment arms (None:
    as the scene says). Raises InputError."""
    loaded = native.load_scene(scene, preset=preset, data=data, loop=loop or {}, motion=motion or {}, meshes=meshes or {},
                               effects=effects or {}, fibres=fibres)
    for text in loaded.warnings:
        warnings.warn(text, SceneWarning, stacklevel=2)
    return loaded


def run(scene: Scene, backend: str | object, parameters: dict[str, Any] | None = None, *, out: str | Path | None = None,
        threads: int = 1, response: str = "", colliders: Iterable[str] = (), snapshots: Iterable[int] = (), judge: bool = True,
        forces: bool = False, force: bool = False) -> Run:
    """Runs a scene with one backend and judges the result, as `musclebench run` does.

    out: result folder, in which another case is only replaced with force=True. None: one that goes with the returned Run.
    response, colliders: as --response and --for. snapshots: frames (0: rest) whose shapes `read_snapshots` gives.
    Returns a Run: status, frames (a data frame, a row a frame), record (run.json), and pairs, muscles, fibres, forces where
    the scene has them. A status that is not "ok" is explained in record["status_detail"]. Raises InputError."""
    with _Folder(out) as folder:
        native.run(scene, backend, folder.path, parameters, threads=threads, response=response, colliders=list(colliders),
                   snapshots=list(snapshots), judge=judge, forces=forces, force=force)
        done = folder.read()
    told = done.record.get("forces", {})
    lacks = {"fibres": done.record.get("fibres_refused"), "forces of contacts": told.get("contacts_left_out"),
             "forces of attachments": told.get("attachments_left_out")}
    added = [warning["text"] for warning in done.record["warnings"][len(scene.warnings):]]
    for text in [f"no {what}: {why}" for what, why in lacks.items() if why] + added:
        warnings.warn(text, SceneWarning, stacklevel=2)
    return done


def record(scene: Scene, out: str | Path, backend: str | object | None = None, parameters: dict[str, Any] | None = None, *,
           threads: int = 1) -> Path:
    """Runs a scene and stores the input of every collision step in the file `out`, for `replay`. backend: None is an exact one.
    Raises InputError; RuntimeError where the run diverges."""
    native.record(scene, Path(out), backend, parameters, threads=threads)
    return Path(out)


def replay(recording: str | Path, backend: str | object, parameters: dict[str, Any] | None = None, *,
           out: str | Path | None = None, threads: int = 1, data: str | Path | None = None, stride: int = 1, judge: bool = True,
           force: bool = False) -> Run:
    """Feeds a recording to a backend, and measures its time and its errors against the truth at the same positions.

    stride: every so many-th frame. data: folder of the anatomical data. Otherwise as `run`; record["accuracy"] and
    record["surface_offset"] have the errors over all frames."""
    with _Folder(out) as folder:
        native.replay(Path(recording), backend, folder.path, parameters, threads=threads, data="" if data is None else str(data), stride=stride,
                      judge=judge, force=force)
        return folder.read()


def probe(scene: Scene, backend: str | object, parameters: dict[str, Any] | None = None, *, points: int = 20_000,
          threads: int = 1) -> pandas.DataFrame:
    """Asks a backend about points within 2 mm of each bone's surface. A row a bone and kind of region: depth errors in metres,
    and points on the wrong side."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "probe"
        if native.probe(scene, backend, out, parameters, threads=threads, points=points) != "ok":
            raise UnsupportedInput(json.loads((out / "run.json").read_text())["status_detail"])
        return pandas.read_csv(out / "probe.csv")


class _Folder:
    """Where a result goes: the user's folder, or one that lives as long as what is read of it."""

    def __init__(self, out: str | Path | None):
        self.kept = tempfile.TemporaryDirectory() if out is None else None
        self.path = Path(self.kept.name) / "run" if self.kept else Path(str(out))

    def __enter__(self) -> "_Folder":
        return self

    def __exit__(self, kind: type | None, *_: object) -> None:
        if kind and self.kept:
            self.kept.cleanup()

    def read(self) -> Run:
        done = read_run(self.path)
        if self.kept:
            weakref.finalize(done, self.kept.cleanup)
        return done
