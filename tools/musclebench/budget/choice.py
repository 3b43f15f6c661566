"""The fastest loop and backend whose error stays within a bound: chosen by a budget, and run before it is said."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..cases.scene import Scene
from ..experiments.experiment_file import CaseGroup
from ..experiments.swept_case import SweptCase
from ..experiments.sweeps import Configuration
from ..program.registry import Registry
from ..results.run_folder import Run
from ..results.status import MEASURED
from .sources import Budget, Source, frame_ms, shape_mm, size_in_words

MOST_ROUNDS = 4
CHOSEN = "chosen"


@dataclass(frozen=True)
class Loop:
    """Substeps or iterations, in multiples of the scene's own."""

    substeps: float = 1.0
    iterations: float = 1.0

    @property
    def key(self) -> str:
        return f"substeps=x{self.substeps:g},iterations=x{self.iterations:g}"


@dataclass(frozen=True)
class Candidate:
    """A loop with a backend, what the budget lets expect of both together, and their run where there is one."""

    loop: Loop
    loop_words: str
    configuration: Configuration | None  # None: the exact backend
    expected_mm: float
    expected_ms: float
    run: Run | None = None

    @property
    def words(self) -> str:
        return f"{self.loop_words} with {self.configuration.label if self.configuration else 'the exact backend'}"

    def group(self, pattern: CaseGroup) -> CaseGroup:
        """The [[cases]] that run it, the same for each scene. `pattern`: of the collision."""
        assert self.configuration is not None
        words = f"{CHOSEN}-{self.configuration.label}-{self.loop.key}"
        return replace(pattern, name=words, named=f"{{scene}}-{words}", backends=(self.configuration.backend,), configurations="default",
                       parameters=tuple((key, (value,)) for key, value in self.configuration.parameters),
                       times_substeps=(self.loop.substeps,), times_iterations=(self.loop.iterations,))


@dataclass(frozen=True)
class Choices:
    """Of one scene: what can be combined, and what it is judged by."""

    budget: Budget
    steps: Source  # the time step: all are judged by its finest run
    loops: dict[SweptCase, Run]  # exact runs with other substeps or iterations, and that of the scene's own
    backends: dict[SweptCase, Run]  # with the scene's own loop

    @property
    def floor_mm(self) -> float:
        return self.budget.floor.get("shape_mm", 0.0)

    def error_mm(self, run: Run) -> float:
        """To the finest run, and from there to the limit, as far as that is known. NaN where the run did not end well, or worse than the
        exact run of the scene's own setting."""
        ended = run.status in MEASURED and (run.status == "ok" or run.status == self.budget.own.status)
        return shape_mm(run, self.steps.reference.run) + self.steps.left_mm() if ended else math.nan

    def holds(self, run: Run | None, bound_mm: float) -> bool:
        return run is not None and self.error_mm(run) <= bound_mm

    def within(self, bound_mm: float) -> list[Candidate]:
        """Those expected to hold, the fastest first."""
        found = []
        for case, run in self.loops.items():
            exact = Candidate(self._loop_of(case), _words_of(case), None, self.error_mm(run), frame_ms(run), run)
            found.append(exact)
            found += [self._with_backend(exact, other, theirs) for other, theirs in self._different_backends()]
        return sorted((one for one in found if one.expected_mm <= bound_mm), key=lambda one: _last_if_unknown(one.expected_ms))

    def _with_backend(self, exact: Candidate, case: SweptCase, run: Run) -> Candidate:
        own = self.budget.own
        if exact.run is own:
            return replace(exact, configuration=case.configuration, expected_mm=self.error_mm(run), expected_ms=frame_ms(run), run=run)
        return replace(exact, configuration=case.configuration, expected_mm=exact.expected_mm + shape_mm(run, own),
                       expected_ms=exact.expected_ms * frame_ms(run) / frame_ms(own), run=None)

    def _different_backends(self) -> list[tuple[SweptCase, Run]]:
        """Those with the same states once, the fastest: a default and the same said in parameters, all where nothing touches."""
        known: dict[tuple[str, str], tuple[SweptCase, Run]] = {}
        for case, run in sorted(self.backends.items(), key=lambda one: _last_if_unknown(frame_ms(one[1]))):
            known.setdefault((run.backend, run.record.get("state_hash", case.name)), (case, run))
        return list(known.values())

    def _loop_of(self, case: SweptCase) -> Loop:
        told = {one.axis: int(one.value) for one in case.point}
        own = case.scene
        return Loop(told.get("substeps", own.substeps) / own.substeps, told.get("iterations", own.iterations // own.substeps) * own.substeps / own.iterations)


def _last_if_unknown(ms: float) -> float:
    """Where all frames are warm-up."""
    return math.inf if math.isnan(ms) else ms


def _words_of(case: SweptCase) -> str:
    return ", ".join(f"{one.value} {one.axis if one.value != '1' else one.axis[:-1]}" for one in case.point)


def choices_of(budget: Budget, runs: dict[SweptCase, Run], registry: Registry) -> Choices | None:
    """`runs`: of the scene. None where no finer time step ended well."""
    steps = next((source for source in budget.sources if source.name == "time step"), None)
    if steps is None:
        return None
    loops = {case: run for case, run in runs.items() if case.group.name in ("time_step", "iterations") and run.status in MEASURED}
    backends = {case: run for case, run in runs.items() if case.group.name in ("collision", "resolution") and run.status in MEASURED
                and not registry.backend(run.backend).is_exact and not registry.backend(run.backend).is_control}
    return Choices(budget, steps, loops, backends)


def resolutions(pattern: CaseGroup, registry: Registry) -> CaseGroup:
    """The [[cases]] of the resolutions that may be chosen: those of a quick study. `pattern`: of the collision."""
    every = registry.backends if isinstance(pattern.backends, str) else [registry.backend(name) for name in pattern.backends]
    names = tuple(one.name for one in every if not (one.is_exact or one.is_slow or one.is_external or one.is_control))
    return replace(pattern, name="resolution", named="{scene}-resolution-{configuration}", backends=names, configurations="study_quick",
                   only=("drives", "probed", "one_thread"))


def hold(choices: dict[Scene, Choices], bound_mm: float, pattern: CaseGroup,
         run_all: Callable[[dict[Scene, CaseGroup]], dict[Scene, Run]]) -> dict[Scene, list[Candidate]]:
    """Of each scene what was tried, in rounds: the fastest that is expected to hold, until one holds. What was run already is the
    last. `run_all`: a case a scene; those without a result are missing."""
    left = {scene: own.within(bound_mm) if bound_mm > own.floor_mm else [] for scene, own in choices.items()}
    tried: dict[Scene, list[Candidate]] = {scene: [] for scene in choices}
    for round_number in range(MOST_ROUNDS + 1):
        now = {scene: _next(some, round_number) for scene, some in left.items() if some and not _has_held(choices[scene], tried[scene], bound_mm)}
        wanted = {scene: one.group(pattern) for scene, one in now.items() if one and one.run is None}
        done = run_all(wanted) if wanted else {}
        for scene, one in now.items():
            if one:
                left[scene].remove(one)
                tried[scene].append(replace(one, run=one.run or done.get(scene)))
    return tried


def _next(some: list[Candidate], round_number: int) -> Candidate | None:
    """The fastest; in the last round the fastest that was run already."""
    return next((one for one in some if round_number < MOST_ROUNDS or one.run is not None), None)


def _has_held(choices: Choices, tried: list[Candidate], bound_mm: float) -> bool:
    return any(choices.holds(one.run, bound_mm) for one in tried)


def in_words(choices: Choices, bound_mm: float, tried: list[Candidate]) -> str:
    """`tried`: with their runs. The fastest of what held is named, by the times of the runs."""
    name = choices.budget.scene
    if bound_mm <= choices.floor_mm:
        return f"{name}: nothing can hold {bound_mm:g} mm: rounding alone moves the shape by {choices.floor_mm:.2g} mm."
    known = [one for one in choices.within(bound_mm) if one.run is not None]
    held = min((one for one in [*tried, *known] if choices.holds(one.run, bound_mm)), key=lambda one: _last_if_unknown(frame_ms(_run_of(one))), default=None)
    reference, settled = choices.steps.reference, choices.steps.has_settled()
    finest = reference.words + ("" if reference.run.status in ("ok", choices.budget.own.status) else f" ({reference.run.status})")
    limit = f"{finest} themselves may be off by {choices.steps.left_mm():.2g} mm" + ("" if settled else " or more, since refining has not settled")
    if held is None:
        least = min((error for run in choices.loops.values() if not math.isnan(error := choices.error_mm(run))), default=math.nan)
        said = f"nothing that was run holds {bound_mm:g} mm; the smallest error is {least:.3g} mm, where {limit}"
    else:
        run = _run_of(held)
        status = "" if run.status == "ok" else f" ({run.status}, as the exact run is: {run.record.get('status_detail', '')})"
        time = "The times are not known: all frames are warm-up" if math.isnan(frame_ms(run)) else \
            f"It takes about {choices.budget.times(run):.2g} times the time of the scene's own setting, {frame_ms(run):.3g} ms a frame"
        said = (f"{bound_mm:g} mm{'' if settled else ', as far as can be told'}: {held.words}. "
                f"Its run is {shape_mm(run, reference.run):.2g} mm from {finest}{status}, and {limit}. {time}")
    others = [_failed(one, choices, bound_mm) for one in tried if not choices.holds(one.run, bound_mm)]
    told = {one.words for one in tried}
    untried = [one for one in choices.within(bound_mm) if one.run is None and one.words not in told
               and (held is None or one.expected_ms < frame_ms(_run_of(held)))]
    others += [f"{len(untried)} faster ones that should hold were not run"] if untried else []
    meshes = [f"{source.name} {size_in_words(source)}" for source in choices.budget.sources
              if source.name.endswith("mesh") and "shape_mm" in source.errors()]
    on_top = [f"Mesh errors come on top: {', '.join(meshes)}"] if meshes else []
    return f"{name}: " + ". ".join([said, *others, *on_top, *choices.budget.missing]) + "."


def _run_of(candidate: Candidate) -> Run:
    assert candidate.run is not None
    return candidate.run


def _failed(candidate: Candidate, choices: Choices, bound_mm: float) -> str:
    expected = f"Of {candidate.words} {candidate.expected_mm:.3g} mm were expected"
    if candidate.run is None:
        return f"{expected}, and the run failed"
    error_mm = choices.error_mm(candidate.run)
    return f"{expected}, and the run ended {candidate.run.status}" if math.isnan(error_mm) else f"{expected}, and its run is {error_mm:.3g} mm off"
