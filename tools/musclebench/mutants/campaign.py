"""Goes through the faults one by one and keeps the verdicts, so that an interrupted campaign goes on where it was."""

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from pathlib import Path

from .faults import MOST_SURVIVORS, Fault, read_seen
from .python_tests import PythonTests
from .scratch_tree import refresh
from .scratch_build import BuildFailed, ScratchBuild, nearest_first

LEAST_TIMEOUT_S = 60.0
PYTHON_TIMEOUT_S = 900.0
TIMEOUT_FACTOR = 10.0  # of a program's time without a fault: a fault that never ends is seen, too


@dataclass(frozen=True)
class Verdict:
    outcome: str  # seen, survived, unbuildable
    detail: str = ""  # the program and test that saw it; the message of the compiler
    seconds: float = 0.0


class Campaign:
    """`folder` holds the copy of the sources, the build and the verdicts. `seen`: a file of the faults that tests saw,
    in whatever campaign; they are not judged again, and what is seen now is added."""

    def __init__(self, root: Path, folder: Path, build: ScratchBuild, seen: Path | None = None, pattern: str = "*"):
        self._root, self._tree, self._verdict_file = root, folder / "tree", folder / "verdicts.json"
        self._build, self._seen, self._pattern = build, seen, pattern
        self._python = PythonTests(self._tree)
        self._state = ""
        self._seconds: dict[str, float] = {}  # of each program without a fault
        self.verdicts: dict[str, Verdict] = {}

    def prepare(self, faults: list[Fault]) -> None:
        """Copies and builds the sources as they are and runs every test program once: only what passes can see a
        fault. Faults in Python alone need no build. Raises BuildFailed."""
        self._tree.mkdir(parents=True, exist_ok=True)
        self._state = refresh(self._root, self._tree)
        self._read_verdicts()
        if all(fault.is_python or fault.key in self.verdicts for fault in faults):
            return
        self._build.configure()
        programs = self._programs()
        _tell(f"building {len(programs)} test programs without a fault ...")
        self._build.build(programs)
        for program in [program for program in programs if program not in self._seconds]:
            run = self._build.run(program, timeout_s=3600)
            if not run.passed:
                raise BuildFailed(f"{program} fails without a fault: {run.detail}")
            self._seconds[program] = run.seconds
        self._write_verdicts()

    def judge_all(self, faults: list[Fault]) -> None:
        left = [fault for fault in faults if fault.key not in self.verdicts]
        if len(left) < len(faults):
            _tell(f"{len(faults) - len(left)} of {len(faults)} faults were judged before")
        start = time.monotonic()
        for number, fault in enumerate(left, 1):
            verdict = self._judge(fault)
            self.verdicts[fault.key] = verdict
            self._write_verdicts()
            left_s = (time.monotonic() - start) / number * (len(left) - number)
            _tell(f"[{number}/{len(left)}] {fault.name}: {verdict.outcome} ({verdict.detail or 'by no test'}), "
                  f"{verdict.seconds:.0f} s; about {left_s / 60:.0f} min left")

    def verdict(self, fault: Fault) -> Verdict:
        return self.verdicts[fault.key]

    def _programs(self) -> list[str]:
        return [program for program in self._build.programs() if fnmatch(program, self._pattern)]

    def _judge(self, fault: Fault) -> Verdict:
        start = time.monotonic()
        if fault.is_python:
            outcome, detail = self._python_outcome(fault)
        else:
            with self._put_in(fault):
                outcome, detail = self._outcome(fault)
        return Verdict(outcome, detail, round(time.monotonic() - start, 1))

    @contextmanager
    def _put_in(self, fault: Fault) -> Iterator[None]:
        path = self._tree / fault.file
        whole = path.read_text()
        try:
            path.write_text(fault.put_into(whole))
            yield
        finally:
            path.write_text(whole)

    def _python_outcome(self, fault: Fault) -> tuple[str, str]:
        tests = [test for test in self._python.reached_by(fault.file) if fnmatch(test, self._pattern)]
        for test in tests:
            with self._put_in(fault):
                run = self._python.run(test, PYTHON_TIMEOUT_S)
            if not run.passed:
                self._require_well(test)
                return "seen", f"{Path(test).name}: {run.detail}"
        return "survived", "" if tests else "no test imports the file"

    def _require_well(self, test: str) -> None:
        """Only what passes without a fault can see one."""
        if test in self._seconds:
            return
        run = self._python.run(test, PYTHON_TIMEOUT_S)
        if not run.passed:
            raise BuildFailed(f"{test} fails without a fault: {run.detail}")
        self._seconds[test] = run.seconds

    def _outcome(self, fault: Fault) -> tuple[str, str]:
        reached = self._build.stale(self._programs())
        for program in nearest_first(reached, fault.file, self._seconds):
            try:
                self._build.build([program])
            except BuildFailed as error:
                return "unbuildable", str(error)
            run = self._build.run(program, max(LEAST_TIMEOUT_S, TIMEOUT_FACTOR * self._seconds[program]))
            if not run.passed:
                return "seen", f"{Path(program).name}: {run.detail}"
        return "survived", "" if reached else "no test program links the file"

    def _read_verdicts(self) -> None:
        """Verdicts are those of one state of the sources; what was seen before may be taken as seen after a change."""
        if self._seen is not None:
            self.verdicts = {key: Verdict("seen", test) for key, test in read_seen(self._seen).items()}
        try:
            kept = json.loads(self._verdict_file.read_text())
        except (OSError, ValueError):
            return
        if kept["state"] == self._state:
            self._seconds = kept["seconds"]
            self.verdicts |= {key: Verdict(**verdict) for key, verdict in kept["verdicts"].items()}

    def _write_verdicts(self) -> None:
        is_final = self._pattern == "*"  # else a program that was not asked may see what survived
        whole = {"state": self._state, "seconds": self._seconds,
                 "verdicts": {key: asdict(verdict) for key, verdict in self.verdicts.items()
                              if is_final or verdict.outcome != "survived"}}
        _write_whole(self._verdict_file, whole)
        if self._seen is not None:
            seen = {key: verdict.detail for key, verdict in self.verdicts.items() if verdict.outcome == "seen"}
            _write_whole(self._seen, dict(sorted(seen.items())))


def summary(faults: list[Fault], campaign: Campaign) -> tuple[list[str], bool]:
    """What to print at the end, and whether all is well: every survivor has its reason, and they are few."""
    by_outcome: dict[str, list[Fault]] = {"seen": [], "survived": [], "unbuildable": []}
    for fault in faults:
        by_outcome[campaign.verdict(fault).outcome].append(fault)
    lines = [f"{len(faults)} faults: {len(by_outcome['seen'])} seen, {len(by_outcome['survived'])} survived, "
             f"{len(by_outcome['unbuildable'])} could not be built"]
    for fault in by_outcome["survived"]:
        lines.append(f"  survived: {fault.name} ({fault.file}): {fault.may_survive or 'a test is missing'}")
    for fault in by_outcome["unbuildable"]:
        lines.append(f"  not built: {fault.name} ({fault.file}): {campaign.verdict(fault).detail}")
    for fault in by_outcome["seen"]:
        if fault.may_survive:
            lines.append(f"  seen after all: {fault.name}: take its reason out of the list")
    unexcused = [fault for fault in by_outcome["survived"] if not fault.may_survive]
    is_well = not unexcused and not by_outcome["unbuildable"] and len(by_outcome["survived"]) <= MOST_SURVIVORS
    return lines, is_well


def _write_whole(file: Path, content: dict) -> None:
    part = file.with_suffix(".part")
    part.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    part.replace(file)


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
