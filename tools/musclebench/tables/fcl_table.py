"""Which part of FCL's time is FCL and which is its configuration."""

import math

import pandas as pd

from ..accuracy.aggregates import ALLOWED_FALSE_SHARE, ALLOWED_MISSED_SHARE, ALLOWED_P99_ERROR_MM, Aggregate, find
from ..accuracy.configurations import configuration
from ..accuracy.rows import find_voxel_64, ratio_to
from ..figures.style import muscle_label
from .table_formats import Column, Table, as_ratio

DEFAULT = configuration("fcl", {})
COLUMNS = [
    Column("muscle", "muscle"), Column("choice", "against the default"), Column("status", "status"),
    Column("time_ms", "ms a frame", 2, "ms a\nframe"), Column("factor", "x default", 2, "x\ndefault", True),
    Column("factor_low", "95 % low", 2, "95 %\nlow", True), Column("factor_high", "95 % high", 2, "95 %\nhigh", True),
    Column("ratio", "x voxel 64", 2, "x\nvoxel 64", True), Column("missed", "missed contacts", 0, "missed"),
    Column("missed_percent", "missed %", 2), Column("measured", "measured contacts", 0, "of"),
    Column("false", "false contacts", 0, "false"),
    Column("p99_error_mm", "p99 error mm", 4, "p99\nmm"), Column("max_error_mm", "largest error mm", 3, "max\nmm"),
    Column("structure_mb", "structures MB", 1), Column("verdict", "verdict"), Column("detail", "detail"),
]
SHOWN = ["choice", "time_ms", "factor", "ratio", "missed", "measured", "false", "p99_error_mm", "verdict"]


def fcl_table(replays: list[Aggregate]) -> Table:
    """One row a muscle and configuration of fcl: the default, one choice changed, then more."""
    aggregates = sorted((e for e in replays if e.backend == "fcl"), key=lambda e: (
        [r.scene for r in replays].index(e.scene), e.configuration.factors, e.configuration.name))
    keys = [column.key for column in COLUMNS]
    rows = pd.DataFrame([_row(aggregate, replays) for aggregate in aggregates], columns=keys)
    caption = " ".join([
        "FCL's configurations on replayed positions, the default being the paper's way. Factors are medians over the "
        "frames that both replayed; with clearance cache all are replayed, else one in a few.",
        rule(), *summaries(replays)])
    return Table("fcl_factors", caption, COLUMNS, rows, SHOWN)


def rule() -> str:
    return (
        f"Wrong is an exact method that misses more than {100 * ALLOWED_MISSED_SHARE:g} % of the true contacts (nodes "
        f"inside a bone), reports more than {100 * ALLOWED_FALSE_SHARE:g} % false ones, or whose depth error's 99th "
        f"percentile is over {ALLOWED_P99_ERROR_MM:g} mm. Intersecting surfaces says nothing of nodes deeper inside "
        "than the crossing triangles: the paper's way is judged by the same rule."
    )


def summaries(replays: list[Aggregate]) -> list[str]:
    """A sentence a muscle: how the default's multiple of voxel splits into configuration and the rest."""
    texts = []
    for scene in dict.fromkeys(aggregate.scene for aggregate in replays):
        default, best = find(replays, scene, DEFAULT), best_right(replays, scene)
        if default is None or best is None:
            continue
        whole = ratio_to(default, find_voxel_64(replays, default)).value
        share = ratio_to(default, best).value
        rest = ratio_to(best, find_voxel_64(replays, best)).value
        if math.isnan(whole) or math.isnan(share):
            continue
        muscle, fault = muscle_label(scene.split("/")[-1]), default.verdict.removeprefix("wrong: ")
        start = f"{muscle}: the default costs {as_ratio(whole)} x voxel 64"
        end = f"the fastest that answers right, {best.configuration.name}, {as_ratio(rest)} x"
        if default.is_wrong:
            texts.append(f"{start} and answers wrong ({fault}); {end}.")
        elif best is default:
            texts.append(f"{start}; no configuration that answers right is faster.")
        else:
            texts.append(f"{start}; {end}: a factor of {as_ratio(share)} is configuration, the rest is FCL.")
    return texts


def best_right(replays: list[Aggregate], scene: str) -> Aggregate | None:
    """The fastest right configuration of fcl on one thread."""
    right = [one for one in replays if one.backend == "fcl" and one.scene == scene and one.verdict == "right"
             and one.configuration.threads == 1 and not math.isnan(one.collision_ms.value)]
    return min(right, key=lambda aggregate: aggregate.collision_ms.value, default=None)


def _row(aggregate: Aggregate, replays: list[Aggregate]) -> dict:
    default = find(replays, aggregate.scene, DEFAULT)
    factor, ratio = ratio_to(aggregate, default), ratio_to(aggregate, find_voxel_64(replays, aggregate))
    return {
        "muscle": aggregate.muscle, "choice": aggregate.configuration.short, "status": aggregate.status,
        "time_ms": aggregate.collision_ms.value, "factor": factor.value, "factor_low": factor.low,
        "factor_high": factor.high, "ratio": ratio.value, "missed": aggregate.number("accuracy", "missed_contacts"),
        "missed_percent": 100 * aggregate.missed_share, "measured": aggregate.number("accuracy", "measured_contacts"),
        "false": aggregate.number("accuracy", "false_contacts"),
        "p99_error_mm": aggregate.p99_error_mm, "max_error_mm": aggregate.max_error_mm,
        "structure_mb": aggregate.structure_bytes / 1e6, "verdict": aggregate.verdict, "detail": aggregate.detail,
    }
