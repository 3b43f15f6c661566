"""The rules of cases from an experiment file: recordings that replays share, what has ended well, what is not run."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment, Refusal
from ..cases.progress import duration
from ..hard import cell_folder
from ..program import fingerprint
from ..results.status import MEASURED
from .kernels import KernelPrograms, micro_beside
from .record_case import RecordCase
from .swept_case import SweptCase

RESULT_DIRS = ("raw", "recordings")
STRUCTURES_DIR = "structures"
HASH_OF_MODE = {"replay": "contact_hash", "coupled": "state_hash"}


class SweptExperiment(Experiment):
    def __init__(self, binary: Path, folders: Folders, answers: tuple[str, ...] = (), force: bool = False,
                 micro: Path | None = None, keeps_programs: bool = False):
        """`answers`: statuses beside those of measured cases that are not run again. `micro`: the program of kernels, where
        it is not beside the program."""
        super().__init__(binary, folders, force, keeps_programs)
        self._kernels = KernelPrograms(micro or micro_beside(binary))
        self.final_statuses = MEASURED | set(answers)
        self._recordings: dict[str, str] = {}  # digest by path

    def is_complete(self, case: Case) -> bool:
        if isinstance(case, RecordCase) and not (self.folder(case) / case.file_name).is_file():
            return False
        return super().is_complete(case)

    def command(self, case: Case, folder: Path) -> list[str]:
        return self._kernels.command(case, self.folders, folder) if _has_mode(case, "kernels") else super().command(case, folder)

    def more_inputs(self, case: Case) -> dict[str, str]:
        if _has_mode(case, "kernels"):
            return self._kernels.inputs(case, self.folders)
        return {"recording_sha256": self._recording_digest(case.recording)} if _has_mode(case, "replay") else {}

    def is_ever_run(self, case: Case) -> bool:
        return not case.is_too_long and not (_has_mode(case, "kernels") and not self._kernels.is_built(case))

    def refusal(self, case: Case) -> Refusal | None:
        if _has_mode(case, "kernels"):
            return None if self._kernels.is_built(case) else Refusal("unsupported", f"not built: {case.group.program}")
        if not self.is_ever_run(case):
            a_step = f"{case.guessed_collision_seconds:.2g} s"
            whole, longest = duration(case.guessed_seconds), duration(case.group.longest_s)
            return Refusal("timeout", f"not run: {case.steps} steps of about {a_step} would take about {whole}, over {longest}")
        if _has_mode(case, "replay") and not self.is_complete(case.recording):
            return Refusal("failed", f"not run: there is no recording; {self._reason(case.recording)}")
        return None

    def ended_well(self, case: Case, exit_code: int) -> bool:
        """A hard case that breaks is an answer."""
        return exit_code == 0 or (_has_mode(case, "hard") and exit_code in cell_folder.STATUS)

    def prepare(self, case: Case, folder: Path) -> None:
        """A recording is a file and wants its folder. A builder finds nothing built, so that its building time is real;
        in a shared folder that time is noted beside what it finds."""
        if isinstance(case, RecordCase):
            folder.mkdir()
        elif _has_mode(case, "kernels"):
            self._kernels.prepare(case, self.folders, folder)
        elif case.builder:
            structures = case.structures(self.folders)
            if case.builder == case.name and self.folders.structures_dir is None:
                shutil.rmtree(structures, ignore_errors=True)
            structures.mkdir(parents=True, exist_ok=True)

    def complete(self, case: Case, folder: Path, exit_code: int) -> None:
        """`musclebench record` leaves a recording, `hard` a matrix, kernels what Google Benchmark writes; their rows are
        written here."""
        if _has_mode(case, "kernels"):
            self._kernels.describe(case, folder)
        if _has_mode(case, "hard"):
            cell_folder.describe(folder, case.record(), exit_code)
        if not isinstance(case, RecordCase) or not (folder / case.file_name).is_file():
            return
        recording = folder / case.file_name
        told = {"file": case.file, "bytes": recording.stat().st_size, "file_sha256": fingerprint.file_digest(recording)}
        record = {"schema_version": 1, "status": "ok", "status_detail": "", "case": case.record(), "recording": told}
        (folder / "run.json").write_text(json.dumps(record) + "\n")
        self._recordings.pop(case.file, None)

    def remove_structures(self) -> None:
        """They can be built again at any time, and are large."""
        shutil.rmtree(self.folders.out_dir / STRUCTURES_DIR, ignore_errors=True)

    def mark_nondeterministic(self, cases: list[SweptCase]) -> list[SweptCase]:
        """Marks the repetitions that answered something else than the first, and returns them."""
        firsts = {replace(case, repetition=0): case for case in cases if case.repetition == 0}
        return [case for case in cases if case.repetition > 0
                and (first := firsts.get(replace(case, repetition=0))) is not None and self._mark(first, case)]

    def _mark(self, first: SweptCase, case: SweptCase) -> bool:
        key = HASH_OF_MODE.get(case.mode)
        expected, record = self.run_record(first), self.run_record(case)
        if key is None or expected.get("status") not in MEASURED or record.get("status") not in MEASURED | {"nondeterministic"}:
            return False
        if record.get(key) == expected.get(key):
            return False
        words = key.replace("_", " ")
        record |= {"status": "nondeterministic",
                   "status_detail": f"{words} {record.get(key)}, but {expected.get(key)} in repetition 0"}
        fingerprint.write_whole(self.folder(case) / "run.json", json.dumps(record) + "\n")
        return True

    def run_record(self, case: Case) -> dict:
        """Its run.json; empty where there is none."""
        try:
            told = json.loads((self.folder(case) / "run.json").read_text())
        except (OSError, ValueError):
            return {}
        return told if isinstance(told, dict) else {}

    def _recording_digest(self, case: RecordCase) -> str:
        """Empty while there is no recording."""
        if case.file not in self._recordings:
            path = self.folders.out_dir / case.file
            self._recordings[case.file] = fingerprint.file_digest(path) if path.is_file() else ""
        return self._recordings[case.file]

    def _reason(self, case: RecordCase) -> str:
        return self.run_record(case).get("status_detail") or f"see {self.folder(case)}"


def _has_mode(case: Case, mode: str) -> bool:
    return isinstance(case, SweptCase) and case.group.mode == mode
