"""What is to be reached: by the configurations that backends' studies race, and by kernels."""

from dataclasses import dataclass

from ..experiments.experiment_file import of_project
from ..program.registry import Registry

# Of no backend: all of them.
COMMON_TARGETS = (
    {"what": "edge length, ns a constraint: one by one / SIMD lanes", "kind": "ratio", "group": "constraints",
     "kernel": "constraints/edge_length/scalar", "below": "constraints/edge_length/lanes",
     "counter": "ns_a_constraint", "at_least": 2},
    {"what": "edge length: PBDlib's formulas / SIMD lanes", "kind": "ratio", "group": "constraints",
     "kernel": "constraints/edge_length/published", "below": "constraints/edge_length/lanes",
     "counter": "ns_a_constraint"},
    {"what": "bending, ns a constraint: one by one / SIMD lanes (of AVX-512)", "kind": "ratio",
     "group": "constraints", "kernel": "constraints/bending/scalar", "below": "constraints/bending/lanes",
     "counter": "ns_a_constraint", "at_least": 5},
    {"what": "bending: one by one / SIMD lanes of AVX2", "kind": "ratio", "group": "constraints",
     "kernel": "constraints/bending/scalar", "below": "constraints/bending/lanes_of_avx2",
     "counter": "ns_a_constraint", "at_least": 3.5},
    {"what": "bending: PBDlib's formulas / SIMD lanes", "kind": "ratio", "group": "constraints",
     "kernel": "constraints/bending/published", "below": "constraints/bending/lanes", "counter": "ns_a_constraint"},
    {"what": "heap allocations in a frame after the second", "kind": "value", "group": "allocations",
     "kernel": "allocations/{}", "counter": "allocations", "at_most": 0},
)


@dataclass(frozen=True)
class Setting:
    """One configuration as it is raced."""

    label: str
    backend: str
    parameters: tuple[tuple[str, object], ...] = ()
    at_most: float | None = None  # times the unit of price
    aim: float | None = None
    is_unit: bool = False


def settings(registry: Registry) -> list[Setting]:
    """What the backends' studies race."""
    found = []
    for backend in registry.backends:
        unit = backend.study.get("advise", {}).get("unit_of_price")
        for race in backend.study.get("race", []):
            parameters = race.get("parameters", {})
            found.append(Setting(race["label"], backend.name, tuple(parameters.items()), race.get("at_most"), race.get("aim"),
                                 unit is not None and parameters == unit))
    return found


def targets(registry: Registry) -> list[dict]:
    """Of kernels: what the backends' studies hold, and what is of no backend."""
    told = [target for backend in registry.backends for target in backend.study.get("target", [])]
    return [*told, *COMMON_TARGETS]


def timed_groups() -> set[str]:
    """Of kernels; bytes and counts are not disturbed by what else the machine does."""
    return {group.name for group in of_project("speed").groups if group.mode == "kernels" and group.samples > 1}
