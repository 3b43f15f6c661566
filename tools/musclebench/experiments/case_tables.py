"""The tables of any experiment: answers, which are the same on every machine, and times, which are not; of cases that were
timed how their frames are spread."""

import re
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from ..program.fingerprint import write_whole
from ..results.disturbance import disturbed
from ..results.run_folder import ResultProblem, Run, count_of_warnings, read_run
from ..tables.table_formats import Table, write_table
from .caveats import caveats
from .frame_spread import spread_table
from .manifest import read_manifest
from .swept_experiment import HASH_OF_MODE

MISSING, DAMAGED = "missing", "damaged"
ANSWERS, TIMES = "answers.csv", "times.csv"
REPETITION = re.compile(r"-r\d+$")
SUMS = ("contacts", "missed_contacts", "false_contacts")
LARGEST = ("max_depth_m", "p99_depth_m", "max_depth_error_m", "p99_depth_error_m")
OFFSETS = ("p99_offset_m", "p99_inward_m", "p99_outward_m", "max_offset_m")


def write_tables(out_dir: Path) -> tuple[pd.DataFrame, Table, list[Path]]:
    """Answers, spread, files. Answers and times have a row a planned case, in the order of the names, run or not."""
    plan = sorted(read_manifest(out_dir)["cases"], key=lambda case: case["name"])
    runs = {case["name"]: _read(out_dir / "raw" / case["name"]) for case in plan}
    told = disturbed({name: run.record for name, run in runs.items() if isinstance(run, Run)})
    answers = pd.DataFrame([_planned(case) | _answers(runs[case["name"]]) for case in plan])
    times = pd.DataFrame([{"name": case["name"]} | _times(runs[case["name"]]) | {"disturbed": told.get(case["name"], "")}
                          for case in plan])
    files = [out_dir / ANSWERS, out_dir / TIMES]
    for path, table in zip(files, (answers, times)):
        write_whole(path, table.to_csv(index=False))
    spread = spread_table(_repetitions(plan, runs)).with_sentence(caveats(out_dir))
    if len(spread.rows):
        return answers, spread, files + write_table(spread, out_dir)
    for old in out_dir.glob(f"{spread.name}.*"):
        old.unlink()
    return answers, spread, files


def _repetitions(plan: list[dict], runs: dict[str, Run | str]) -> dict[str, list[Run]]:
    """{case: its runs}; a case is called like its first run, without the number of the repetition."""
    found: dict[str, list[Run]] = {}
    names: dict[tuple, str] = {}
    for case in plan:
        run = runs[case["name"]]
        if isinstance(run, Run):
            key = tuple(str(value) for name, value in _planned(case).items() if name not in ("name", "repetition"))
            found.setdefault(names.setdefault(key, REPETITION.sub("", case["name"])), []).append(run)
    return found


def _read(folder: Path) -> Run | str:
    """The run, or why there is none."""
    if not (folder / "run.json").is_file():
        return MISSING
    try:
        return read_run(folder)
    except (ResultProblem, KeyError) as problem:
        return f"{DAMAGED}: {problem}"


def _planned(case: dict) -> dict:
    parameters = " ".join(f"{key}={value}" for key, value in case["parameters"].items())
    axes = " ".join(f"{key}={value}" for key, value in case["axes"].items())
    return {key: case[key] for key in ("name", "group", "mode", "scene", "preset", "backend")} | {
        "parameters": parameters, "axes": axes, "threads": case["threads"], "repetition": case["repetition"]}


def _answers(run: Run | str) -> dict:
    if isinstance(run, str):
        return {"status": run.partition(":")[0]}
    frames = run.frames
    summed = {key: _of(frames, key, lambda column: column.sum(min_count=1)) for key in SUMS}
    largest = {key: _of(frames, key, lambda column: column.max()) for key in LARGEST}
    return {"status": run.status, "hash": run.record.get(HASH_OF_MODE.get(run.mode, "")), "frames": run.record.get("frames"),
            **summed, **largest, **{key: (run.record.get("surface_offset") or {}).get(key) for key in OFFSETS},
            "structure_bytes": run.record.get("structure_bytes")}


def _times(run: Run | str) -> dict:
    if isinstance(run, str):
        return {"status": run.partition(":")[0], "status_detail": run.partition(": ")[2]}
    frames, memory = run.timed_frames, run.record.get("memory") or {}
    return {"status": run.status, "status_detail": run.record.get("status_detail", ""), "warnings": count_of_warnings(run.record),
            "median_collision_ns": frames["collision_ns"].median(),
            "median_frame_ns": _of(frames, "frame_ns", lambda column: column.median()),
            "build_ns": run.record.get("build_ns"), "wall_ns": run.record.get("wall_ns"),
            "peak_bytes": memory.get("peak_bytes")}


def _of(frames: pd.DataFrame, key: str, make: Callable) -> float:
    return make(frames[key]) if key in frames else float("nan")
