#!/usr/bin/python3
"""Searches for the largest steps and writes the table. Options: musclebench/options/safe_step.py."""

import json
import math
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd

from musclebench.cases.case import Folders
from musclebench.cases.progress import duration
from musclebench.cases.scene import Scene, chosen_names, survey
from musclebench.cases.study_command import PROJECT, end
from musclebench.options.safe_step import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import Problem, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.program.out_folder import claimed
from musclebench.program.registry import Registry, read_registry
from musclebench.safe_step.search import Limits, SafeStep, largest_safe
from musclebench.safe_step.trials import Setting, Trials
from musclebench.tables.table_formats import Column, Table, markdown_rows, write_table

FEWEST_FRAMES, MOST_FRAMES = 2, 2000
SHORTEST_STEP_S, LONGEST_STEP_S = 1e-6, 1.0
RESPONSES = ("project", "backtrack")
COLUMNS = [
    Column("backend", "backend"), Column("response", "response"), Column("guard", "guard"),
    Column("turn_deg", "largest rotation a frame (deg)", is_ratio=True, digits=3, head="rotation\ndeg"),
    Column("turn_wrong_deg", "wrong at (deg)", is_ratio=True, digits=3, head="wrong at\ndeg"),
    Column("step_ms", "largest time step (ms)", is_ratio=True, digits=3, head="time step\nms"),
    Column("step_wrong_ms", "wrong at (ms)", is_ratio=True, digits=3, head="wrong at\nms"),
    Column("why", "why not"),
]


def settings_of(options, registry: Registry) -> list[Setting]:
    # What is asked about every so many frames elsewhere would take hours here.
    names = options.backend or [one.name for one in registry.backends
                                if not one.is_control and not one.is_slow]
    for name in names:
        if not registry.has(name):
            raise Problem(f"--backend {name}: not built; there are: {', '.join(registry.names)}")
    return [Setting(name, response, guard) for name in names for response in RESPONSES for guard in (False, True)]


def searched(trials: Trials, setting: Setting, scene: Scene) -> dict:
    """A row of the table."""
    row = {"backend": setting.backend, "response": setting.response, "guard": "yes" if setting.guard else "no", "why": ""}
    try:
        usual_step_s, turn_deg = trials.usual(setting, scene.frames)

        def frames_at(step: float) -> int:
            """Steps are in those of the scene's own frames."""
            return max(FEWEST_FRAMES, round(scene.frames / step))

        turns = largest_safe(lambda step: trials.is_right(setting, frames_at(step)), 1.0,
                             Limits(scene.frames / MOST_FRAMES, scene.frames / FEWEST_FRAMES))
        steps = largest_safe(lambda step_s: trials.is_right(setting, scene.frames, step_s), usual_step_s,
                             Limits(SHORTEST_STEP_S, LONGEST_STEP_S))
    except Problem as problem:
        return row | {"why": str(problem)}
    return row | _of("turn", "deg", turns, turn_deg) | _of("step", "ms", steps, 1e3)


def _of(name: str, unit: str, found: SafeStep, scale: float) -> dict:
    return {f"{name}_{unit}": math.nan if found.largest is None else scale * found.largest,
            f"{name}_wrong_{unit}": math.nan if found.wrong_at is None else scale * found.wrong_at}


def write_steps(rows: list[dict], scene: str, path: Path) -> Path:
    """What `musclebench check` and `advise` read with --safe-step. Null: nothing was right, or nothing was seen to be wrong."""

    def known(row: dict, key: str, scale: float = 1.0) -> float | None:
        value = row.get(key, math.nan)
        return None if math.isnan(value) else scale * value

    steps = [{"backend": row["backend"], "response": row["response"], "guard": row["guard"] == "yes",
              "turn_deg": known(row, "turn_deg"), "turn_wrong_deg": known(row, "turn_wrong_deg"),
              "time_step_s": known(row, "step_ms", 1e-3), "time_step_wrong_s": known(row, "step_wrong_ms", 1e-3)}
             for row in rows]
    name = Path(scene).stem if scene.endswith(".toml") else scene
    write_whole(path, json.dumps({"schema": 1, "scene": name, "steps": steps}, indent=1) + "\n")
    return path


def run_and_report(options) -> int:
    check_options(options, "safe-step")
    registry = read_registry(options.musclebench)
    out = options.out or PROJECT / "reports" / "out" / f"safe-step-{Path(options.scene).stem}"
    folders = Folders(out.absolute(), options.data and options.data.resolve())
    name, = chosen_names([options.scene], None, "synthetic", registry)
    scene, = survey([name], options.musclebench, registry, folders, None, options.preset)
    arguments = [*(["--preset", options.preset] if options.preset else scene.preset_arguments()),
                 *scene.data_arguments(folders)]
    settings = settings_of(options, registry)
    with claimed(folders.out_dir), tempfile.TemporaryDirectory() as folder:
        trials = Trials(options.musclebench, name, arguments, Path(folder),
                        (registry.control or registry.backends[0]).name)
        return end("safe-step", write_report(search_all(trials, settings, scene), scene, name, out), [])


def search_all(trials: Trials, settings: list[Setting], scene: Scene) -> list[dict]:
    rows = []
    begun = time.monotonic()
    for done, setting in enumerate(settings):
        text = f"{done + 1} of {len(settings)}: {setting.backend}, {setting.response}, {'guard' if setting.guard else 'no guard'}"
        if done:
            seconds = (time.monotonic() - begun) / done * (len(settings) - done)
            text += f"; about {duration(seconds)} left"
        if sys.stderr.isatty():
            print(f"\r{text}\x1b[K", end="", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)
        rows.append(searched(trials, setting, scene))
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    return rows


def write_report(rows: list[dict], scene: Scene, name: str, out: Path) -> list[Path]:
    keys = [column.key for column in COLUMNS]
    table = Table("safe_step", f"Largest steps at which {scene.key} stays right: no node on the wrong side of a bone, "
                  "volume within 5 %", COLUMNS, pd.DataFrame(rows, columns=keys), keys)
    print(f"\n{table.caption}\n\n{markdown_rows(COLUMNS, table.rows)}")
    return [*write_table(table, out), write_steps(rows, name, out / "safe_step.json")]


def main(arguments=None) -> int:
    return run_command("safe-step", lambda: run_and_report(parse_arguments(arguments)), "nothing was written")


if __name__ == "__main__":
    sys.exit(main())
