"""The price list of moment arms: for each error the cheapest configuration that holds it, coupled."""

import math

import pandas as pd

from ..accuracy.aggregates import Aggregate, name_of_unit
from ..accuracy.arm_errors import RULE
from ..accuracy.front import ALL_MUSCLES
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


def arm_price_list(coupled: list[Aggregate], errors: dict, faults: set) -> Table:
    """`errors` as accuracy.arm_errors gives them; `faults`: pairs (scene, configuration) that don't count."""
    able = [one for one in coupled if one.is_shown and one.configuration.threads == 1
            and (one.scene, one.configuration) in errors and (one.scene, one.configuration) not in faults
            and not math.isnan(one.collision_ms.value)]
    scenes = list(dict.fromkeys(one.scene for one in able))
    rows = []
    for scene in scenes:
        offers = [_offer([one], coupled, errors) for one in able if one.scene == scene]
        rows += _with_floor(price_rows(scene.split("/")[-1], offers, TARGETS_MM, "arm_rms_mm"), offers)
    if len(scenes) > 1:
        offers = [_offer(group, coupled, errors) for group in on_all(able, scenes)]
        rows += _with_floor(price_rows(ALL_MUSCLES, offers, TARGETS_MM, "arm_rms_mm"), offers)
    caption = (
        "Price list of moment arms. For each error the fastest configuration whose muscle has the exact run's moment arm to "
        "within that (RMS over the motion); of those whose intervals overlap the fastest one's, the one with the fewest "
        f"bytes. {RULE} Times are of collision in coupled runs, as a multiple of {name_of_unit(coupled)}."
    )
    columns = with_unit(COLUMNS, name_of_unit(coupled))
    return Table("arm_price_list", caption, columns, pd.DataFrame(rows, columns=[c.key for c in columns]), SHOWN)


def _offer(group: list[Aggregate], coupled: list[Aggregate], errors: dict) -> dict:
    """The worst of the errors."""
    found = [errors[(one.scene, one.configuration)] for one in group]
    return cost_of(group, coupled) | {key: max(error[key] for error in found) for key in ERRORS}


def _with_floor(rows: list[dict], offers: list[dict]) -> list[dict]:
    """What rounding does by itself nothing can be told to hold."""
    floor = max((offer["arm_floor_mm"] for offer in offers), default=math.nan)
    return [row | {"arm_floor_mm": floor} | ({"note": f"below what rounding does ({floor:.2g} mm)"}
                                             if floor > float(row["target_mm"]) else {}) for row in rows]
