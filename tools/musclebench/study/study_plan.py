"""Which cases the accuracy study has, how often each is repeated, in which order, and how it is split over machines."""

import random
from dataclasses import dataclass, replace

from ..cases.scene import Scene
from .study_cases import LONGEST_SECONDS, ArmsCase, ArmsFloorCase, CoupledCase, FloorCase, MeasuredCase, ProbeCase, RecordCase, ReplayCase
from .sweeps import Configuration

REPLAY_SECONDS = 4.0  # of the steps of one replay; the stride keeps to it
QUICK_REPLAY_SECONDS = 2.0
FEWER_REPETITIONS = ((60.0, 1), (8.0, 2))  # of more seconds a repetition there are no more


@dataclass(frozen=True)
class Request:
    """What a command line asks of the study."""

    scenes: tuple[Scene, ...]
    data_set: str = "synthetic"
    repetitions: int = 3
    quick: bool = False
    frames_limit: int | None = None
    band_mm: float = 10.0
    shard: tuple[int, int] = (1, 1)  # the i-th of n
    seed: int = 1
    longest_seconds: float = LONGEST_SECONDS
    arm_scenes: tuple[Scene, ...] = ()  # the same, as moment arms are measured on them


StudyCase = RecordCase | MeasuredCase


def plan(request: Request, configurations: list[Configuration]) -> list[StudyCase]:
    """Recordings first, then round by round; the cases of a round are shuffled."""
    chosen = [c for c in configurations if c.in_quick or not request.quick]
    probed = {scene.probed.name: scene.probed for scene in request.scenes}.values()
    firsts = [ProbeCase(scene, one) for scene in probed for one in chosen if one.is_probed]
    firsts += [case for scene in request.scenes for configuration in chosen
               for case in _modes(scene, configuration, configurations, request)]
    exact = min((one for one in chosen if one.is_exact and not one.parameters and one.threads == 1),
                key=lambda one: one.step_ms, default=None)
    limit = {"longest_seconds": request.longest_seconds}
    firsts += [ArmsCase(scene, one, **limit) for scene in request.arm_scenes for one in chosen
               if (one.drives_quick if request.quick else one.drives) and one.threads == 1]
    firsts += [FloorCase(scene, exact, **limit) for scene in request.scenes if exact]
    firsts += [ArmsFloorCase(scene, exact, **limit) for scene in request.arm_scenes if exact]
    measured = _rounds(in_shard(firsts, *request.shard), request)
    recorded = {case.recording for case in measured if isinstance(case, ReplayCase)}
    return [case for case in map(RecordCase, request.scenes) if case in recorded] + measured


def is_too_long(case: StudyCase) -> bool:
    """True for a case that is shown as a row with its estimate and never run."""
    return isinstance(case, (CoupledCase, ReplayCase)) and case.guessed_seconds > case.longest_seconds


def in_shard(cases: list[MeasuredCase], number: int, count: int) -> list[MeasuredCase]:
    """The number-th (from 1) of `count` parts of about the same time. What shares structures stays on one machine."""
    groups: dict[tuple, list[MeasuredCase]] = {}
    for case in cases:
        groups.setdefault(_group(case), []).append(case)
    loads, mine = [0.0] * count, set()
    for key, group in sorted(groups.items(), key=lambda item: (-_seconds(item[1]), item[0])):
        lightest = loads.index(min(loads))
        loads[lightest] += _seconds(group)
        if lightest == number - 1:
            mine.add(key)
    return [case for case in cases if _group(case) in mine]


def _group(case: MeasuredCase) -> tuple[str, str]:
    scene = case.scene.probed if case.configuration.is_probed else case.scene
    return scene.key, case.configuration.label


def _modes(scene: Scene, configuration: Configuration, all_of_them: list[Configuration],
           request: Request) -> list[MeasuredCase]:
    cases = []
    if configuration.replays:
        seconds = QUICK_REPLAY_SECONDS if request.quick else REPLAY_SECONDS
        stride = stride_of(scene, configuration, seconds, all_of_them)
        cases.append(ReplayCase(scene, configuration, longest_seconds=request.longest_seconds, stride=stride,
                                band_mm=request.band_mm))
    if configuration.drives_quick if request.quick else configuration.drives:
        cases.append(CoupledCase(scene, configuration, longest_seconds=request.longest_seconds))
    return cases


def stride_of(scene: Scene, configuration: Configuration, seconds: float,
              all_of_them: list[Configuration] = ()) -> int:
    """A power of two, so that the frames of a longer stride are among those of a shorter one. All frames with a
    clearance cache; without, the same for all configurations of a backend, so that their errors are of the same
    contacts."""
    if configuration.has_cache:
        return 1
    of_backend = [c for c in all_of_them if c.backend == configuration.backend and c.replays and not c.has_cache]
    slowest = max([*of_backend, configuration], key=lambda c: c.step_ms)
    stride = 1
    longest = configuration.longest_stride
    while stride < longest and ReplayCase(scene, slowest, stride=stride).guessed_step_seconds > seconds:
        stride *= 2
    return stride


def _rounds(firsts: list[MeasuredCase], request: Request) -> list[MeasuredCase]:
    order = random.Random(request.seed)
    cases = []
    for repetition in range(request.repetitions):
        of_round = [replace(case, repetition=repetition) for case in firsts if repetition < _repetitions(case, request)]
        order.shuffle(of_round)
        cases += of_round
    return cases


def _repetitions(case: MeasuredCase, request: Request) -> int:
    """Errors of a probe, moment arms, what rounding does and estimates of what is too long don't vary; long runs average
    over themselves."""
    if isinstance(case, (ProbeCase, FloorCase, ArmsCase)) or is_too_long(case):
        return 1
    another = replace(case, repetition=1).guessed_seconds
    fewest = [count for seconds, count in FEWER_REPETITIONS if another > seconds]
    return min([request.repetitions, *fewest])


def _seconds(cases: list[MeasuredCase]) -> float:
    return sum(case.guessed_seconds for case in cases if not is_too_long(case))
