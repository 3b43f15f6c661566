"""Computes here the answers that bundles claim: the scene is recorded once, each setting is asked at the recorded positions, and
the Referee judges its answers."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from ..accuracy.aggregates import number
from ..accuracy.configurations import configuration
from ..program.registry import Registry
from ..tables.difficulties import TITLES
from .bundle import Bundle, Told
from .standing import KEY

SAFE_KINDS = ("flag", "integer", "number", "choice")  # a path of a stranger is not written to
MOST_THREADS = 64
RECORD_SECONDS = 1800.0


@dataclass(frozen=True)
class Limits:
    longest_s: float  # of one setting
    within_s: float  # of all


def recompute(bundles: Sequence[Bundle], program: Path, registry: Registry, data: Path | None, limits: Limits,
              say: Callable[[str], None]) -> pd.DataFrame:
    """Rows of what this program answers, of all settings that it has. What takes too long or is not known here is left out and
    said."""
    program, end = program.resolve(), time.monotonic() + limits.within_s
    asked = pd.concat([bundle.rows for bundle in bundles], ignore_index=True)
    asked = asked[asked["contact_hash"] != ""].drop_duplicates(KEY)
    found: list[Told] = []
    left_out: list[str] = []
    with tempfile.TemporaryDirectory(prefix="musclebench-board-") as folder:
        for scene, rows in asked.groupby("scene", sort=False):
            recording = _recorded(str(scene), program, registry, data, Path(folder), say)
            for count, row in enumerate(rows.to_dict("records"), 1):
                if time.monotonic() > end:
                    left_out.append(f"what would take more than {limits.within_s / 60:g} min in all")
                    break
                say(f"{scene}, {row['configuration']} ({count} of {len(rows)})")
                answer = _replayed(row, recording, program, registry, Path(folder), limits.longest_s) if isinstance(recording, Path) else recording
                if isinstance(answer, str):
                    left_out.append(answer)
                else:
                    found.append({key: row[key] for key in KEY} | answer)
    for line in dict.fromkeys(left_out):
        print(f"not recomputed: {line}", file=sys.stderr)
    return pd.DataFrame(found) if found else pd.DataFrame(columns=[*KEY, "contact_hash"])


def _recorded(scene: str, program: Path, registry: Registry, data: Path | None, folder: Path, say: Callable[[str], None]) -> Path | str:
    """The recording, or why there is none."""
    if not any(one.name == scene for one in registry.scenes):
        return f"{scene} is not a scene of this program"
    if scene.startswith("lhdl/") and data is None:
        return f"{scene} needs --data"
    say(f"recording {scene}")
    path = folder / f"{scene.replace('/', '-')}.recording"
    words = ["record", scene, "--threads", "1", *(["--data", str(data)] if data else []), "--out", str(path)]
    done = _called(program, words, RECORD_SECONDS)
    return done if isinstance(done, str) else path


def _called(program: Path, words: list[str], longest_s: float) -> str | None:
    """Why it did not end well."""
    try:
        done = subprocess.run([str(program), *words], capture_output=True, text=True, check=False, timeout=longest_s)
    except subprocess.TimeoutExpired:
        return f"{words[0]} takes longer than {longest_s:g} s"
    except (OSError, ValueError) as problem:
        return f"{words[0]} can't be started ({problem})"
    return None if done.returncode == 0 else (done.stderr.strip().splitlines() or ["no word"])[-1][:200]


def _replayed(row: Told, recording: Path, program: Path, registry: Registry, folder: Path, longest_s: float) -> Told | str:
    """The answers' hashes and errors, or why there are none."""
    backend, out = registry.backend(row["backend"]), folder / "replay"
    what = f"{row['configuration']} on {row['scene']}: "
    if not registry.has(row["backend"]):
        return f"{what}backend {row['backend']} is not built here"
    if pd.isna(row["stride"]) or not (1 <= row["threads"] <= MOST_THREADS and row["stride"] >= 1):
        return f"{what}threads {row['threads']}, stride {row['stride']}"
    words = ["replay", str(recording), "--backend", row["backend"], "--threads", str(int(row["threads"])), "--stride", str(int(row["stride"])),
             "--bones-only", "--force", "--out", str(out)]
    parameters = json.loads(row["parameters"])
    for key, value in parameters.items():
        if backend.parameter(key).kind not in SAFE_KINDS or not isinstance(value, str):
            return f"{what}the parameter {key[:40]} is not one that a stranger may set"
        words += ["--param", f"{key}={value}"]
    if failed := _called(program, words, longest_s):
        return what + failed
    try:
        run = json.loads((out / "run.json").read_text())
    except (OSError, ValueError) as problem:
        return f"{what}its run.json can't be read ({problem})"
    if not isinstance(run, dict) or not run.get("queries_hash") or not run.get("contact_hash"):
        return f"{what}the program is older than these tools"
    chosen = configuration(backend, parameters, int(row["threads"]))
    return {"configuration": chosen.name, "spoken": chosen.spoken} | _answers(run)


def _answers(run: Told) -> Told:
    """In a bundle's columns."""
    kinds = {told["difficulty"]: 1e3 * number(told, "p99_offset_m") for told in (run.get("surface_offset") or {}).get("of_difficulties", []) if told["sites"]}
    return {
        "queries_hash": run["queries_hash"], "contact_hash": run["contact_hash"],
        "sites": number(run, "surface_offset", "sites"), "open_sites": number(run, "surface_offset", "open_sites"),
        "true_contacts": number(run, "accuracy", "true_contacts"),
        "offset_mm": 1e3 * number(run, "surface_offset", "p99_offset_m"), **{f"{kind}_mm": kinds.get(kind, float("nan")) for kind in TITLES},
        "missed_mm": 1e3 * number(run, "accuracy", "max_missed_depth_m"), "false_mm": 1e3 * number(run, "accuracy", "max_false_distance_m"),
        "declared_missed_mm": 1e3 * number(run, "declared", "missed_depth_m"), "declared_false_mm": 1e3 * number(run, "declared", "false_distance_m"),
    }
