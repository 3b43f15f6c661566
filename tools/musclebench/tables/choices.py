"""Of a backend with many choices: which part of its time is the method and which is its configuration."""

import math

import pandas as pd

from ..accuracy.aggregates import (
    ALLOWED_FALSE_SHARE, ALLOWED_MISSED_SHARE, ALLOWED_P99_OFFSET_MM, Aggregate, name_of_unit, unit_of_price,
)
from ..accuracy.rows import ratio_to
from ..program.registry import Backend
from ..results.disturbance import MARK
from ..figures.style import muscle_label
from .table_formats import Column, Table, as_ratio, with_unit

COLUMNS = [
    Column("muscle", "muscle"), Column("choice", "against the default"), Column("status", "status"),
    Column("time_ms", "ms a frame", 2, "ms a\nframe"), Column("factor", "x default", 2, "x\ndefault", True),
    Column("factor_low", "95 % low", 2, "95 %\nlow", True), Column("factor_high", "95 % high", 2, "95 %\nhigh", True),
    Column("ratio", "x {unit}", 2, "x\n{unit}", True), Column("missed", "missed contacts", 0, "missed"),
    Column("missed_percent", "missed %", 2), Column("true", "true contacts", 0, "of"),
    Column("false", "false contacts", 0, "false"),
    Column("p99_offset_mm", "p99 offset mm", 4, "p99\nmm"), Column("max_offset_mm", "largest offset mm", 3, "max\nmm"),
    Column("structure_mb", "structures MB", 1), Column("verdict", "verdict"), Column("detail", "detail"),
]
SHOWN = ["choice", "time_ms", "factor", "ratio", "missed", "true", "false", "p99_offset_mm", "verdict"]


def choices_tables(replays: list[Aggregate]) -> list[Table]:
    """One a backend that has many."""
    abouts = {one.backend: one.configuration.about for one in replays if one.configuration.about.has_many_choices}
    return [choices_table(replays, about) for about in abouts.values()]


def choices_table(replays: list[Aggregate], about: Backend) -> Table:
    """One row a muscle and configuration: the default, one choice changed, then more."""
    aggregates = sorted((one for one in replays if one.backend == about.name), key=lambda one: (
        [r.scene for r in replays].index(one.scene), one.configuration.factors, one.configuration.name))
    columns = with_unit(COLUMNS, name_of_unit(replays))
    rows = pd.DataFrame([_row(aggregate, replays) for aggregate in aggregates], columns=[c.key for c in columns])
    caption = " ".join([
        f"Configurations of {about.label} on replayed positions. Factors are medians over the frames that both "
        "replayed; with a clearance cache all are replayed, else one in a few.", rule(), *summaries(replays, about)])
    return Table(f"{about.name}_factors", caption, columns, rows, SHOWN)


def rule() -> str:
    return (
        f"Wrong is an exact method that misses more than {100 * ALLOWED_MISSED_SHARE:g} % of the true contacts (nodes "
        f"inside a bone), reports more than {100 * ALLOWED_FALSE_SHARE:g} % false ones, or whose surface "
        f"offset's 99th percentile is over {ALLOWED_P99_OFFSET_MM:g} mm. Intersecting surfaces says nothing of nodes deeper inside "
        "than the crossing triangles: it is judged by the same rule."
    )


def summaries(replays: list[Aggregate], about: Backend) -> list[str]:
    """A sentence a muscle: how the default's multiple of the unit splits into configuration and the rest."""
    texts, unit = [], name_of_unit(replays)
    for scene in dict.fromkeys(aggregate.scene for aggregate in replays):
        default, best = _default(replays, scene, about), best_right(replays, scene, about.name)
        if default is None or best is None:
            continue
        whole = ratio_to(default, unit_of_price(replays, default)).value
        share = ratio_to(default, best).value
        rest = ratio_to(best, unit_of_price(replays, best)).value
        if math.isnan(whole) or math.isnan(share):
            continue
        muscle, fault = muscle_label(scene.split("/")[-1]), default.verdict.removeprefix("wrong: ")
        start = f"{muscle}: the default costs {as_ratio(whole)} x {unit}"
        end = f"the fastest that answers right, {best.configuration.name}, {as_ratio(rest)} x"
        if default.is_wrong:
            texts.append(f"{start} and answers wrong ({fault}); {end}.")
        elif best is default:
            texts.append(f"{start}; no configuration that answers right is faster.")
        else:
            texts.append(f"{start}; {end}: a factor of {as_ratio(share)} is configuration, the rest is {about.label}.")
    return texts


def best_right(replays: list[Aggregate], scene: str, backend: str) -> Aggregate | None:
    """The fastest right configuration of a backend on one thread."""
    right = [one for one in replays if one.backend == backend and one.scene == scene and one.verdict == "right"
             and one.configuration.threads == 1 and not math.isnan(one.collision_ms.value)]
    return min(right, key=lambda aggregate: aggregate.collision_ms.value, default=None)


def _default(replays: list[Aggregate], scene: str, about: Backend) -> Aggregate | None:
    return next((one for one in replays if one.scene == scene and one.backend == about.name
                 and one.configuration.is_default and one.is_shown), None)


def _row(aggregate: Aggregate, replays: list[Aggregate]) -> dict:
    default = _default(replays, aggregate.scene, aggregate.configuration.about)
    factor, ratio = ratio_to(aggregate, default), ratio_to(aggregate, unit_of_price(replays, aggregate))
    return {
        "muscle": aggregate.muscle, "choice": aggregate.configuration.short + (MARK if aggregate.is_disturbed else ""), "status": aggregate.status,
        "time_ms": aggregate.collision_ms.value, "factor": factor.value, "factor_low": factor.low,
        "factor_high": factor.high, "ratio": ratio.value, "missed": aggregate.number("accuracy", "missed_contacts"),
        "missed_percent": 100 * aggregate.missed_share, "true": aggregate.number("accuracy", "true_contacts"),
        "false": aggregate.number("accuracy", "false_contacts"),
        "p99_offset_mm": aggregate.p99_offset_mm, "max_offset_mm": aggregate.max_offset_mm,
        "structure_mb": aggregate.structure_bytes / 1e6, "verdict": aggregate.verdict, "detail": aggregate.detail,
    }
