"""Errors of moment arms of each configuration, and their price list: for each error the cheapest that holds it."""

import math

import pandas as pd

from ..accuracy.aggregates import Aggregate, name_of_unit
from ..accuracy.arm_errors import RULE
from ..accuracy.front import ALL_MUSCLES
from ..results.disturbance import MARK
from .prices import cost_of, on_all, price_rows
from .table_formats import Column, Table, with_unit

TARGETS_MM = (5.0, 2.0, 1.0, 0.5)
COLUMNS = [
    Column("muscle", "muscle"), Column("target_mm", "holds (mm)"), Column("configuration", "cheapest"),
    Column("time_ms", "ms a frame", 3, "ms a\nframe"), Column("ratio", "x {unit}", 2, "x\n{unit}", True),
    Column("ratio_low", "95 % low", 2, "95 %\nlow", True), Column("ratio_high", "95 % high", 2, "95 %\nhigh", True),
    Column("structure_mb", "structures MB", 2, "MB"), Column("arm_rms_mm", "moment arm, RMS mm", 2, "arm\nRMS mm"),
    Column("arm_max_mm", "moment arm, largest mm", 2, "largest\nmm"),
    Column("length_rms_mm", "fibre length, RMS mm", 2, "length\nRMS mm"),
    Column("arm_floor_mm", "floor of the moment arm mm", 2, "floor\nmm"), Column("note", "note"),
]
SHOWN = [column.key for column in COLUMNS if column.key not in ("muscle", "note", "ratio_low", "ratio_high")]
ERRORS = ("arm_rms_mm", "arm_max_mm", "length_rms_mm", "arm_floor_mm")


def arm_price_list(armed: list[Aggregate], errors: dict, wrong: set) -> Table:
    """`errors` as accuracy.arm_errors gives them; `wrong`: pairs (scene, configuration) that don't count."""
    able = [one for one in armed if one.is_shown and one.configuration.threads == 1
            and (one.scene, one.configuration) in errors and (one.scene, one.configuration) not in wrong
            and not math.isnan(one.collision_ms.value)]
    scenes = list(dict.fromkeys(one.scene for one in able))
    rows = []
    for scene in scenes:
        offers = [_offer([one], armed, errors) for one in able if one.scene == scene]
        rows += _with_floor(price_rows(scene.split("/")[-1], offers, TARGETS_MM, "arm_rms_mm"), offers)
    if len(scenes) > 1:
        offers = [_offer(group, armed, errors) for group in on_all(able, scenes)]
        rows += _with_floor(price_rows(ALL_MUSCLES, offers, TARGETS_MM, "arm_rms_mm"), offers)
    caption = (
        "Price list of moment arms. For each error the fastest configuration whose muscle has the exact run's moment arm to "
        "within that (RMS over the motion); of those whose intervals overlap the fastest one's, the one with the fewest "
        f"bytes. {RULE} Times are of collision in coupled runs, as a multiple of {name_of_unit(armed)}."
    )
    columns = with_unit(COLUMNS, name_of_unit(armed))
    return Table("arm_price_list", caption, columns, pd.DataFrame(rows, columns=[c.key for c in columns]), SHOWN)


ARM_COLUMNS = [
    Column("muscle", "muscle"), Column("configuration", "configuration"), Column("status", "status"),
    Column("time_ms", "ms a frame", 3, "ms a\nframe"), *[column for column in COLUMNS if column.key in ERRORS],
    Column("arm_percent", "of the exact arm %", 1, "of the\narm %"), Column("length_max_mm", "fibre length, largest mm", 2),
    Column("detail", "detail"),
]


def arm_table(armed: list[Aggregate], errors: dict) -> Table:
    """A row a muscle and configuration."""
    rows = [{"muscle": one.muscle, "configuration": one.configuration.name + (MARK if one.is_disturbed else ""),
             "status": one.status, "time_ms": one.collision_ms.value, "detail": one.detail,
             **errors.get((one.scene, one.configuration), {})} for one in armed]
    caption = (
        "Moment arms and fibre lengths against those of the exact run, each configuration moving its own muscle. "
        f"{RULE} Of the arm: its error over the exact run's arm, RMS both. Scenes of the program with the preset standard: with "
        "the paper's constants rounding alone moves a moment arm by more than backends do."
    )
    return Table("arm_errors", caption, ARM_COLUMNS, pd.DataFrame(rows, columns=[c.key for c in ARM_COLUMNS]),
                 [c.key for c in ARM_COLUMNS if c.key not in ("muscle", "detail", "length_max_mm", "status")])


def _offer(group: list[Aggregate], armed: list[Aggregate], errors: dict) -> dict:
    """The worst of the errors."""
    found = [errors[(one.scene, one.configuration)] for one in group]
    return cost_of(group, armed) | {key: max(error[key] for error in found) for key in ERRORS}


def _with_floor(rows: list[dict], offers: list[dict]) -> list[dict]:
    """What rounding does by itself nothing can be told to hold."""
    floor = max((offer["arm_floor_mm"] for offer in offers), default=math.nan)
    return [row | {"arm_floor_mm": floor} | ({"note": f"below what rounding does ({floor:.2g} mm)"}
                                             if floor > float(row["target_mm"]) else {}) for row in rows]
