"""Runs the same cases with one program or several, their repetitions interleaved on one core, so that all of them meet the
machine in the same state."""

import hashlib
import json
import math
import random
import time
from dataclasses import dataclass, field
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment
from ..cases.pool import Limits, run_cases
from ..cases.study_command import problem_of
from ..program import fingerprint
from ..program.machine_state import last_core, settings_of
from ..program.out_folder import claimed
from .instructions import ChildCounter, NotCounted, callgrind_prefix, read_callgrind, why_not_by_callgrind
from .result_set import MEASURED_FILE
from .usual_cases import What

TIMED, JUDGED, COUNTED = "timed", "judged", "counted"
PROGRAM_NAMES = ("before", "after")
FEWEST_REPETITIONS = 5
LEFT_OUT = "complete"  # as the pool calls what is not wanted


@dataclass(frozen=True)
class InterleavedCase(Case):
    what: What
    program: str  # one of PROGRAM_NAMES
    purpose: str = TIMED
    repetition: int = 0

    @property
    def name(self) -> str:
        return f"{self.what.name}-{f'r{self.repetition}' if self.purpose == TIMED else self.purpose}"

    @property
    def folder(self) -> str:
        return f"{self.program}/raw/{self.name}"

    @property
    def kind(self) -> str:
        return f"{self.purpose} {self.what.name}"

    @property
    def guessed_seconds(self) -> float:
        return self.what.seconds * (1 if self.purpose == TIMED else 3)

    def arguments(self, folders: Folders) -> list[str]:
        frames = self.what.counted_frames if self.purpose == COUNTED else self.what.frames
        words = ["run", self.what.scene, "--backend", self.what.backend, "--threads", "1", "--frames", str(frames),
                 "--repetition", str(self.repetition)]
        words += ["--preset", self.what.preset] if self.what.preset else []
        words += [] if self.purpose == JUDGED else ["--no-referee"]
        for key, value in self.what.parameters:
            words += ["--param", f"{key}={value}"]
        return words + (["--data", str(folders.data_dir)] if folders.data_dir is not None else [])

    def input_digests(self) -> dict[str, str]:
        scene = Path(self.what.scene)
        return {"scene_sha256": fingerprint.file_digest(scene)} if scene.suffix == ".toml" else {}

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.what.scene, "preset": self.what.preset, "backend": self.what.backend,
                "parameters": dict(self.what.parameters), "threads": 1, "repetition": self.repetition}


@dataclass
class Plan:
    """What is run, in which order."""

    cases: list[InterleavedCase]
    notes: list[str] = field(default_factory=list)  # what can't be measured here, and why


def plan(wanted: list[What], programs: tuple[str, ...], seed: int = 1) -> Plan:
    """What is run once first; then repetition by repetition, within one the cases in random order, and the programs of a
    case next to each other."""
    order, why_not = random.Random(seed), why_not_by_callgrind()
    cases = [InterleavedCase(what, program, purpose) for purpose in (JUDGED, COUNTED) for what in wanted for program in programs
             if (what.is_judged if purpose == JUDGED else what.counted_frames and not why_not)]
    for repetition in range(max(what.repetitions for what in wanted)):
        due = [what for what in wanted if repetition < what.repetitions]
        order.shuffle(due)
        for what in due:
            cases += [InterleavedCase(what, program, TIMED, repetition) for program in order.sample(programs, len(programs))]
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
        if case.purpose == TIMED and case.repetition not in self._begun:
            if time.monotonic() > self._end:
                return False
            self._begun.add(case.repetition)
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
        counters = {"instructions": read_callgrind(folder.parent)} if case.purpose == COUNTED else {}
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
