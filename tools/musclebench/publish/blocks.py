"""The tables that pages show, made from measured ones. A marker names one and its study: `times paper-lhdl`."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import pandas as pd

from ..budget import budget_report, substeps_table
from ..budget.sources import with_rest
from ..effects import effect_tables, guards, returns
from ..hard import hard_tables
from ..moment_arms import moment_report
from ..program.cli import Problem
from ..results.disturbance import MARK
from ..tables import (
    arm_prices, choices, difficulties, force_table, library_table, muscle_tables, outcomes, paper_tables, prices, smoothness_table,
)
from ..tables.table_formats import Column, as_ratio, markdown_rows, with_unit
from .measured import Measured
from .selection import chosen_rows, plain

TIME_KEYS = ("muscle", "backend", "collision_ms", "ratio", "paper_ratio", "fps", "missed_contacts", "false_contacts",
             "largest_depth_mm", "structure_mb")
SPLIT_KEYS = ("muscle", "update_ms", "detect_ms", "respond_ms", "ratio", "ratio_low", "ratio_high")
MEMORY_KEYS = ("muscle", "backend", "first_mb", "last_mb", "first_offset_mb", "last_offset_mb", "structure_mb",
               "paper_first_mb", "paper_last_mb", "paper_first_offset_mb", "paper_last_offset_mb")
SMOOTHNESS_KEYS = ("muscle", "backend", "nodes", "rest_deg", "roughness_deg", "over_exact", "floor_percent", "rms_mm")
PRICE_KEYS = ("muscle", "target_mm", "configuration", "time_ms", "ratio", "ratio_low", "ratio_high", "build_s",
              "structure_mb", "p99_offset_mm", "left_mm", "missed", "true")
ARM_PRICE_KEYS = ("muscle", "target_mm", "configuration", "time_ms", "ratio", "structure_mb", "arm_rms_mm", "arm_max_mm",
                  "length_rms_mm", "arm_floor_mm", "note")
ARM_ERROR_KEYS = ("muscle", "configuration", "time_ms", "arm_rms_mm", "arm_max_mm", "arm_percent", "length_rms_mm",
                  "arm_floor_mm")
MOMENT_ARM_KEYS = ("muscle", "angle_deg", "mean_mm", "active_mm", "torque_mm", "others_percent", "published_mm", "lower_mm", "upper_mm",
                   "measured_mm", "active_holds")
FORCE_ERROR_KEYS = ("muscle", "configuration", "time_ms", "torque_percent", "torque_floor_percent", "contact_percent", "pressure_percent",
                    "pressure_floor_percent", "map_percent", "map_floor_percent")
FACTOR_KEYS = ("muscle", "choice", "time_ms", "factor", "ratio", "missed", "true", "p99_offset_mm")
DIFFICULTY_KEYS = ("muscle", *difficulties.SHOWN)
OUTCOME_KEYS = ("muscle", "configuration", "node_depth_mm", "p99_surface_depth_mm", "max_volume_percent",
                "full_rms_mm", "full_hausdorff_mm", "tunnelled", "stuck", "collision_s")
DEPTH_KEYS = ("muscle", "backend", "bone_depth_mm", "bone_nodes", "muscle_depth_mm", "muscle_nodes",
              "volume_change_percent", "edge_stretch")
PAIR_KEYS = ("muscle", "backend", "detect_ms", "contacts")
RETURN_KEYS = ("muscle", "status", "added", "rms_mm", "surface_depth_mm", "tunnelled", "volume_percent", "folded_percent",
               "folded_at_end", "stretch", "own_stretch", "fibre_stretch")
GUARD_KEYS = ("muscle", "frames", "step_deg", "without", "angle", "angle_recall", "crossing", "crossing_recall")
SUBSTEP_KEYS = ("scene", "backend", "substeps", "status", "rms_mm", "p99_mm", "largest_mm", "volume_error_percent",
                "largest_depth_mm")
BUDGET_KEYS = ("scene", "source", "setting", "status", "reference", "shape_mm", "arm_mm", "volume_percent", "surface_mm", "torque_percent",
               "pressure_percent", "order", "left_mm", "halved_by", "price")
LEAST_MOVED_MM = 0.001
EFFECT_COST_KEYS = ("muscle", "effect", "own_ms", "share_percent", "added_ms", "saved_ms")
EFFECT_CHANGE_KEYS = ("muscle", "set", "status", "frame_ms", "node_depth_mm", "surface_depth_mm", "volume_percent", "folded",
                      "folded_at_rest", "tunnelled", "stretch", "shape_mm", "arm_mm")
EFFECT_PRICE_KEYS = ("muscle", "wanted", "cheapest", "time_ms", "ratio", "needs", "note")


def block(measured: Measured, specification: str) -> str:
    """`NAME STUDY [FILTERS]`"""
    name, _, rest = specification.strip().partition(" ")
    study, _, filters = rest.partition(" ")
    if name not in BLOCKS:
        raise Problem(f"generated '{specification}': no table '{name}'; there are {', '.join(BLOCKS)}")
    text, source = BLOCKS[name](measured, study, filters), measured.source(study)
    shown = {backend: whose for backend, whose in source.implementations.items() if re.search(rf"\b{re.escape(backend)}\b", text)}
    return f"{text}\n\n{replace(source, implementations=shown or source.implementations).words()}"


def _from(file_name: str, columns: list[Column], keys: tuple[str, ...]) -> Callable[[Measured, str, str], str]:
    def made(measured: Measured, study: str, filters: str) -> str:
        rows = chosen_rows(measured.table(f"{study}/{file_name}"), filters, f"{file_name} {study} {filters}")
        by_key = {column.key: column for column in with_unit(columns, measured.source(study).unit)}
        shown = [by_key[key] for key in keys if key in rows and key in by_key]
        rows = _marked(rows.assign(**{key: rows[key].map(plain) for key in ("target_mm",) if key in rows}))
        return markdown_rows(shown, rows)

    return made


def _factors(measured: Measured, study: str, filters: str) -> str:
    """`BACKEND [FILTERS]`"""
    backend, _, rest = filters.partition(" ")
    return _from(f"{backend}_factors", choices.COLUMNS, FACTOR_KEYS)(measured, study, rest)


def _marked(rows: pd.DataFrame) -> pd.DataFrame:
    """A disturbed run's mark stands at its status, which pages don't show."""
    if "status" not in rows or "backend" not in rows:
        return rows
    busy = rows["status"].astype(str).str.endswith(MARK)
    return rows.assign(backend=rows["backend"].where(~busy, rows["backend"] + MARK))


def _speed(measured: Measured, study: str, filters: str) -> str:
    rows = chosen_rows(measured.table(f"{study}/speed"), filters, f"speed {study} {filters}")
    lines = ["| what | target | measured | 95 % | held | of |", "| --- | --- | ---: | ---: | --- | --- |"]
    for _, row in rows[rows["part"].isna()].iterrows():
        interval = f"{_three(row['low'])} to {_three(row['high'])}"
        cells = [row["what"], row["target"], _three(row["measured"]), interval, row["held"], row["note"]]
        lines.append("| " + " | ".join("-" if pd.isna(cell) or cell == "" else str(cell) for cell in cells) + " |")
    return "\n".join(lines)


def _coupled(measured: Measured, study: str, filters: str) -> str:
    """Milliseconds and, in brackets, what they are over the reference; a column a muscle."""
    rows = chosen_rows(measured.table(f"{study}/study"), filters, f"coupled {study} {filters}")
    rows = rows[(rows["mode"] == "coupled") & rows["collision_ms"].notna()]
    muscles = list(dict.fromkeys(rows["muscle"]))
    unit = measured.source(study).unit
    heads = ["configuration", *(f"{muscle.replace('_', ' ')}, ms (x {unit})" for muscle in muscles)]
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * len(muscles)]
    for name in dict.fromkeys(rows["configuration"]):
        mine = rows[rows["configuration"] == name].set_index("muscle")
        cells = [f"{as_ratio(mine.loc[m, 'collision_ms'])} ({as_ratio(mine.loc[m, 'times_unit'])})"
                 if m in mine.index else "-" for m in muscles]
        lines.append(f"| `{name}` | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _budget_by_muscle(measured: Measured, study: str, filters: str) -> str:
    """How far each source moves the shape, and what its finest setting is itself off by; a column a muscle."""
    rows = chosen_rows(measured.table(f"{study}/budget"), filters, f"budget_by_muscle {study} {filters}")
    muscles = rows.drop_duplicates("scene").set_index("scene")  # the first row of each has the status of its own setting
    heads = muscles["muscle"].where(~muscles["muscle"].duplicated(keep=False), muscles.index.to_series())
    lines = ["| source of error | " + " | ".join(f"{head.replace('_', ' ')}, mm" for head in heads) + " |", "| --- |" + " ---: |" * len(heads)]
    for source in dict.fromkeys(rows["source"]):
        mine = rows[rows["source"] == source].set_index("scene")
        cells = [_moved(mine.loc[scene], status) if scene in mine.index else "-" for scene, status in muscles["status"].items()]
        lines.append(f"| {source} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _moved(row: pd.Series, own_status: str) -> str:
    """With the status of the run, where that is another than the muscle's own."""
    if pd.isna(row["shape_mm"]):
        return "-" if pd.isna(row["status"]) else str(row["status"])
    left_mm = 0.0 if pd.isna(row["left_mm"]) else row["left_mm"]
    if row["shape_mm"] + left_mm < LEAST_MOVED_MM:
        return f"below {LEAST_MOVED_MM:g}"
    text = with_rest(row["shape_mm"], left_mm)
    return text if pd.isna(row["status"]) or row["status"] == own_status else f"{text} ({row['status']})"


def _libraries(measured: Measured, study: str, filters: str) -> str:
    """Beside the study's replay, what the hard cases say; in the order of the names that a filter has."""
    rows = chosen_rows(measured.table(f"{study}/study"), filters, f"libraries {study} {filters}")
    names = filters.partition("configuration=")[2].partition(",")[0].split("|")
    rows = rows.sort_values("configuration", key=lambda column: column.map(lambda name: names.index(name) if name in names else 0),
                            kind="stable")
    columns, table = library_table.library_table(rows, measured.table("hard-synthetic/cells"))
    return markdown_rows(with_unit(columns, measured.source(study).unit), table)


def _not_held(measured: Measured, study: str, filters: str) -> str:
    """`BACKEND REFERENCE`"""
    backend, _, reference = filters.partition(" ")
    cells = measured.table(f"{study}/cells")
    unknown = [name for name in (backend, reference) if name not in set(cells["backend"])]
    if unknown:
        raise Problem(f"not_held {study} {filters}: no backend '{unknown[0]}'; there are {', '.join(dict.fromkeys(cells['backend']))}")
    return hard_tables.not_held(cells, backend, reference, texts_in="../hard_cases/cases.md")


def _frame_times(measured: Measured, study: str, filters: str) -> str:
    """The columns are the stages of the loop that the scene has."""
    rows = chosen_rows(measured.table(f"{study}/table_3_frame_times"), filters, f"frame_times {study} {filters}")
    stages = [key.removesuffix("_ms") for key in rows if key.endswith("_ms")]
    return markdown_rows([Column("backend", "backend"), *muscle_tables.stage_columns(stages)], rows)


def _hard(file_name: str, shown: Callable[[pd.DataFrame], str]) -> Callable[[Measured, str, str], str]:
    def made(measured: Measured, study: str, filters: str) -> str:
        return shown(chosen_rows(measured.table(f"{study}/{file_name}"), filters, f"{file_name} {study} {filters}"))

    return made


def _three(value: float) -> str:
    return "-" if value is None or math.isnan(value) else as_ratio(value) if value else "0"


BLOCKS: dict[str, Callable[[Measured, str, str], str]] = {
    "times": _from("table_2_times", paper_tables.TIME_COLUMNS, TIME_KEYS),
    "split": _from("table_2_times", paper_tables.TIME_COLUMNS, SPLIT_KEYS),
    "memory": _from("table_1_memory", paper_tables.MEMORY_COLUMNS, MEMORY_KEYS),
    "smoothness": _from("smoothness", smoothness_table.COLUMNS, SMOOTHNESS_KEYS),
    "frame_times": _frame_times,
    "depths": _from("table_4_depths", muscle_tables.DEPTH_COLUMNS, DEPTH_KEYS),
    "pairs": _from("table_5_pairs", muscle_tables.PAIR_COLUMNS, PAIR_KEYS),
    "prices": _from("price_list", prices.COLUMNS, PRICE_KEYS),
    "arm_prices": _from("arm_price_list", arm_prices.COLUMNS, ARM_PRICE_KEYS),
    "arm_errors": _from("arm_errors", arm_prices.ARM_COLUMNS, ARM_ERROR_KEYS),
    "force_errors": _from("force_errors", force_table.COLUMNS, FORCE_ERROR_KEYS),
    "factors": _factors,
    "difficulties": _from("contact_difficulties", difficulties.COLUMNS, DIFFICULTY_KEYS),
    "outcomes": _from("coupled_outcomes", outcomes.COLUMNS, OUTCOME_KEYS),
    "coupled": _coupled,
    "libraries": _libraries,
    "speed": _speed,
    "effect_costs": _from("effect_costs", effect_tables.COST_COLUMNS, EFFECT_COST_KEYS),
    "effect_changes": _from("effect_changes", effect_tables.CHANGE_COLUMNS, EFFECT_CHANGE_KEYS),
    "effect_prices": _from("effect_prices", effect_tables.PRICE_COLUMNS, EFFECT_PRICE_KEYS),
    "returns": _from("returns", returns.RETURN_COLUMNS, RETURN_KEYS),
    "guards": _from("guards", guards.GUARD_COLUMNS, GUARD_KEYS),
    "hard_counts": _hard("cells", hard_tables.counts),
    "hard_matrix": _hard("cells", partial(hard_tables.matrix, texts_in="hard_cases/cases.md")),
    "hard_causes": _hard("cells", partial(hard_tables.causes, texts_in="hard_cases/cases.md")),
    "hard_beyond": _hard("cells", partial(hard_tables.beyond, texts_in="cases.md")),
    "not_held": _not_held,
    "hard_unasked": _hard("cells", hard_tables.unasked),
    "hard_cases": _hard("cases", hard_tables.texts),
    "substeps": _from("substeps", substeps_table.COLUMNS, SUBSTEP_KEYS),
    "budget": _from("budget", budget_report.COLUMNS, BUDGET_KEYS),
    "budget_by_muscle": _budget_by_muscle,
    "moment_arms": _from("moment_arms", moment_report.ARM_COLUMNS, MOMENT_ARM_KEYS),
}
