"""The fastest loop and backend whose error stays within a bound: chosen from a budget, and run before it is said."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from ..cases.scene import Scene
from ..experiments.experiment_file import CaseGroup
from ..experiments.swept_case import SweptCase
from ..experiments.sweeps import Configuration
from ..program.registry import Registry
from ..results.run_folder import Run
from ..results.status import MEASURED
from .sources import Budget, frame_ms, shape_mm

MOST_TRIES = 4
CHOSEN = "chosen"


@dataclass(frozen=True)
class Candidate:
    """A loop with a backend. Its error and time are what the budget lets expect of both together."""

    loop: str  # as the budget words it
    options: tuple[str, ...]  # of the program, that set the loop
    configuration: Configuration | None  # None: the exact backend
    expected_mm: float
    expected_ms: float
    run: Run | None = None  # where it was run

    @property
    def words(self) -> str:
        return f"{self.loop} with {self.configuration.label}" if self.configuration else f"{self.loop} with the exact backend"


@dataclass(frozen=True)
class Choices:
    """Of one scene: what can be combined, and what it is judged by."""

    budget: Budget
    loops: dict[SweptCase, Run]  # exact runs with other substeps or iterations, and that of the scene's own
    backends: dict[SweptCase, Run]  # with the scene's own loop
    finest: Run  # by which all are judged
    left_mm: float  # that the finest is itself off by

    def error_mm(self, run: Run) -> float:
        """With what the finest is itself off by: no less than it is from the limit, unless these two point the same way."""
        return shape_mm(run, self.finest) + self.left_mm if run.status in MEASURED else math.nan

    def within(self, bound_mm: float) -> list[Candidate]:
        """Those expected to hold, the fastest first."""
        own, found = self.budget.own, []
        for loop, run in self.loops.items():
            exact = Candidate(words_of(loop), tuple(word for one in loop.point for word in one.words), None, self.error_mm(run), frame_ms(run), run)
            found.append(exact)
            for case, other in self.backends.items():
                if other.status in MEASURED:
                    found.append(replace(exact, configuration=case.configuration, expected_mm=exact.expected_mm + shape_mm(other, own),
                                         expected_ms=exact.expected_ms * frame_ms(other) / frame_ms(own), run=None))
        return sorted((one for one in found if one.expected_mm <= bound_mm), key=lambda one: one.expected_ms)


def words_of(loop: SweptCase) -> str:
    return ", ".join(f"{one.value} {one.axis if one.value != '1' else one.axis[:-1]}" for one in loop.point)


def choices_of(budget: Budget, runs: dict[SweptCase, Run]) -> Choices | None:
    """`runs`: of the scene. None where the time step was not refined."""
    steps = next((source for source in budget.sources if source.name == "time step"), None)
    if steps is None:
        return None
    loops = {case: run for case, run in runs.items() if case.group.name in ("time_step", "iterations") and run.status in MEASURED}
    backends = {case: run for case, run in runs.items() if case.group.name in ("collision", "resolution")
                and run.backend != budget.own.backend}
    return Choices(budget, loops, backends, steps.reference.run, steps.left_mm())


def resolutions(pattern: CaseGroup, registry: Registry) -> CaseGroup:
    """The [[cases]] of the resolutions that may be chosen: those of a quick study. `pattern`: of the collision."""
    every = registry.backends if isinstance(pattern.backends, str) else [registry.backend(name) for name in pattern.backends]
    names = tuple(one.name for one in every if not (one.is_exact or one.is_slow or one.is_external or one.is_control))
    return replace(pattern, name="resolution", named="{scene}-resolution-{configuration}", backends=names, configurations="study_quick", only=("drives",))


def group_of(candidate: Candidate, pattern: CaseGroup, number: int) -> CaseGroup:
    """The [[cases]] that run a candidate. `pattern`: of the collision."""
    assert candidate.configuration is not None
    parameters = tuple((key, (value,)) for key, value in candidate.configuration.parameters)
    loop = "-".join(candidate.loop.replace(",", "").split())
    return replace(pattern, name=f"{CHOSEN}-{number}", named=f"{{scene}}-{CHOSEN}-{{configuration}}-{loop}", parameters=parameters,
                   backends=(candidate.configuration.backend,), configurations="default", options=(*pattern.options, *candidate.options))


def tries(choices: Choices, bound_mm: float) -> Iterator[Candidate]:
    """The fastest that are expected to hold, up to the first that was run already: nothing behind it can be faster."""
    for candidate in choices.within(bound_mm)[:MOST_TRIES]:
        yield candidate
        if candidate.run is not None:
            return


def hold(choices: dict[Scene, Choices], bound_mm: float, pattern: CaseGroup,
         run_case: Callable[[Scene, CaseGroup], Run | None]) -> dict[Scene, list[Candidate]]:
    """Of each scene what was tried, up to what holds. `run_case`: one of that scene and group; None where it failed."""
    tried: dict[Scene, list[Candidate]] = {scene: [] for scene in choices}
    for scene, own in choices.items():
        for number, candidate in enumerate(tries(own, bound_mm), start=1):
            run = candidate.run or run_case(scene, group_of(candidate, pattern, number))
            tried[scene].append(replace(candidate, run=run))
            if run is not None and own.error_mm(run) <= bound_mm:
                break
    return tried


def in_words(choices: Choices, bound_mm: float, tried: list[Candidate]) -> str:
    """`tried`: in order, with their runs."""
    name = choices.budget.scene
    failed = [f"{one.words} was expected to, and was {_told(choices.error_mm(one.run))} off" for one in tried
              if one.run and not choices.error_mm(one.run) <= bound_mm]
    held = next((one for one in tried if one.run and choices.error_mm(one.run) <= bound_mm), None)
    if held is None:
        least = min((choices.error_mm(run) for run in choices.loops.values()), default=math.nan)
        words = f"{name}: nothing that was run holds {bound_mm:g} mm; the least is {least:.2g} mm, of the finest time step and the exact backend"
    else:
        assert held.run is not None
        words = (f"{name}: {held.words} hold {bound_mm:g} mm: {choices.error_mm(held.run):.2g} mm from the limit of the time step, judged by a run, "
                 f"in {choices.budget.times(held.run):.2g} times the time of the scene's own setting ({frame_ms(held.run):.3g} ms a frame)")
    meshes = [f"{source.name} {source.errors()['shape_mm']:.2g} mm" for source in choices.budget.sources if source.name.endswith("mesh")]
    return "; ".join([words, *failed]) + (f". Not in it: {', '.join(meshes)}." if meshes else ".")


def _told(error_mm: float) -> str:
    return "diverged, and so unknown millimetres" if math.isnan(error_mm) else f"{error_mm:.2g} mm"
