"""The tables of the study of effects: costs, changes, and the price list of wanted properties."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from ..results.arms import RULE, arm_differences
from ..tables.table_formats import Column, Table
from .effect_runs import NAN, MeasuredSet, rms_mm
from .effect_sets import ALL, OWN

COST_COLUMNS = [
    Column("muscle", "muscle"), Column("effect", "effect"),
    Column("own_ms", "of its own, ms a frame", 3, "own\nms"), Column("share_percent", "share of the frame %", 1, "share\n%"),
    Column("added_ms", "added to the scene's, ms a frame", 3, "added\nms"),
    Column("saved_ms", "saved where it is left out of all, ms a frame", 3, "saved\nms"),
]
CHANGE_COLUMNS = [
    Column("muscle", "muscle"), Column("set", "effects"), Column("status", "status"),
    Column("frame_ms", "ms a frame", 2, "ms a\nframe"), Column("node_depth_mm", "largest depth of nodes mm", 3, "nodes\nmm"),
    Column("surface_depth_mm", "largest depth of the surface mm", 3, "surface\nmm"),
    Column("volume_percent", "largest volume error %", 3, "volume\n%"),
    Column("folded", "triangles through others", 0, "folded"),
    Column("folded_at_rest", "at rest", 0, "at\nrest"), Column("tunnelled", "tunnelled nodes", 0, "tun-\nnelled"),
    Column("stretch", "edge stretch, p99", 3, "edge\nstretch"),
    Column("shape_mm", "RMS to all effects, full flexion mm", 3, "RMS\nto all"),
    Column("arm_mm", "moment arm to all effects, RMS mm", 2, "arm\nto all"),
]
ARM_MM = 1.0
PRICE_COLUMNS = [
    Column("muscle", "muscle"), Column("wanted", "wanted"), Column("cheapest", "cheapest that holds it"),
    Column("time_ms", "ms a frame", 2, "ms a\nframe"), Column("ratio", "x own", 2, "x\nown", True),
    Column("needs", "needs, of all"), Column("note", "note"),
]


@dataclass(frozen=True)
class Property:
    words: str
    key: str  # of a row of changes
    holds: Callable[[dict], bool]


PROPERTIES = (
    Property("no surface depth over 0.1 mm", "surface_depth_mm", lambda row: row["surface_depth_mm"] <= 0.1),
    Property("volume within 1 %", "volume_percent", lambda row: row["volume_percent"] <= 1),
    Property("no tunnelled node", "tunnelled", lambda row: row["tunnelled"] == 0),
    Property(f"moment arm within {ARM_MM:g} mm of that with all", "arm_mm", lambda row: row["arm_mm"] <= ARM_MM),
    Property("no fold", "folded", lambda row: row["folded"] <= row["folded_at_rest"]),
)


def change_rows(measured: list[MeasuredSet]) -> list[dict]:
    full = {one.scene: one for one in measured if one.chosen.name == ALL}
    return [_change_row(one, full.get(one.scene)) for one in measured]


def _change_row(one: MeasuredSet, full: MeasuredSet | None) -> dict:
    return {
        "muscle": one.muscle, "set": one.chosen.name, "status": one.status, "frame_ms": one.frame_ms.value,
        "node_depth_mm": 1e3 * one.outcome("max_depth_m"), "surface_depth_mm": 1e3 * one.outcome("max_surface_depth_m"),
        "volume_percent": 100 * one.outcome("max_volume_error"), "folded": one.outcome("self_intersecting_triangles"),
        "folded_at_rest": one.outcome("self_intersecting_triangles_at_rest"),
        "tunnelled": one.outcome("tunnelled_nodes"), "stretch": one.outcome("p99_edge_stretch"),
        "shape_mm": rms_mm(one.shape_m, full.shape_m) if full else NAN,
        "arm_mm": arm_differences(one.runs[0], full.runs[0]).get("arm_rms_mm", NAN) if full else NAN,
    }


def cost_table(measured: list[MeasuredSet]) -> Table:
    rows = []
    for scene in dict.fromkeys(one.scene for one in measured):
        sets = {one.chosen.name: one for one in measured if one.scene == scene and one.is_measured}
        known = [*sets[ALL].chosen.effects] if ALL in sets else []
        known += [one.chosen.added for one in sets.values() if one.chosen.added and one.chosen.added not in known]
        rows += [_cost_row(effect, sets) for effect in known]
    caption = (
        "What an effect costs a frame. Of its own: its column in the profile of the run with all effects, mean over the "
        "frames (of one that moves the muscle, gravity or activation: in the run that adds it); an effect that is a "
        "response has no column. Added: what the median frame takes longer when the scene's own effects get it. Saved: "
        "what the frame takes less when it alone is left out of all. The last two hold what it makes others do: a muscle "
        "in another shape has other contacts."
    )
    return _table("effect_costs", caption, COST_COLUMNS, rows)


def _cost_row(effect: str, sets: dict[str, MeasuredSet]) -> dict:
    home = next((sets[name] for name in (ALL, f"{OWN}+{effect}") if name in sets and effect in sets[name].chosen.effects))
    own_ms = home.effect_ms(effect)
    return {"muscle": home.muscle, "effect": effect, "own_ms": own_ms,
            "share_percent": 100 * own_ms / home.mean_frame_ms,
            "added_ms": _difference(sets, f"{OWN}+{effect}", OWN), "saved_ms": _difference(sets, ALL, f"{ALL}-{effect}")}


def _difference(sets: dict[str, MeasuredSet], more: str, less: str) -> float:
    return sets[more].frame_ms.value - sets[less].frame_ms.value if more in sets and less in sets else NAN


def change_table(measured: list[MeasuredSet]) -> Table:
    caption = (
        "What effects change. own: those of scene and preset; all: every effect but those that move the muscle; all-X: "
        "without X; own+X: with X. Depths, volume error, tunnelled nodes and stretch are the largest of the run; "
        "triangles through others the most at rest, full flexion and the end. RMS over the nodes; of moment arms over the "
        f"motion. {RULE}"
    )
    return _table("effect_changes", caption, CHANGE_COLUMNS, change_rows(measured))


def price_table(measured: list[MeasuredSet]) -> Table:
    rows = []
    for scene in dict.fromkeys(one.scene for one in measured):
        sets = [one for one in measured if one.scene == scene and one.is_measured and not one.chosen.is_loaded]
        by_name = {one.chosen.name: (one, row) for one, row in zip(sets, change_rows(sets))}
        told = [one for one in PROPERTIES if any(not math.isnan(row[one.key]) for _, row in by_name.values())]
        rows += [_price_row(wanted.words, [wanted], by_name) for wanted in told]
        rows += [_price_row("all of these", told, by_name)] if told else []
    caption = (
        "Price list. For each wanted property the fastest set of effects, of those that were run, that holds it through "
        "the whole motion and has none to spare: no set that holds it, too, has some of its effects only. Of those whose "
        "intervals overlap the fastest one's, the one with the fewest effects. Time as a multiple of the scene's own "
        "effects. Needs: the effects without which all the others do not hold it. Of a scene without fibres nothing is said "
        "of moment arms."
    )
    return _table("effect_prices", caption, PRICE_COLUMNS, rows)


def _price_row(words: str, wanted: list[Property], by_name: dict[str, tuple[MeasuredSet, dict]]) -> dict:
    holding = {name: one for name, (one, row) in by_name.items() if all(each.holds(row) for each in wanted)}
    muscle = next(iter(by_name.values()))[0].muscle
    row = {"muscle": muscle, "wanted": words, "needs": _needs(holding, by_name), "note": ""}
    if not holding:
        return row | {"cheapest": "none", "note": _best(wanted, by_name)}
    cheapest = _cheapest(list(holding.values()))
    own = by_name.get(OWN)
    return row | {"cheapest": cheapest.chosen.name, "time_ms": cheapest.frame_ms.value,
                  "ratio": cheapest.frame_ms.value / own[0].frame_ms.value if own else NAN}


def _cheapest(holding: list[MeasuredSet]) -> MeasuredSet:
    """An effect that is not needed is not worth a time either: runs are minutes apart, and a busy machine makes one of them
    seem faster."""
    every = [set(one.chosen.effects) for one in holding]
    sets = [one for one in holding if not any(fewer < set(one.chosen.effects) for fewer in every)]
    times = {one.chosen.name: one.frame_ms for one in sets}
    fastest = min(sets, key=lambda one: times[one.chosen.name].value)
    limit_ms = times[fastest.chosen.name].high
    as_fast = [one for one in sets if times[one.chosen.name].low <= limit_ms]
    return min(as_fast or [fastest], key=lambda one: (len(one.chosen.effects), times[one.chosen.name].value))


def _needs(holding: dict, by_name: dict) -> str:
    if ALL not in holding:
        return ""
    without = {name: one.chosen.left_out for name, (one, _) in by_name.items() if one.chosen.left_out}
    if not without:
        return ""  # a quick look
    lost = [gone for name, gone in without.items() if name not in holding]
    return ", ".join(lost) or "none alone"


def _best(wanted: list[Property], by_name: dict) -> str:
    """Of the sets that hold the most; the one with the least of what is lacking first."""
    def misses(row: dict) -> tuple:
        lacking = [each for each in wanted if not each.holds(row)]
        return len(lacking), [row[each.key] if not math.isnan(row[each.key]) else math.inf for each in lacking]

    name, (_, row) = min(by_name.items(), key=lambda item: misses(item[1][1]))
    lacking = [f"{each.key.removesuffix('_mm').removesuffix('_percent').replace('_', ' ')} {row[each.key]:.3g}"
               for each in wanted if not each.holds(row)]
    return f"the best found: {name} with {', '.join(lacking)}"


def _table(name: str, caption: str, columns: list[Column], rows: list[dict]) -> Table:
    return Table(name, caption, columns, pd.DataFrame(rows, columns=[column.key for column in columns]),
                 [column.key for column in columns if column.key not in ("muscle", "note")])
