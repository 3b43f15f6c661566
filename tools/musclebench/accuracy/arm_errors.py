"""How far the fibre lengths and moment arms of coupled runs are from those of the exact run."""

import math

from ..results import arms
from .aggregates import Aggregate, exact_aggregate, find

RULE = f"{arms.RULE} The floor is the same difference for an exact run from a start that differs by rounding."


def arm_errors(armed: list[Aggregate], floors: list[Aggregate]) -> dict[tuple, dict]:
    """{(scene, configuration): {length_rms_mm, length_max_mm, arm_rms_mm, arm_max_mm, arm_floor_mm}}; without those
    whose fibres, or the exact run's, are not known."""
    found: dict[tuple, dict] = {}
    for one in armed:
        if one.is_shown and (errors := _errors(one, exact_aggregate(armed, one.scene))):
            found[(one.scene, one.configuration)] = errors | {"arm_floor_mm": _floor_mm(one.scene, armed, floors)}
    return found


def _floor_mm(scene: str, armed: list[Aggregate], floors: list[Aggregate]) -> float:
    """RMS over the motion; NaN where it was not measured."""
    floor = next((one for one in floors if one.scene == scene and one.is_shown), None)
    same = find(armed, scene, floor.configuration) if floor else None
    return _errors(floor, same).get("arm_rms_mm", math.nan) if same else math.nan


def _errors(one: Aggregate, reference: Aggregate | None) -> dict[str, float]:
    """Of the first repetitions that followed fibres."""
    if reference is None:
        return {}
    ours, theirs = (next((case.run for case in aggregate.ok if len(case.run.fibres)), None) for aggregate in (one, reference))
    return arms.arm_differences(ours, theirs) if ours and theirs else {}
