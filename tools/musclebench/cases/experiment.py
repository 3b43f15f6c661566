"""What an experiment decides about its cases: their commands, when one counts as complete, what must not be run."""

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from ..program import fingerprint
from ..results.damage import damage
from .case import Case, Folders
from ..results.status import MEASURED

DAMAGED_DIR = "damaged"  # below the experiment's folder


@dataclass(frozen=True)
class Refusal:
    """Becomes the row of a case that is not run."""

    status: str
    detail: str
    last_lines: tuple[str, ...] = ()  # the end of what a process that failed said


class Experiment:
    """The program, its data, and where the results go. Experiments with rules of their own derive from it."""

    final_statuses = MEASURED  # a case that ended so is not run again

    def __init__(self, binary: Path, folders: Folders, force: bool = False, keeps_programs: bool = False):
        """`force`: complete cases are run again. `keeps_programs`: not those of another program."""
        self.binary, self.folders, self._force, self._keeps_programs = binary.resolve(), folders, force, keeps_programs
        self._binary_digest = fingerprint.file_digest(self.binary)
        self._data_digest = fingerprint.data_digest(folders.data_dir)

    def folder(self, case: Case) -> Path:
        return self.folders.out_dir / case.folder

    def command(self, case: Case, folder: Path) -> list[str]:
        return [str(self.binary), *case.arguments(self.folders), *case.output(folder)]

    def print_of(self, case: Case) -> dict:
        """What the result of a case depends on."""
        arguments = case.arguments(self.folders.symbolic())
        more = case.input_digests() | self.more_inputs(case)
        return fingerprint.fingerprint(arguments, self._binary_digest, self._data_digest, **more)

    def is_complete(self, case: Case) -> bool:
        status = fingerprint.status_when_sealed(self.folder(case), self.print_of(case), self._keeps_programs)
        return status in self.final_statuses and not damage(self.folder(case))

    def quarantine(self, case: Case) -> str:
        """Moves a folder that is not whole to where nothing reads it; one line with its path and what is wrong. Empty
        where the folder is whole or absent."""
        fault = damage(self.folder(case))
        if not fault:
            return ""
        kept_at = self.folders.out_dir / DAMAGED_DIR / case.name
        shutil.rmtree(kept_at, ignore_errors=True)
        kept_at.parent.mkdir(exist_ok=True)
        os.replace(self.folder(case), kept_at)
        return f"{self.folder(case)}: {fault}; kept as {kept_at} and run again"

    def wants(self, case: Case) -> bool:
        return self._force or not self.is_complete(case)

    def seal(self, case: Case, folder: Path) -> None:
        fingerprint.seal(folder, self.print_of(case))

    def more_inputs(self, case: Case) -> dict[str, str]:
        """Digests of further inputs, by name."""
        return {}

    def is_ever_run(self, case: Case) -> bool:
        """False for a case that leaves a row without costing any time."""
        return True

    def refusal(self, case: Case) -> Refusal | None:
        """Asked when its turn comes."""
        return None

    def prepare(self, case: Case, folder: Path) -> None:
        """Called just before a case starts; `folder` is not there yet, and `musclebench` makes it."""

    def ended_well(self, case: Case, exit_code: int) -> bool:
        return exit_code == 0

    def complete(self, case: Case, folder: Path, exit_code: int) -> None:
        """Adds to the folder of a process that ended well what the process did not write."""
