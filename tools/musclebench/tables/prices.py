"""The price list: for each surface offset the cheapest configuration that holds it, and what it costs."""

import math

import pandas as pd

from ..accuracy.aggregates import Aggregate, name_of_unit, unit_of_price
from ..accuracy.front import ALL_MUSCLES, EXACT_MM
from ..accuracy.rows import build_seconds, ratio_to
from ..results.disturbance import MARK
from ..results.statistics import Estimate, quotient, total
from .table_formats import Column, Table, with_unit

TARGETS_MM = (1.0, 0.3, 0.1, 0.03, 0.01)
MEGABYTE = 1e6

COLUMNS = [
    Column("muscle", "muscle"), Column("target_mm", "holds (mm)"), Column("configuration", "cheapest"),
    Column("time_ms", "ms a frame", 3, "ms a\nframe"), Column("ratio", "x {unit}", 2, "x\n{unit}", True),
    Column("ratio_low", "95 % low", 2, "95 %\nlow", True), Column("ratio_high", "95 % high", 2, "95 %\nhigh", True),
    Column("build_s", "build s", 2, "build\ns"), Column("structure_mb", "structures MB", 2, "MB"),
    Column("p99_offset_mm", "p99 offset mm", 4, "p99\nmm"), Column("inward_mm", "p99 inwards mm", 4, "in\nmm"),
    Column("outward_mm", "p99 outwards mm", 4, "out\nmm"),
    Column("left_mm", "p99 its run left mm", 4, "left\nmm"), Column("max_offset_mm", "largest offset mm", 3, "largest\nmm"),
    Column("missed", "missed contacts", 0, "missed"), Column("true", "true contacts", 0, "of"),
    Column("note", "note"),
]
SHOWN = [column.key for column in COLUMNS if column.key not in ("muscle", "note", "p99_offset_mm", "max_offset_mm")]


def price_list(replays: list[Aggregate], measured_builds: dict) -> Table:
    """Of one thread, right and complete configurations whose own run was judged. For all muscles a configuration holds
    what it holds on each."""
    able = [e for e in replays if e.is_shown and not e.is_wrong and e.configuration.threads == 1
            and not any(map(math.isnan, (e.p99_offset_mm, e.left_mm, e.collision_ms.value)))]
    scenes = list(dict.fromkeys(aggregate.scene for aggregate in replays))
    rows = []
    for scene in scenes:
        offers = [_offer([aggregate], replays, measured_builds) for aggregate in able if aggregate.scene == scene]
        rows += price_rows(scene.split("/")[-1], offers, TARGETS_MM, "held_mm")
    if len(scenes) > 1:
        together = [_offer(group, replays, measured_builds) for group in on_all(able, scenes)]
        rows += price_rows(ALL_MUSCLES, together, TARGETS_MM, "held_mm")
    caption = (
        "Price list. For each offset the fastest configuration whose surface is no farther from the true one at 99 of 100 "
        "contacts, and whose own run left none deeper (methods without a resolution only where they answer right). "
        "Inwards, nodes are let in so deep; outwards, they are held off so far. A method that can't be asked about single "
        "points has the depth that its own run left. Of those whose intervals overlap the fastest one's, the one with the fewest bytes. Time as a multiple of "
        f"{name_of_unit(replays)} on the same frames, with its 95 % interval; all muscles: sum of the medians, each over its configuration's frames, "
        "holding on each, the worst of the errors, building and bytes of the largest. One thread."
    )
    columns = with_unit(COLUMNS, name_of_unit(replays))
    return Table("price_list", caption, columns, pd.DataFrame(rows, columns=[c.key for c in columns]), SHOWN)


def price_rows(muscle: str, offers: list[dict], targets_mm: tuple[float, ...], error: str) -> list[dict]:
    """A row a target: of the offers whose `error` is no larger the cheapest. An offer has time_ms, time_ms_low,
    time_ms_high, structure_mb, configuration and `error`."""
    return [_row(muscle, target, offers, error) for target in targets_mm]


def _row(muscle: str, target_mm: float, offers: list[dict], error: str) -> dict:
    row = {"muscle": muscle, "target_mm": f"{target_mm:g}"}
    holding = [offer for offer in offers if max(offer[error], EXACT_MM) <= target_mm]
    if holding:
        return row | _cheapest(holding) | {"note": ""}
    if not offers:
        return row | {"configuration": "none", "note": "nothing was measured, or no run of its own was judged"}
    best = min(offers, key=lambda offer: (offer[error], offer["time_ms"]))
    note = f"none holds it; the best found: {best['configuration']} with {best[error]:.3g} mm"
    return row | {"configuration": "none", "note": note}


def _cheapest(offers: list[dict]) -> dict:
    """Of those that are as fast as the fastest, as far as the intervals tell, the one with the fewest bytes."""
    fastest = min(offers, key=lambda offer: (offer["time_ms"], offer["configuration"]))
    as_fast = [offer for offer in offers if offer["time_ms_low"] <= fastest["time_ms_high"]]
    return min(as_fast or [fastest], key=lambda offer: (offer["structure_mb"], offer["time_ms"]))


def on_all(able: list[Aggregate], scenes: list[str]) -> list[list[Aggregate]]:
    """Those of each configuration that all scenes have."""
    groups: dict = {}
    for aggregate in able:
        groups.setdefault(aggregate.configuration, []).append(aggregate)
    return [group for group in groups.values() if len(group) == len(scenes)]


def cost_of(group: list[Aggregate], aggregates: list[Aggregate]) -> dict:
    """Of one configuration on one scene, or on several together: sums of the times, the largest structures."""
    ratio = ratio_to(group[0], unit_of_price(aggregates, group[0])) if len(group) == 1 else _ratio_of_sums(group, aggregates)
    time = total([aggregate.collision_ms for aggregate in group])
    return {
        "configuration": group[0].configuration.name + (MARK if any(one.is_disturbed for one in group) else ""),
        "time_ms": time.value, "time_ms_low": time.low, "time_ms_high": time.high,
        "ratio": ratio.value, "ratio_low": ratio.low, "ratio_high": ratio.high,
        "structure_mb": max(aggregate.structure_bytes for aggregate in group) / MEGABYTE,
    }


def _offer(group: list[Aggregate], replays: list[Aggregate], measured_builds: dict) -> dict:
    return cost_of(group, replays) | {
        "build_s": max(build_seconds(aggregate, measured_builds) for aggregate in group),
        "held_mm": max(aggregate.held_mm for aggregate in group),
        "left_mm": max(aggregate.left_mm for aggregate in group),
        "p99_offset_mm": max(aggregate.p99_offset_mm for aggregate in group),
        "inward_mm": max(aggregate.inward_mm for aggregate in group),
        "outward_mm": max(aggregate.outward_mm for aggregate in group),
        "max_offset_mm": max(aggregate.max_offset_mm for aggregate in group),
        "missed": sum(aggregate.number("accuracy", "missed_contacts") for aggregate in group),
        "true": sum(aggregate.number("accuracy", "true_contacts") for aggregate in group),
    }


def _ratio_of_sums(group: list[Aggregate], replays: list[Aggregate]) -> Estimate:
    units = [unit_of_price(replays, aggregate) for aggregate in group]
    if any(unit is None for unit in units):
        return Estimate.unknown()
    return quotient(total([one.collision_ms for one in group]), total([unit.collision_ms for unit in units]))
