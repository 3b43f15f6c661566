"""The table of targets as text, Markdown, CSV, JSON and picture."""

import json
import math
from pathlib import Path

import pandas as pd

from ..experiments.caveats import caveats
from ..figures.targets import draw_targets
from ..program.fingerprint import write_whole
from ..program.optional_packages import left_out_without
from ..program.registry import saved_registry, whose
from ..results.disturbance import disturbed, note
from ..results.run_folder import ResultProblem, implementations, read_runs
from ..program.machine import machine
from ..tables.table_formats import as_ratio

from .kernel_results import read_kernels
from .targets import Measured, Row, rows

CAPTION = (
    "Ratios are medians of values that were measured side by side: coupled runs on one thread frame by frame, after "
    "two frames of warm-up and in the same round; kernels sample by sample, interleaved in one process. Collision time "
    "is update + detect + respond. Where a row has several parts (muscles, bones, backends) it shows the worst. Spread "
    "is the 95 % bootstrap interval."
)
TITLES = ("what", "target", "measured", "95 %", "held", "")
FIELDS = ("what", "part", "target", "measured", "low", "high", "samples", "held", "note")
EMPTY = "-"


def measured_in(out_dir: Path) -> Measured:
    runs = read_runs(out_dir / "raw")
    groups = {run.record["case"]["group"]: run.record.get("status_detail", "") for run in runs
              if run.mode == "kernels" and run.status != "ok"}
    busy = disturbed({run.folder.name: run.record for run in runs})
    return Measured(runs, read_kernels(out_dir / "raw"), groups, busy)


def write_report(out_dir: Path) -> tuple[list[Row], list[Path]]:
    measured = measured_in(out_dir)
    if not measured.runs:
        raise ResultProblem(f"{out_dir / 'raw'}: holds no complete case; run tools/speed first")
    table = rows(measured, saved_registry(out_dir))
    below = note(measured.disturbed, len(measured.runs))
    below = "".join(f"\n{line}\n" for line in (whose(implementations(measured.runs)), caveats(out_dir), below) if line)
    files = {"speed.md": as_markdown(table) + below, "speed.txt": as_text(table) + below, "speed.csv": as_csv(table),
             "speed.json": as_json(table, measured)}
    for name, text in files.items():
        write_whole(out_dir / name, text)
    return table, [out_dir / name for name in files] + _drawn(table, out_dir / "figures")


def _drawn(table: list[Row], folder: Path) -> list[Path]:
    folder.mkdir(exist_ok=True)
    files: list[Path] = []
    with left_out_without("the figure"):
        files = draw_targets(pd.DataFrame(_records(table), columns=list(FIELDS)), folder / "targets")
    return files


def as_text(table: list[Row]) -> str:
    lines = [TITLES, *_cells(table)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(TITLES))]
    rule = tuple("-" * width for width in widths[:-1]) + ("",)
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip()
                     for line in [lines[0], rule, *lines[1:]]) + "\n"


def as_markdown(table: list[Row]) -> str:
    heading = "| " + " | ".join(TITLES[:-1] + ("of",)) + " |"
    lines = [CAPTION, "", heading, "| --- | --- | ---: | ---: | --- | --- |"]
    lines += ["| " + " | ".join(cells) + " |" for cells in _cells(table)]
    parts = [part for row in table if len(row.parts) > 1 for part in row.parts]
    if parts:
        lines += ["", "All parts:", "", heading, "| --- | --- | ---: | ---: | --- | --- |"]
        lines += ["| " + " | ".join(cells) + " |" for cells in _cells(parts)]
    return "\n".join(lines) + "\n"


def as_csv(table: list[Row]) -> str:
    """Full precision; a row of its own for each part."""
    return pd.DataFrame(_records(table), columns=list(FIELDS)).to_csv(index=False)


def as_json(table: list[Row], measured: Measured) -> str:
    builds = [run.record["build"] for run in measured.runs if "build" in run.record]
    whole = {"schema_version": 1, "machine": machine(), "build": builds[0] if builds else None,
             "rows": [{key: _plain(value) for key, value in record.items()} for record in _records(table)]}
    return json.dumps(whole, indent=1) + "\n"


def _records(table: list[Row]) -> list[dict]:
    records = []
    for row in table:
        records.append(_record(row.what, "", row))
        records += [_record(row.what, part.what, part) for part in row.parts]
    return records


def _record(what: str, part: str, row: Row) -> dict:
    value = row.measured
    return {"what": what, "part": part, "target": row.target, "measured": value.value, "low": value.low,
            "high": value.high, "samples": value.frames, "held": row.held, "note": row.remark}


def _plain(value):
    return None if isinstance(value, float) and math.isnan(value) else value


def _cells(table: list[Row]) -> list[tuple[str, ...]]:
    return [(row.what, row.target or EMPTY, _number(row.measured.value), _spread(row), row.held or EMPTY,
             _one_line(row.remark)) for row in table]


def _number(value: float) -> str:
    return EMPTY if math.isnan(value) else as_ratio(value)


def _spread(row: Row) -> str:
    low, high = row.measured.low, row.measured.high
    return EMPTY if math.isnan(low) or math.isnan(high) else f"{as_ratio(low)} to {as_ratio(high)}"


def _one_line(text: str) -> str:
    return " ".join(text.split())
