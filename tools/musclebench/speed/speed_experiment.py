"""The speed table as an experiment of two programs: the harness and its kernels."""

import json
from pathlib import Path

from ..cases.case import Case, Folders
from ..cases.experiment import Experiment, Refusal
from ..program import fingerprint
from ..program.machine_state import Reading, last_core, reading, told_between

from .speed_cases import KERNELS_FILE, MICRO_PROGRAM, STRUCTURES_DIR, KernelCase, RaceCase
from ..results.status import MEASURED


class SpeedExperiment(Experiment):
    final_statuses = MEASURED | {"diverged", "unsupported"}

    def __init__(self, binary: Path, micro: Path, folders: Folders, force: bool = False):
        super().__init__(binary, folders, force)
        self._micro = micro.resolve()
        self._digests: dict[Path, str] = {}
        self._before: dict[Case, Reading] = {}

    def command(self, case: Case, folder: Path) -> list[str]:
        if not isinstance(case, KernelCase):
            return super().command(case, folder)
        return ["env", *case.environment(self.folders), str(self._program(case)), *case.arguments(self.folders),
                *case.output(folder)]

    def more_inputs(self, case: Case) -> dict[str, str]:
        if not isinstance(case, KernelCase):
            return {}
        return {"kernels_sha256": self._digest(self._program(case)),
                "environment": " ".join(case.environment(self.folders.symbolic()))}

    def is_ever_run(self, case: Case) -> bool:
        return not isinstance(case, KernelCase) or self._program(case).is_file()

    def refusal(self, case: Case) -> Refusal | None:
        if self.is_ever_run(case):
            return None
        return Refusal("unsupported", f"not built: {case.group.program}")

    def prepare(self, case: Case, folder: Path) -> None:
        (self.folders.out_dir / STRUCTURES_DIR).mkdir(exist_ok=True)
        if isinstance(case, KernelCase):
            folder.mkdir()
            self._before[case] = reading(last_core())

    def complete(self, case: Case, folder: Path, exit_code: int) -> None:
        """Google Benchmark leaves numbers; how the case ended, and on what, is written here as the program does.
        Kernels are built along with it, and one case runs at a time."""
        if isinstance(case, RaceCase) or not (folder / KERNELS_FILE).is_file():
            return
        state = told_between(self._before.pop(case), reading(last_core()))
        record = {"status": "ok", "status_detail": "", "case": case.record(), **case.scene.origin, **state}
        (folder / "run.json").write_text(json.dumps(record) + "\n")

    def _program(self, case: KernelCase) -> Path:
        """The kernels' program itself under whatever name it was given, or another one beside it."""
        return self._micro if case.group.program == MICRO_PROGRAM else self._micro.parent / case.group.program

    def _digest(self, program: Path) -> str:
        """Empty where it is not built."""
        if program not in self._digests:
            self._digests[program] = fingerprint.file_digest(program) if program.is_file() else ""
        return self._digests[program]

