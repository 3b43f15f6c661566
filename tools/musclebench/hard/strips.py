"""Runs of the scenes that hard cases move, with the moments that their pictures show."""

import json
import subprocess
from pathlib import Path

import pandas as pd

from ..experiments.selection import usual_backend
from ..program.cli import Problem
from ..program.registry import Registry
from ..results.run_folder import Run, read_run

# What may be worst in a frame, in this order: the first that is there and is not the same in all frames.
WORST_BY = ("max_depth_m", "surface_depth_m", "max_edge_stretch", "contacts")


def worst_frame(frames: pd.DataFrame) -> int:
    """The number of the frame to look at."""
    for column in WORST_BY:
        values = frames[column] if column in frames else pd.Series(dtype=float)
        if values.notna().any() and values.max() > values.min():
            return int(frames["frame"][values.idxmax()])
    return int(frames["frame"].iloc[len(frames) // 2])


def run_scene(program: Path, scene: str, registry: Registry, folder: Path) -> Run:
    """At rest, in its worst frame and at its end, with an exact backend. Raises Problem."""
    backend = usual_backend(registry).name

    def run(out: Path, *more: str) -> None:
        done = subprocess.run([str(program), "run", scene, "--backend", backend, "--out", str(out), "--force", *more],
                              capture_output=True, text=True, check=False)
        if not (out / "run.json").is_file():
            raise Problem(f"{scene}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else 'no run.json'}")

    run(folder)
    frames = pd.read_csv(folder / "frames.csv")
    last = json.loads((folder / "run.json").read_text())["frames"]
    moments = sorted({0, min(worst_frame(frames), last), last})
    run(folder, "--snapshots", ",".join(map(str, moments)))
    return read_run(folder)
