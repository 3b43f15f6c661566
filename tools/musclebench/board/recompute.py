"""Computes here the answers that bundles claim: the scene is recorded once, and each setting is asked at the recorded positions."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from ..program.cli import Problem
from ..program.registry import Registry
from .bundle import Bundle, Told

SAFE_KINDS = ("flag", "integer", "number", "choice")  # a path of a stranger is not written to
ANSWERS = ["scene", "backend", "configuration", "threads", "queries_hash", "contact_hash"]
MOST_THREADS = 64


def recompute(bundles: Sequence[Bundle], program: Path, registry: Registry, data: Path | None, longest_s: float,
              say: Callable[[str], None]) -> pd.DataFrame:
    """Rows with ANSWERS, of all settings that this program has. What takes longer than `longest_s` or is not known here is left out
    and said."""
    asked = pd.concat([bundle.rows for bundle in bundles], ignore_index=True)
    asked = asked[asked["contact_hash"] != ""].drop_duplicates(["scene", "backend", "configuration", "threads", "stride"])
    found: list[Told] = []
    left_out: list[str] = []
    with tempfile.TemporaryDirectory(prefix="musclebench-board-") as folder:
        for scene, rows in asked.groupby("scene", sort=False):
            recording = _recorded(str(scene), program, registry, data, Path(folder), say)
            for number, row in enumerate(rows.to_dict("records"), 1):
                say(f"{scene}, {row['configuration']} ({number} of {len(rows)})")
                answer = _replayed(row, recording, program, registry, Path(folder), longest_s) if recording else f"{scene} is not known here"
                if isinstance(answer, str):
                    left_out.append(answer)
                else:
                    found.append({key: row[key] for key in ANSWERS} | answer)
    for line in dict.fromkeys(left_out):
        print(f"not recomputed: {line}", file=sys.stderr)
    return pd.DataFrame(found, columns=ANSWERS)


def _recorded(scene: str, program: Path, registry: Registry, data: Path | None, folder: Path, say: Callable[[str], None]) -> Path | None:
    if not any(one.name == scene for one in registry.scenes) or (scene.startswith("lhdl/") and data is None):
        return None
    say(f"recording {scene}")
    path = folder / f"{scene.replace('/', '-')}.recording"
    words = ["record", scene, "--threads", "1", *(["--data", str(data)] if data else []), "--out", str(path)]
    done = subprocess.run([str(program), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Problem(f"{scene} can't be recorded: {(done.stderr.strip().splitlines() or ['no word'])[-1]}")
    return path


def _replayed(row: Told, recording: Path, program: Path, registry: Registry, folder: Path, longest_s: float) -> Told | str:
    """The hashes, or why there are none."""
    backend, out = registry.backend(row["backend"]), folder / "replay"
    what = f"{row['configuration']} on {row['scene']}: "
    if not registry.has(row["backend"]):
        return f"{what}backend {row['backend']} is not built here"
    if pd.isna(row["stride"]) or not (1 <= row["threads"] <= MOST_THREADS and row["stride"] >= 1):
        return f"{what}threads {row['threads']}, stride {row['stride']}"
    words = ["replay", str(recording), "--backend", row["backend"], "--threads", str(int(row["threads"])), "--stride", str(int(row["stride"])),
             "--no-referee", "--bones-only", "--force", "--out", str(out)]
    for key, value in json.loads(row["parameters"]).items():
        if backend.parameter(key).kind not in SAFE_KINDS or not isinstance(value, str):
            return f"{what}the parameter {key[:40]} is not one that a stranger may set"
        words += ["--param", f"{key}={value}"]
    try:
        done = subprocess.run([str(program), *words], capture_output=True, text=True, check=False, timeout=longest_s)
    except subprocess.TimeoutExpired:
        return f"{what}takes longer than {longest_s:g} s"
    if done.returncode != 0:
        return f"{what}{(done.stderr.strip().splitlines() or ['no word'])[-1][:200]}"
    run = json.loads((out / "run.json").read_text())
    return {"queries_hash": run["queries_hash"], "contact_hash": run["contact_hash"]}
