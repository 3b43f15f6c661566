"""Runs the same cases with one program or several, their repetitions interleaved on one core, so that all of them meet the
machine in the same state."""

import hashlib
import json
import math
import random
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment
from ..cases.pool import Limits, run_cases
from ..cases.study_command import problem_of
from ..experiments.expansion import rounds
from ..experiments.experiment_file import ExperimentFile
from ..experiments.swept_case import SweptCase
from ..program import fingerprint
from ..program.machine_state import last_core, settings_of
from ..program.out_folder import claimed
from .instructions import ChildCounter, NotCounted, callgrind_prefix, read_callgrind, why_not_by_callgrind
from .result_set import MEASURED_FILE, REPETITION

TIMED, JUDGED, COUNTED = "timed", "judged", "counted"
PROGRAM_NAMES = ("before", "after")
FEWEST_REPETITIONS = 5
SLOWER_COUNTED = 3  # a process, most of which is start and building
LEFT_OUT = "complete"  # as the pool calls what is not wanted


@dataclass(frozen=True)
class InterleavedCase(Case):
    """A case of the runner's, asked of one of several programs."""

    asked: SweptCase
    program: str  # one of PROGRAM_NAMES
    purpose: str = TIMED

    @property
    def base(self) -> str:
        """Name of what its repetitions and purposes share."""
        return REPETITION.sub("", replace(self.asked, repetition=0).name)

    @property
    def name(self) -> str:
        return f"{self.base}-{f'r{self.asked.repetition}' if self.purpose == TIMED else self.purpose}"

    @property
    def folder(self) -> str:
        return f"{self.program}/raw/{self.name}"

    @property
    def kind(self) -> str:
        return f"{self.purpose} {self.base}"

    @property
    def threads(self) -> int:
        return self.asked.threads

    @property
    def guessed_seconds(self) -> float:
        return self.asked.guessed_seconds * (SLOWER_COUNTED if self.purpose == COUNTED else 1)

    def arguments(self, folders: Folders) -> list[str]:
        return self.asked.arguments(folders)

    def input_digests(self) -> dict[str, str]:
        return self.asked.input_digests()

    def record(self) -> dict:
        return self.asked.record()


def asked_for(case: SweptCase, purpose: str) -> SweptCase:
    """The Referee judges in a run of its own, which also keeps shapes, so that all repetitions are alike."""
    group = replace(case.group, judged="always" if purpose == JUDGED else "never",
                    snapshots=case.group.snapshots if purpose == JUDGED else ())
    scene = case.scene
    if purpose == COUNTED:
        scene = replace(scene, frames=group.counted_frames, frames_limit=group.counted_frames)
    return replace(case, group=group, scene=scene)


@dataclass
class Plan:
    """What is run, in which order."""

    cases: list[InterleavedCase]
    notes: list[str] = field(default_factory=list)  # what can't be measured here, and why

    @property
    def repetitions(self) -> int:
        return 1 + max(case.asked.repetition for case in self.cases)


def plan(firsts: list[SweptCase], file: ExperimentFile, programs: tuple[str, ...]) -> Plan:
    """What is run once first; then the runner's rounds, with the programs of a case next to each other in random order.
    `firsts`: cases of the file without repetitions."""
    order, why_not = random.Random(file.seed), why_not_by_callgrind()
    wanted = {JUDGED: [case for case in firsts if case.group.judged != "never"],
              COUNTED: [case for case in firsts if case.group.counted_frames and not why_not]}
    cases = [InterleavedCase(asked_for(case, purpose), program, purpose)
             for purpose, some in wanted.items() for case in some for program in programs]
    # Of a case that is run once the judged run is that one: it has answers and no times.
    timed = [case for case in firsts if case.group.repetitions != 1 or case.group.judged == "never"]
    for case in rounds(timed, file):
        cases += [InterleavedCase(asked_for(case, TIMED), program) for program in order.sample(programs, len(programs))]
    return Plan(cases, [f"instructions are not counted: {why_not}"] if why_not else [])


class InterleavedExperiment(Experiment):
    """Of programs by name. `seconds`: after them no repetition begins beyond the fewest that can be judged."""

    def __init__(self, programs: dict[str, Path], folders: Folders, invocation: str, seconds: float = math.inf):
        super().__init__(next(iter(programs.values())), folders)
        self._programs = {name: path.resolve() for name, path in programs.items()}
        self._digests = {name: fingerprint.file_digest(path) for name, path in self._programs.items()}
        self._invocation = invocation
        self._counter: ChildCounter | None = None
        self._end, self._begun = time.monotonic() + seconds, set(range(FEWEST_REPETITIONS))

    def wants(self, case: InterleavedCase) -> bool:
        """Asked when its turn comes. A repetition that has begun is ended, so that programs have equally many."""
        if case.purpose == TIMED and case.asked.repetition not in self._begun:
            if time.monotonic() > self._end:
                return False
            self._begun.add(case.asked.repetition)
        return super().wants(case)

    @property
    def repetitions(self) -> int:
        """That were begun, of a plan with at least the fewest."""
        return len(self._begun)

    def command(self, case: InterleavedCase, folder: Path) -> list[str]:
        prefix = callgrind_prefix(folder.parent) if case.purpose == COUNTED else []
        return [*prefix, str(self._programs[case.program]), *case.arguments(self.folders), *case.output(folder)]

    def print_of(self, case: InterleavedCase) -> dict:
        return super().print_of(case) | {"binary_sha256": self._digests[case.program]}

    def prepare(self, case: InterleavedCase, folder: Path) -> None:
        """One case runs at a time, so that what children count is the case's."""
        if self._counter is not None:
            self._counter.read()  # of a case that failed
        self._counter = None
        if case.purpose == TIMED:
            try:
                self._counter = ChildCounter()
            except NotCounted:
                pass  # callgrind counts

    def complete(self, case: InterleavedCase, folder: Path, exit_code: int) -> None:
        counters = read_callgrind(folder.parent) if case.purpose == COUNTED else {}
        if self._counter is not None:
            counters["process_instructions"] = self._counter.read() or None
            self._counter = None
        files = [path for path in sorted(folder.iterdir()) if path.name in ("run.json", "frames.csv")]
        noted = {"schema": 1, "invocation": self._invocation, "is_slowed": case.purpose == COUNTED,
                 "counters": {name: value for name, value in counters.items() if value},
                 "settings": settings_of(last_core()),
                 "sha256": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}}
        (folder / MEASURED_FILE).write_text(json.dumps(noted, indent=2) + "\n")


def measure(cases: list[InterleavedCase], experiment: InterleavedExperiment, timeout: float) -> list[str]:
    """Runs what is not complete yet, one case at a time; a line for each that failed."""
    names = sorted({case.program for case in cases})
    with claimed(experiment.folders.out_dir, *(f"{name}/raw" for name in names)):
        todo = [case for case in cases if not experiment.is_complete(case)]
        statuses = run_cases(todo, experiment, Limits([last_core()], timeout))
    return [problem_of(case, status, experiment) for case, status in statuses.items()
            if status not in experiment.final_statuses and status != LEFT_OUT]
