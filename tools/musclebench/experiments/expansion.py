"""From an experiment file to its cases, and their order."""

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

from ..cases.case import Case
from ..cases.scene import Scene
from ..effects.effect_sets import EffectSet, effect_sets
from ..program.cli import Problem
from ..program.registry import Registry
from .record_case import RecordCase
from .sweeps import Configuration
from .experiment_file import CaseGroup, ExperimentFile
from .kernels import pattern_of
from .selection import Scenes, configurations_of, one_of
from .swept_case import AxisValue, SweptCase

NO_SCENE = "hard"  # in place of one: each hard case has its own
FEWER_REPETITIONS = ((60.0, 1), (8.0, 2))  # of more seconds a repetition there are no more


@dataclass(frozen=True)
class Expansion:
    experiment: ExperimentFile
    registry: Registry
    scenes: Scenes

    def firsts(self) -> list[SweptCase]:
        """As the file lists them, without repetitions."""
        return with_builders([case for group in self.experiment.groups for case in self.of_group(group)])

    def cases(self, firsts: list[SweptCase]) -> list[SweptCase | RecordCase]:
        """Recordings first, then round by round; the cases of a round are shuffled, so that what slows the machine for a
        while meets all alike."""
        return with_recordings(rounds(firsts, self.experiment))

    def of_group(self, group: CaseGroup) -> list[SweptCase]:
        """Without repetitions."""
        found = []
        scenes = self.scenes.of(group, self.experiment) if group.mode != "hard" else [Scene(NO_SCENE, asks_preset=False)]
        if group.mode == "probe":  # about bones: scenes with the same ones are probed once
            scenes = list({scene.probed.name: scene.probed for scene in scenes}.values())
        if group.one_scene:
            scenes = one_of(scenes, group.one_scene)
        for scene in scenes:
            if group.adds_effect and (group.adds_effect in scene.effects or group.adds_effect not in self.registry.effects):
                continue  # a scene's own would be in all; or this build has none
            configurations = configurations_of(group, self.experiment, self.registry)
            for configuration in configurations:
                cases = [self._case(scene, group, configuration, point) for point in self._points(scene, group)]
                found += [replace(case, stride=stride_of(case, configurations)) for case in cases]
        return found

    def _case(self, scene: Scene, group: CaseGroup, configuration, point: tuple[AxisValue, ...]) -> SweptCase:
        frames = next((int(one.value) for one in point if one.axis == "frames"), None)
        return SweptCase(scene if frames is None else self.scenes.limited(scene, frames), group, configuration, point)

    def _points(self, scene: Scene, group: CaseGroup) -> list[tuple[AxisValue, ...]]:
        axes: list[list[AxisValue]] = []
        if group.effects:
            axes.append([AxisValue("effects", one.name, tuple(one.options(scene.effects)), one)
                         for one in chosen_sets(scene, group, self.registry)])
        if counts := group.substeps or multiples(scene.substeps, group.times_substeps):  # the time of a frame stays the same
            if scene.has_step_changes:
                raise Problem(f"{scene.name}: [[time_step_change]] keeps its seconds however many substeps a frame has; take it out to refine the time step")
            axes.append([AxisValue("substeps", str(count), (
                "--loop", f"substeps={count}", "--loop", f"time_step_s={scene.frame_time_s / count!r}"))
                for count in counts])
        if counts := multiples(scene.iterations // scene.substeps, group.times_iterations):
            axes.append([AxisValue("iterations", str(count), ("--loop", f"iterations={count}")) for count in counts])
        for axis, more, own in (("split_muscles", group.split_muscles, scene.split_muscles), ("smooth_bones", group.smooth_bones, scene.smooth_bones)):
            if more:
                axes.append([AxisValue(axis, str(times), ("--meshes", f"{axis}={own + times}")) for times in more if own + times <= self.registry.most_splits])
        if group.frames:
            axes.append([AxisValue("frames", str(count)) for count in group.frames])
        if group.mode == "kernels":
            pattern = pattern_of(group, self.registry)
            axes.append([AxisValue("kernels", pattern, (f"--benchmark_filter={pattern}",))] if pattern else [])
        if group.mode == "hard":
            axes.append([AxisValue("case", case, ("--case", case)) for case in self.scenes.hard_cases(group.hard_cases)])
        axes += [[AxisValue(axis, value, words) for value, words in values] for axis, values in group.vary]
        return list(product(*axes))


def multiples(own: int, factors: tuple[float, ...]) -> tuple[int, ...]:
    """Whole numbers of at least 1, none twice."""
    return tuple(dict.fromkeys(max(1, round(own * factor)) for factor in factors))


def with_builders(cases: list[SweptCase]) -> list[SweptCase]:
    """A probe builds the structures of its configuration for all, else the first case of a group that stores them for
    such groups; what no case builds is not stored."""
    builders: dict[tuple[str, str], str] = {}
    for case in cases:
        if case.configuration.stores and (case.group.mode == "probe" or case.group.stores):
            builders.setdefault((case.built_on.name, case.configuration.label), case.name)
    return [replace(case, builder=builders.get((case.built_on.name, case.configuration.label), "")) for case in cases]


def chosen_sets(scene: Scene, group: CaseGroup, registry: Registry) -> list[EffectSet]:
    def is_wanted(one: EffectSet) -> bool:
        kind = "all-each" if one.left_out else "own+each" if one.added else one.name
        return kind in group.effects
    return [one for one in effect_sets(scene.effects, registry.effects) if is_wanted(one)]


def stride_of(case: SweptCase, configurations: list[Configuration]) -> int:
    """A power of two, so that the frames of a longer stride are among those of a shorter one. All frames with a
    clearance cache; without, the same for all configurations of a backend, so that their errors are of the same
    contacts."""
    if case.group.mode != "replay":
        return 1
    if case.group.stride != "auto":
        return case.group.stride
    own = case.configuration
    if own.has_cache:
        return 1
    alike = [one for one in configurations if one.backend == own.backend and not one.has_cache]
    slowest = replace(case, configuration=max([*alike, own], key=lambda one: one.step_ms))
    stride = 1
    while stride < own.longest_stride and replace(slowest, stride=stride).guessed_step_seconds > case.group.replay_s:
        stride *= 2
    return stride


def rounds(firsts: list[SweptCase], experiment: ExperimentFile) -> list[SweptCase]:
    order = random.Random(experiment.seed)
    most = max((repetitions(case, experiment) for case in firsts), default=0)
    cases = []
    for number in range(most):
        of_round = [replace(case, repetition=number) for case in firsts if number < repetitions(case, experiment)]
        blocks = neighbours(of_round)
        order.shuffle(blocks)
        for block in blocks:
            order.shuffle(block)
            cases += block
    return cases


def neighbours(cases: list[SweptCase]) -> list[list[SweptCase]]:
    """Those that stay next to each other: of a group that wants it all of a scene."""
    blocks: dict[tuple, list[SweptCase]] = {}
    for case in cases:
        blocks.setdefault((case.group.name, case.scene.name if case.group.together else case.name), []).append(case)
    return list(blocks.values())


def repetitions(case: SweptCase, experiment: ExperimentFile) -> int:
    """Estimates of what is too long don't vary; long runs average over themselves."""
    wanted = case.group.repetitions or experiment.repetitions
    if case.is_too_long:
        return 1
    if not case.group.fewer_repetitions:
        return wanted
    another = replace(case, repetition=1).guessed_seconds
    return min([wanted, *[count for seconds, count in FEWER_REPETITIONS if another > seconds]])


def with_recordings(cases: list[SweptCase]) -> list[SweptCase | RecordCase]:
    """Each that a replay reads, before all others. Raises Problem where two would have one name."""
    recordings = sorted({case.recording for case in cases if case.group.mode == "replay"}, key=lambda case: case.name)
    every = [*recordings, *cases]
    names: set[str] = set()
    for case in every:
        if case.name in names:
            raise Problem(f"two cases would be named '{case.name}'; name them by 'named', or give the scenes other presets")
        names.add(case.name)
    return every


def filtered(cases: list[SweptCase | RecordCase], keep: Callable[[str], bool]) -> list[SweptCase | RecordCase]:
    """Those whose name is kept, and what they need."""
    return with_recordings([case for case in cases if isinstance(case, SweptCase) and keep(case.name)])


def in_shard(cases: list[SweptCase | RecordCase], number: int, count: int) -> list[SweptCase | RecordCase]:
    """The number-th (from 1) of `count` parts of about the same time, each with the recordings that it needs. What shares
    structures, and the repetitions of a case, stay on one machine."""
    swept = [case for case in cases if isinstance(case, SweptCase)]
    groups: dict[tuple, list[SweptCase]] = {}
    for case in swept:
        groups.setdefault(case.shares, []).append(case)
    loads, mine = [0.0] * count, set()
    for key, group in sorted(groups.items(), key=lambda item: (-_seconds(item[1]), item[0])):
        lightest = loads.index(min(loads))
        loads[lightest] += _seconds(group)
        if lightest == number - 1:
            mine.add(key)
    return with_recordings([case for case in swept if case.shares in mine])


def _seconds(cases: list[Case]) -> float:
    return sum(case.guessed_seconds for case in cases if not case.is_too_long)
