"""Measures a night: tonight's program, and where it is another one the last night's beside it, interleaved."""

import json
import os
import shutil
import subprocess
import uuid
from dataclasses import dataclass, field
from pathlib import Path

from ..cases.case import Folders
from ..comparison.comparison_report import shown
from ..comparison.metrics import EXACT
from ..comparison.interleaved import PROGRAM_NAMES, InterleavedExperiment, measure, plan
from ..comparison.result_set import ResultSet, read_set
from ..comparison.verdicts import compare
from ..experiments.experiment_file import ExperimentFile
from ..experiments.swept_case import SweptCase
from ..program import children
from ..program.fingerprint import file_digest, write_whole
from .history import Finding

BEFORE, AFTER = PROGRAM_NAMES
NIGHT_FILE = "night.json"
MATRIX = "hard/matrix.csv"
PROGRAMS = "programs"  # of earlier nights, by digest


@dataclass
class MeasuredNight:
    folder: Path
    started: str
    notes: list[str] = field(default_factory=list)

    @property
    def results(self) -> ResultSet:
        return read_set(self.folder / AFTER, "tonight")

    @property
    def matrix(self) -> Path:
        return self.folder / MATRIX

    def same_night_findings(self, night: int) -> list[Finding]:
        """Times and counters beside those of the last night's program, which ran interleaved. Answers are in the history."""
        if not (self.folder / BEFORE / "raw").is_dir():
            return []
        compared = compare(read_set(self.folder / BEFORE, "the last night's program"), self.results)
        return [Finding(row.case, row.metric.name, night, "beside the last night's program", shown(row.before, row.metric),
                        shown(row.after, row.metric),
                        *((row.ratio.value, row.ratio.low, row.ratio.high, row.chance) if row.ratio.frames else ()))
                for row in compared.changes if row.metric.kind != EXACT]


def measure_night(folder: Path, started: str, program: Path, kept: Path | None, firsts: list[SweptCase],
                  file: ExperimentFile, seconds: float, hard_seconds: float) -> MeasuredNight:
    """`firsts`: cases of the file without repetitions. `kept`: the last night's program; None: it is the same, or not there.
    `seconds`: for all, of which `hard_seconds` are for the matrix; 0: without."""
    night = MeasuredNight(folder, started)
    programs = {BEFORE: kept, AFTER: program} if kept else {AFTER: program}
    planned = plan(firsts, file, tuple(programs))
    experiment = InterleavedExperiment(programs, Folders(folder.absolute()), uuid.uuid4().hex, seconds - hard_seconds)
    night.notes = planned.notes + measure(planned.cases, experiment, file.timeout_s)
    if experiment.repetitions < planned.repetitions:
        night.notes.append(f"{experiment.repetitions} of {planned.repetitions} repetitions: time was up (--minutes)")
    if hard_seconds:
        night.notes += _run_matrix(program, night.matrix.parent, hard_seconds)
    write_whole(folder / NIGHT_FILE, json.dumps({"started": started, "notes": night.notes}) + "\n")
    return night


def read_night(folder: Path) -> MeasuredNight:
    """One that was measured, and could not be appended."""
    told = json.loads((folder / NIGHT_FILE).read_text())
    return MeasuredNight(folder, told["started"], told["notes"])


def keep_program(program: Path, out_dir: Path) -> None:
    """For the next night; those of earlier ones go."""
    kept = out_dir / PROGRAMS / file_digest(program)
    kept.parent.mkdir(parents=True, exist_ok=True)
    if not kept.is_file():
        part = kept.with_name(f".{kept.name}.{os.getpid()}")
        shutil.copy(program, part)
        os.replace(part, kept)
    for other in kept.parent.iterdir():
        if other != kept:
            other.unlink()


def kept_program(digest: str, program: Path, out_dir: Path) -> Path | None:
    """That of the last night, where tonight's is another."""
    kept = out_dir / PROGRAMS / digest
    return kept if digest and kept.is_file() and file_digest(program) != digest else None


def _run_matrix(program: Path, folder: Path, seconds: float) -> list[str]:
    folder.mkdir(parents=True, exist_ok=True)
    # Ended politely, it ends the processes of its cells.
    with children.started([str(program), "hard", "--out", str(folder)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                 text=True) as process:
        try:
            _, told = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            return [f"the matrix of hard cases took longer than {seconds:g} s and is left out (--hard-seconds)"]
    if process.returncode not in (0, 1):  # held, broken
        return [f"the matrix of hard cases is left out: {(told.strip().splitlines() or ['no message'])[-1]}"]
    return []
