"""What is raced, which kernels are timed, how often and in which order."""

import random
from dataclasses import dataclass, replace

from ..cases.case import Case
from ..cases.scene import Scene
from ..program.registry import Registry
from .speed_cases import KernelCase, KernelGroup, RaceCase, Setting

# Kernels that are divided by each other run in one process. Which ones, the targets say.
KERNEL_GROUPS = (
    KernelGroup("queries", seconds=60.0),
    KernelGroup("embree", seconds=30.0, program="musclebench_embree"),
    KernelGroup("build", seconds=60.0),
    KernelGroup("two_threads", seconds=60.0, threads=2),
    KernelGroup("muscle_size", seconds=90.0, quick_sizes=(1_000, 10_000, 100_000)),
    KernelGroup("bone_size", seconds=60.0, quick_sizes=(5_120, 20_480, 81_920, 327_680)),
    KernelGroup("adaptive", seconds=20.0),
    KernelGroup("bytes", seconds=60.0, varies=False),
    KernelGroup("allocations", seconds=20.0, varies=False),
    KernelGroup("constraints", seconds=30.0, scene_key="gluteus_maximus"),
    KernelGroup("loop", seconds=90.0, threads=2, scene_key="gluteus_maximus"),
    KernelGroup("muscles", seconds=60.0, threads=2, other_scene="hip"),
)
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
QUICK_FRAMES = 60
QUICK_SHARE = 1 / 6  # of the seconds of a group of kernels
MAIN_MUSCLE = "iliacus"  # which most of the published numbers are of


@dataclass(frozen=True)
class Request:
    """What a command line asks for."""

    scenes: tuple[Scene, ...]
    repetitions: int = 3
    quick: bool = False
    seed: int = 1


def settings(registry: Registry) -> list[Setting]:
    """What the backends' studies race."""
    found = []
    for backend in registry.backends:
        unit = backend.study.get("advise", {}).get("unit_of_price")
        for race in backend.study.get("race", []):
            storage = backend.of_role("storage")
            found.append(Setting(
                race["label"], backend.name, tuple(race.get("parameters", {}).items()), race.get("step_ms", 0.1),
                storage.name if storage and race.get("stores") else "", race.get("at_most"), race.get("aim"),
                unit is not None and race.get("parameters", {}) == unit))
    return found


def targets(registry: Registry) -> list[dict]:
    """Of kernels: what the backends' studies hold, and what is of no backend."""
    told = [target for backend in registry.backends for target in backend.study.get("target", [])]
    return [*told, *COMMON_TARGETS]


def plan(request: Request, registry: Registry) -> list[Case]:
    """Round by round. Within a round the muscles and kernels come in random order, and so do the settings of a muscle,
    but next to each other: what is divided by each other meets the machine in the same state."""
    order = random.Random(request.seed)
    cases: list[Case] = []
    for repetition in range(request.repetitions):
        groups = [[RaceCase(scene, setting, repetition) for setting in settings(registry)] for scene in request.scenes]
        if repetition == 0:
            largest = max(request.scenes, key=lambda scene: scene.nodes)
            groups.append([RaceCase(largest, setting, is_judged=True) for setting in settings(registry)])
        groups += [[case] for case in _kernels(request, registry, repetition)]
        order.shuffle(groups)
        for group in groups:
            order.shuffle(group)
            cases += group
    return cases


def _kernels(request: Request, registry: Registry, repetition: int) -> list[Case]:
    groups = [_with_pattern(group, targets(registry), request.quick) for group in KERNEL_GROUPS]
    chosen = [(_scene_of(group, request, registry), group) for group in groups
              if group.pattern and (group.varies or repetition == 0)]
    cases = [KernelCase(scene, group, repetition) for scene, group in chosen if scene is not None]
    return [replace(case, repetitions_inside=3, least_seconds=0.02) for case in cases] if request.quick else cases


def _scene_of(group: KernelGroup, request: Request, registry: Registry) -> Scene | None:
    """None where the data set of the scenes has not the one that the group needs."""
    if group.other_scene:
        name = f"{request.scenes[0].name.split('/')[0]}/{group.other_scene}"
        known = any(scene.name == name for scene in registry.scenes)
        return replace(request.scenes[0], name=name, frames_limit=None) if known else None
    wanted = [scene for key in (group.scene_key, MAIN_MUSCLE) for scene in request.scenes if scene.key == key]
    # Kernels build what they measure, whatever number of frames is raced.
    return replace([*wanted, *request.scenes][0], frames_limit=None)


def _with_pattern(group: KernelGroup, told: list[dict], quick: bool) -> KernelGroup:
    """A regular expression of the kernels that the group's targets name."""
    named = [target[key] for target in told if target["group"] == group.name for key in ("kernel", "below")
             if key in target]
    stems = sorted({name.partition("{}")[0].rstrip("/") for name in named})
    if not stems:
        return group
    pattern = f"^({'|'.join(stems)})(/|$)"
    if not quick:
        return replace(group, pattern=pattern)
    if group.quick_sizes:
        pattern = f"^({'|'.join(stems)})/({'|'.join(map(str, group.quick_sizes))})(/|$)"
    return replace(group, pattern=pattern, seconds=QUICK_SHARE * group.seconds)
