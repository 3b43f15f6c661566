"""How far the forces of coupled runs are from those of the exact run."""

from ..results.force_differences import RULE as DIFFERENCES
from ..results.force_differences import force_differences
from .aggregates import Aggregate, exact_aggregate, find
from .configurations import Configuration

RULE = f"{DIFFERENCES} The floor is the same difference for an exact run from a start that differs by rounding."


def force_errors(told: list[Aggregate], floors: list[Aggregate]) -> dict[tuple[str, Configuration], dict[str, float]]:
    """{(scene, configuration): {torque_percent, contact_percent, pressure_percent, map_percent, torque_floor_percent,
    pressure_floor_percent, map_floor_percent}}; without those whose forces, or the exact run's, are not known. Telling forces takes time, so that
    the times of these runs do not count."""
    found: dict[tuple[str, Configuration], dict[str, float]] = {}
    for one in told:
        if one.is_shown and (errors := _errors(one, exact_aggregate(told, one.scene))):
            found[(one.scene, one.configuration)] = errors | _floor(one.scene, told, floors)
    return found


def _floor(scene: str, told: list[Aggregate], floors: list[Aggregate]) -> dict[str, float]:
    floor = next((one for one in floors if one.scene == scene and one.is_shown), None)
    errors = _errors(floor, find(told, scene, floor.configuration)) if floor else {}
    return {f"{what}_floor_percent": errors.get(f"{what}_percent", float("nan")) for what in ("torque", "pressure", "map")}


def _errors(one: Aggregate, reference: Aggregate | None) -> dict[str, float]:
    """Of the first repetitions that told forces."""
    if reference is None:
        return {}
    ours, theirs = (next((case.run for case in aggregate.ok if len(case.run.forces)), None) for aggregate in (one, reference))
    return force_differences(ours, theirs) if ours and theirs else {}
