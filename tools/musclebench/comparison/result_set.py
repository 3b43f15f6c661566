"""A folder of results as samples by case; what can't be read is left out and told, with file and line."""

import hashlib
import json
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from ..program.cli import Problem
from ..results.records import inner
from ..results.run_folder import ResultProblem, Run, read_run
from ..results.status import MEASURED
from .frame_times import COLUMNS, frame_times
from .instructions import PARTS
from .metrics import SHORTEST_NS, values_of

MEASURED_FILE = "measured.json"  # what was noted beside a run: on which core, interleaved with what, its counters
SCHEMAS = (1, 2)  # of run.json, that these tools read
REPETITION = re.compile(r"-(?:r(\d+)|judged|counted)$")
COUNTED = re.compile(r"-counted$")  # a run of its own, some fifty times slower
TIMED_OUT = "timeout"


@dataclass
class Sample:
    """Of one process."""

    run: Run
    measured: dict
    repetition: int | None
    values: dict[str, float | str]

    @property
    def invocation(self) -> str:
        """Samples of one invocation were interleaved."""
        return self.measured.get("invocation", "")

    @property
    def is_judged(self) -> bool:
        """By the Referee. Its times are then not the loop's, and only then its status says what the Referee found."""
        return bool(self.run.record.get("case", {}).get("judged"))

    @property
    def tells_times(self) -> bool:
        """Of its frames: nothing slowed it, neither the Referee nor counting."""
        return self.run.status in MEASURED and not self.is_judged and not self.measured.get("is_slowed")


@dataclass
class ResultSet:
    name: str
    cases: dict[str, list[Sample]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)  # of what was left out

    @property
    def samples(self) -> list[Sample]:
        return [sample for samples in self.cases.values() for sample in samples]

    def told(self, *keys: str) -> list:
        """The different values of run.json under these keys, the most frequent first; of runs that were measured."""
        found = Counter(json.dumps(inner(sample.run.record, *keys)) for sample in self.samples
                        if sample.run.status in MEASURED)
        return [json.loads(value) for value, _ in found.most_common()]

    def programs(self) -> set[str]:
        """Digests of the programs that were run; empty where that was not noted."""
        return {digest for sample in self.samples if (digest := sample.measured.get("binary_sha256", ""))}


def read_set(folder: Path, name: str = "") -> ResultSet:
    """`folder`: of a study, or of runs themselves."""
    raw = folder / "raw" if (folder / "raw").is_dir() else folder
    records = sorted(path for path in raw.glob("*/run.json") if not path.parent.name.startswith("."))
    if not records:
        raise Problem(f"{folder}: holds no results (no raw/CASE/run.json); name the folder of a study or of runs")
    found = ResultSet(name or str(folder))
    samples = []
    for record in records:
        try:
            samples.append(sample := _read_sample(record.parent))
            found.faults += _parts_missing(sample)
        except ResultProblem as problem:
            found.faults.append(str(problem))
    for sample in _that_ended(_of_one_schema(samples, found.faults), found.faults):
        found.cases.setdefault(_case_of(sample), []).append(sample)
    for samples in found.cases.values():
        add_frame_times(samples)
    return found


def _read_sample(folder: Path) -> Sample:
    measured = _read_measured(folder)
    fault = _broken_row(folder / "frames.csv")
    if fault:
        raise ResultProblem(fault)
    try:
        run = read_run(folder)
        values = values_of(run, measured)
    except (KeyError, TypeError, ValueError) as problem:
        raise ResultProblem(f"{folder / 'run.json'}: no record of a run ({problem!r}); run the case again") from None
    match = REPETITION.search(folder.name)
    repetition = int(match.group(1)) if match and match.group(1) else run.record["case"].get("repetition")
    return Sample(run, measured | _sealed(folder), repetition, values)


def _parts_missing(sample: Sample) -> list[str]:
    counted = sample.measured.get("counters", {})
    missing = [part for part in PARTS if part not in counted] if "instructions" in counted else []
    return [f"{sample.run.folder}: its {' and '.join(missing)} are not known; did the compiler inline what is counted?"] if missing else []


def match_frames(before: ResultSet, after: ResultSet) -> None:
    """Makes times of frames those of the same frames on both sides."""
    for case in before.cases.keys() & after.cases.keys():
        add_frame_times([*before.cases[case], *after.cases[case]])


def add_frame_times(samples: list[Sample]) -> None:
    """Of a case, whose runs have the same frames."""
    timed = [sample for sample in samples if sample.tells_times and len(sample.run.frames)]
    for column in COLUMNS:
        for sample, time in zip(timed, frame_times([sample.run for sample in timed], column)):
            if time is not None and time >= SHORTEST_NS:
                sample.values[column] = time


def _read_measured(folder: Path) -> dict:
    """Empty where nothing was noted. Files that are not those that were noted are refused."""
    path = folder / MEASURED_FILE
    if not path.is_file():
        return {}
    try:
        measured = json.loads(path.read_text())
        digests = measured["sha256"].items()
    except (ValueError, KeyError, AttributeError, TypeError):
        raise ResultProblem(f"{path}:1: not what these tools note beside a run; run the case again") from None
    for name, digest in digests:
        file = folder / name
        if not file.is_file() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
            raise ResultProblem(f"{path}:{_line_of(path, digest)}: says that {name} has the SHA-256 {str(digest)[:12]}..., "
                                "which it has not; run the case again")
    return measured


def _sealed(folder: Path) -> dict:
    """What the runner noted of the inputs."""
    try:
        sealed = json.loads((folder / "case.json").read_text())
        return {key: sealed[key] for key in ("binary_sha256", "data_sha256") if key in sealed}
    except (OSError, ValueError, TypeError):
        return {}


def _broken_row(path: Path) -> str:
    """The first row that has not as many cells as the heading, or whose line does not end."""
    if not path.is_file() or not path.stat().st_size:
        return ""
    heading, *rows = path.read_bytes().split(b"\n")
    columns = heading.count(b",") + 1
    for number, row in enumerate(rows, 2):
        is_last = number == len(rows) + 1
        if is_last and not row:
            return ""
        if row.count(b",") + 1 != columns or is_last:
            return f"{path}:{number}: truncated, {row.count(b',') + 1} of {columns} cells; run the case again"
    return f"{path}:1: truncated, no line ends; run the case again"


def _of_one_schema(samples: list[Sample], faults: list[str]) -> list[Sample]:
    """Those of the newest schema among them; the others are told."""
    told = [sample.run.record.get("schema_version") for sample in samples if sample.run.status in MEASURED]
    newest = max((schema for schema in told if schema in SCHEMAS), default=None)
    kept = []
    for sample in samples:
        schema, path = sample.run.record.get("schema_version"), sample.run.folder / "run.json"
        if sample.run.status not in MEASURED or schema == newest:
            kept.append(sample)
            continue
        why = f"others here have {newest}" if schema in SCHEMAS else f"these tools read {SCHEMAS[0]} to {SCHEMAS[-1]}"
        faults.append(f"{path}:{_line_of(path, 'schema_version')}: schema_version {schema}, {why}; left out")
    return kept


def _that_ended(samples: list[Sample], faults: list[str]) -> list[Sample]:
    """Without runs whose time was up where others of the case ended, and without those that counting slowed too much: that
    says something of the machine. Where no run of a case ended the program may hang, which is an answer."""
    ended = {_case_of(sample) for sample in samples if sample.run.status != TIMED_OUT and not COUNTED.search(sample.run.folder.name)}
    kept = []
    for sample in samples:
        is_counted = bool(COUNTED.search(sample.run.folder.name))
        if sample.run.status in MEASURED or not (is_counted or (sample.run.status == TIMED_OUT and _case_of(sample) in ended)):
            kept.append(sample)
        else:
            why = "its instructions are not counted" if is_counted else "others of its case ended"
            faults.append(f"{sample.run.folder}: ended as {sample.run.status}; {why}; left out")
    return kept


def _case_of(sample: Sample) -> str:
    return REPETITION.sub("", sample.run.folder.name)


def _line_of(path: Path, text: str) -> int:
    lines = path.read_text(errors="replace").splitlines()
    return next((number for number, line in enumerate(lines, 1) if str(text) in line), 1)
