"""The accuracy study as an experiment: recordings and structures that cases share, and what its cases must agree on."""

import json
import shutil
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment, Refusal
from ..cases.progress import duration
from ..program import fingerprint
from .study_cases import MeasuredCase, ProbeCase, RecordCase, ReplayCase
from .study_plan import StudyCase, is_too_long
from ..results.status import MEASURED

RESULT_DIRS = ("raw", "recordings")
STRUCTURES_DIR = "structures"
HASH_OF_MODE = {"replay": "contact_hash", "coupled": "state_hash"}


class AccuracyStudy(Experiment):
    # A case that failed, ran out of time or out of memory is tried again at the next start.
    final_statuses = MEASURED | {"diverged", "unsupported", "nondeterministic"}

    def __init__(self, binary: Path, folders: Folders, force: bool = False):
        super().__init__(binary, folders, force)
        self._recordings: dict[str, str] = {}  # digest by path

    def is_complete(self, case: Case) -> bool:
        if isinstance(case, RecordCase) and not (self.folder(case) / case.file_name).is_file():
            return False
        return super().is_complete(case)

    def more_inputs(self, case: Case) -> dict[str, str]:
        if not isinstance(case, ReplayCase):
            return {}
        return {"recording_sha256": self._recording_digest(case.recording)}

    def is_ever_run(self, case: Case) -> bool:
        return not is_too_long(case)

    def refusal(self, case: Case) -> Refusal | None:
        if is_too_long(case):
            a_step = f"{case.configuration.step_ms * case.scene.size / 1e3:.2g} s"
            whole = duration(case.guessed_seconds)
            return Refusal("timeout", f"not run: {case.steps} steps of about {a_step} would take about {whole}, over "
                                      f"{duration(case.longest_seconds)}")
        if isinstance(case, ReplayCase) and not super().is_complete(case.recording):
            return Refusal("failed", f"not run: there is no recording; {self._reason(case.recording)}")
        return None

    def prepare(self, case: Case, folder: Path) -> None:
        """A recording is a file and wants its folder. A probe finds nothing built: its building time is real."""
        if isinstance(case, RecordCase):
            folder.mkdir()
        elif case.configuration.stores:
            structures = self.folders.out_dir / case.structures
            if isinstance(case, ProbeCase):
                shutil.rmtree(structures, ignore_errors=True)
            structures.mkdir(parents=True, exist_ok=True)

    def complete(self, case: Case, folder: Path) -> None:
        """`musclebench record` leaves a recording; its row is written here."""
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

    def mark_nondeterministic(self, cases: list[StudyCase]) -> list[StudyCase]:
        """Marks the repetitions that answered something else than the first, and returns them."""
        firsts = {_group(case): case for case in cases if isinstance(case, MeasuredCase) and case.repetition == 0}
        repeated = [case for case in cases if isinstance(case, MeasuredCase) and case.repetition > 0]
        return [case for case in repeated if _group(case) in firsts and self._mark(firsts[_group(case)], case)]

    def _mark(self, first: MeasuredCase, case: MeasuredCase) -> bool:
        key = HASH_OF_MODE.get(case.mode)
        expected, record = self._run_record(first), self._run_record(case)
        if expected.get("status") not in MEASURED or record.get("status") not in MEASURED | {"nondeterministic"}:
            return False
        if record.get(key) == expected.get(key):
            return False
        words = key.replace("_", " ")
        record |= {"status": "nondeterministic",
                   "status_detail": f"{words} {record.get(key)}, but {expected.get(key)} in repetition 0"}
        path = self.folder(case) / "run.json"
        fingerprint.write_whole(path, json.dumps(record) + "\n")
        return True

    def _run_record(self, case: StudyCase) -> dict:
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
        return self._run_record(case).get("status_detail") or f"see {self.folder(case)}"


def _group(case: MeasuredCase) -> tuple:
    return case.mode, case.scene.name, case.configuration.label
