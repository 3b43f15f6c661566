"""What accuracy costs: the Pareto pictures, one muscle at a time, and the price lists."""

import re
from pathlib import Path

import pandas as pd

from ..accuracy.front import EXACT_MM
from ..experiments.manifest import FILE_NAME, read_manifest
from ..results.disturbance import note
from ..results.status import MEASURED
from .looks_of import looks_of_names
from .parts import Chart, Section
from .written import caption_of, pareto_chart, read_rows, written_table

REPETITION = re.compile(r"-r\d+:")  # at the end of a case's name
PARETO = (
    ("pareto_replay", "surface offset, 99th percentile (mm)", "exact"),
    ("pareto_coupled", "remaining depth, 99th percentile (mm)", "none left"),
    ("pareto_coupled_shape", "distance to exact shape, RMS (mm)", "same shape"),
    ("pareto_moment_arm", "moment arm off by, RMS (mm)", "same arm"),
    ("pareto_torque", "joint torque off by, RMS (%)", "same"),
    ("pareto_pressure", "peak contact pressure off by, RMS (%)", "same"),
    ("pareto_map", "pressure over bones off by, RMS (%)", "same"),
)
TABLES = (
    ("price_list", "Price list: what a surface offset costs"),
    ("arm_price_list", "Price list: what an error of the moment arm costs"),
    ("coupled_outcomes", "Each backend moving its own muscle"),
    ("arm_errors", "Moment arms and fibre lengths"),
    ("force_errors", "Joint torque, contact force and pressure"),
)


def is_accuracy(folder: Path) -> bool:
    return (folder / "accuracy.csv").is_file()


def accuracy_section(folder: Path) -> Section:
    figures, tables = folder / "figures", folder / "tables"
    charts = [chart for name, title, exact in PARETO for chart in pareto_chart(figures, name, title, EXACT_MM, exact)]
    made = [part for name, title in TABLES for part in written_table(tables, name, title)]
    known = {name for name, _ in TABLES}
    for path in sorted(tables.glob("*.csv")):
        if path.stem not in known:
            made += written_table(tables, path.stem, path.stem.replace("_", " ").capitalize())
    cases = read_rows(folder / "accuracy.csv")
    what, problems = what_was_run(folder, cases, figures), problems_of(cases)
    return Section("accuracy", "What accuracy costs", what, problems, [*charts[:1], *made[:1], *charts[1:], *made[1:]],
                   looks_of_names(backends_of(charts)), folder)


def backends_of(charts: list[Chart]) -> set[str]:
    return {name for chart in charts for name in chart.rows["backend"]}


def what_was_run(folder: Path, cases: pd.DataFrame, figures: Path) -> list[tuple[str, str]]:
    counts = cases["status"].value_counts()
    told = [("Runs", f"{len(cases)}: " + ", ".join(f"{count} {status}" for status, count in counts.items())),
            ("What and on what", caption_of(figures, "pareto_replay")[-1]),
            ("Scenes", ", ".join(cases["scene"].unique()))]
    if not (folder / FILE_NAME).is_file():
        return told  # merged from parts, or its plan is gone
    plan = read_manifest(folder)
    told.append(("Begun", plan.get("started", "unknown")))
    is_quick = "--quick" in plan.get("command_line", [])
    return told + ([("Quick", "fewer configurations, frames and repetitions than the study has")] if is_quick else [])


def problems_of(cases: pd.DataFrame) -> list[str]:
    """Failed cases first, then those that are suspect, each with its reason; repetitions with the same one count once."""
    told = cases[cases["status"] != "ok"].sort_values("status", key=lambda status: status.isin(MEASURED), kind="stable")
    lines = [f"{row.case}: {row.status}, {row.status_detail}" for row in told.itertuples()]
    reasons = list({REPETITION.sub(":", line): line for line in reversed(lines)}.values())[::-1]
    busy = cases.dropna(subset=["disturbance"]).set_index("case")["disturbance"].to_dict()
    return [*reasons, *([note(busy, len(cases))] if busy else [])]
