"""The rules of cases from an experiment file: recordings that replays share, what has ended well, what is not run."""

import json
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment, Refusal
from ..cases.progress import duration
from ..program import fingerprint
from ..results.status import MEASURED
from ..study.study_cases import RecordCase
from .swept_case import SweptCase

RESULT_DIRS = ("raw", "recordings")


class SweptExperiment(Experiment):
    def __init__(self, binary: Path, folders: Folders, answers: tuple[str, ...] = (), force: bool = False):
        """`answers`: statuses beside those of measured cases that are not run again."""
        super().__init__(binary, folders, force)
        self.final_statuses = MEASURED | set(answers)
        self._recordings: dict[str, str] = {}  # digest by path

    def is_complete(self, case: Case) -> bool:
        if isinstance(case, RecordCase) and not (self.folder(case) / case.file_name).is_file():
            return False
        return super().is_complete(case)

    def more_inputs(self, case: Case) -> dict[str, str]:
        is_replay = isinstance(case, SweptCase) and case.group.mode == "replay"
        return {"recording_sha256": self._recording_digest(case.recording)} if is_replay else {}

    def is_ever_run(self, case: Case) -> bool:
        return isinstance(case, RecordCase) or not case.is_too_long

    def refusal(self, case: Case) -> Refusal | None:
        if not self.is_ever_run(case):
            return Refusal("timeout", f"not run: {case.steps} steps would take about {duration(case.guessed_seconds)}, over "
                                      f"{duration(case.group.longest_s)}")
        if isinstance(case, SweptCase) and case.group.mode == "replay" and not self.is_complete(case.recording):
            return Refusal("failed", f"not run: there is no recording; {self._reason(case.recording)}")
        return None

    def prepare(self, case: Case, folder: Path) -> None:
        """A recording is a file and wants its folder."""
        if isinstance(case, RecordCase):
            folder.mkdir()

    def complete(self, case: Case, folder: Path) -> None:
        """`musclebench record` leaves a recording; its row is written here."""
        if not isinstance(case, RecordCase) or not (folder / case.file_name).is_file():
            return
        recording = folder / case.file_name
        told = {"file": case.file, "bytes": recording.stat().st_size, "file_sha256": fingerprint.file_digest(recording)}
        record = {"schema_version": 1, "status": "ok", "status_detail": "", "case": case.record(), "recording": told}
        (folder / "run.json").write_text(json.dumps(record) + "\n")
        self._recordings.pop(case.file, None)

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
