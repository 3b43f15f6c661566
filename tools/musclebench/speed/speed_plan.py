"""What is raced, which kernels are timed, how often and in which order."""

import random
from dataclasses import dataclass, replace

from ..cases.case import Case
from ..cases.muscle_scene import MuscleScene

from .speed_cases import KernelCase, KernelGroup, RaceCase, Setting

REFERENCE = "voxel"  # what everything is divided by
SDF = (("cells", 64), ("precision", "float"))
OFF = (("clearance_cache", "off"),)
SETTINGS = (
    Setting(REFERENCE, "voxel", (("cells", 64),), step_ms=0.05),
    Setting("sdf", "sdf", SDF, step_ms=0.1, stores=True),
    Setting("bvh", "bvh", (), step_ms=0.2),
    Setting("fcl", "fcl", (("query", "node_distance"), ("clearance_cache", "on")), step_ms=1.5),
    Setting("sdf-cold", "sdf", (*SDF, *OFF), step_ms=0.2, stores=True),
    Setting("bvh-cold", "bvh", OFF, step_ms=4.0),
)
# Kernels that are divided by each other run in one process.
KERNEL_GROUPS = (
    KernelGroup("queries", "^(voxel_test|sdf_value_and_gradient|bvh_locate)/", 60.0),
    KernelGroup("embree", "^(embree|signed)/", 30.0, program="musclebench_embree"),
    KernelGroup("build", "^(sdf_build_a_node|bvh_locate/near)/", 60.0),
    KernelGroup("two_threads", "^(detect_threads|sdf_build_threads)/", 60.0, threads=2),
    KernelGroup("muscle_size", "^muscle_size/", 90.0),
    KernelGroup("bone_size", "^bone_size/", 60.0),
    KernelGroup("adaptive", "^adaptive_over_uniform/femur", 20.0),
    KernelGroup("bytes", "^sdf_bytes/", 60.0, varies=False),
    KernelGroup("allocations", "^allocations/", 20.0, varies=False),
)
QUICK_PATTERNS = {"muscle_size": "^muscle_size/.*/(1000|10000|100000)(/|$)",
                  "bone_size": "^bone_size/.*/(5120|20480|81920|327680)(/|$)"}
QUICK_FRAMES = 60


@dataclass(frozen=True)
class Request:
    """What a command line asks for."""

    data_set: str = "synthetic"
    muscles: tuple[str, ...] = ("iliacus",)
    repetitions: int = 3
    quick: bool = False
    seed: int = 1


def plan(request: Request) -> list[Case]:
    """Round by round. Within a round the muscles and kernels come in random order, and so do the settings of a muscle,
    but next to each other: what is divided by each other meets the machine in the same state."""
    order = random.Random(request.seed)
    cases: list[Case] = []
    for repetition in range(request.repetitions):
        groups = [_races(request, muscle, repetition) for muscle in request.muscles]
        groups += [[case] for case in _kernels(request, repetition)]
        order.shuffle(groups)
        for group in groups:
            order.shuffle(group)
            cases += group
    return cases


def _races(request: Request, muscle: str, repetition: int) -> list[Case]:
    frames = QUICK_FRAMES if request.quick else None
    scene = MuscleScene(request.data_set, muscle, frames)
    return [RaceCase(scene, setting, repetition) for setting in SETTINGS]


def _kernels(request: Request, repetition: int) -> list[Case]:
    # The muscle that most of the published numbers are of, where it is among those that are measured.
    muscle = "iliacus" if "iliacus" in request.muscles else request.muscles[0]
    whole = KernelCase(MuscleScene(request.data_set, muscle), KERNEL_GROUPS[0], repetition)
    case = replace(whole, repetitions_inside=3, least_seconds=0.02) if request.quick else whole
    groups = [_quick(group) if request.quick else group for group in KERNEL_GROUPS]
    return [replace(case, group=group) for group in groups if group.varies or repetition == 0]


def _quick(group: KernelGroup) -> KernelGroup:
    return replace(group, pattern=QUICK_PATTERNS.get(group.name, group.pattern), seconds=group.seconds / 6)
