"""Kernels of Google Benchmark as cases: which ones a group names, how their program is asked, the run.json of what it left."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..cases.case import Folders
from ..program import fingerprint
from ..program.machine_state import Reading, last_core, reading, told_between
from ..program.registry import Registry
from .experiment_file import CaseGroup

if TYPE_CHECKING:
    from .swept_case import SweptCase

KERNELS_FILE = "kernels.json"
MICRO_PROGRAM = CaseGroup.program


def micro_beside(binary: Path) -> Path:
    """The kernels' program that is built along with a program."""
    return binary.resolve().parent / "micro" / MICRO_PROGRAM


def pattern_of(group: CaseGroup, registry: Registry) -> str:
    """A regular expression of the kernels that the group names, and the [[target]]s of the backends' studies for it, all of
    whose sizes, bones or backends {} stands for. Empty where it has none."""
    told = [target for backend in registry.backends for target in backend.study.get("target", [])]
    named = [target[key] for target in told if target["group"] == group.name for key in ("kernel", "below") if key in target]
    stems = sorted({name.partition("{}")[0].rstrip("/") for name in [*named, *group.kernels]})
    if not stems:
        return ""
    sizes = f"/({'|'.join(map(str, group.sizes))})" if group.sizes else ""
    return f"^({'|'.join(stems)}){sizes}(/|$)"


def sampling(group: CaseGroup) -> list[str]:
    """Options of Google Benchmark: samples of all kernels in random order, so that what slows the machine meets all alike."""
    if group.samples == 1:
        return []
    return [f"--benchmark_repetitions={group.samples}", f"--benchmark_min_time={group.sample_s:g}",
            "--benchmark_enable_random_interleaving=true", "--benchmark_report_aggregates_only=false"]


class KernelPrograms:
    """`micro`: the program of most kernels, whatever its name; those of other groups are beside it, and are only built where
    their libraries are installed."""

    def __init__(self, micro: Path):
        self._micro = micro.resolve()
        self._digests: dict[Path, str] = {}
        self._before: dict[str, Reading] = {}  # by the case's name

    def is_built(self, case: "SweptCase") -> bool:
        return self._program(case).is_file()

    def command(self, case: "SweptCase", folders: Folders, folder: Path) -> list[str]:
        words = [*case.arguments(folders), *case.output(folder)]
        return ["env", *self._environment(case, folders), str(self._program(case)), *words]

    def inputs(self, case: "SweptCase", folders: Folders) -> dict[str, str]:
        """What the result depends on beside the arguments."""
        return {"kernels_sha256": self._digest(self._program(case)),
                "environment": " ".join(self._environment(case, folders.symbolic()))}

    def prepare(self, case: "SweptCase", folders: Folders, folder: Path) -> None:
        case.structures(folders).mkdir(parents=True, exist_ok=True)
        folder.mkdir()
        self._before[case.name] = reading(last_core())

    def describe(self, case: "SweptCase", folder: Path) -> None:
        """How it ended, and on what, as the program writes it: kernels are built along with it, and nothing else runs
        meanwhile."""
        if not (folder / KERNELS_FILE).is_file():
            return
        state = told_between(self._before.pop(case.name), reading(last_core()))
        record = {"status": "ok", "status_detail": "", "case": case.record(), **case.scene.origin, **state}
        (folder / "run.json").write_text(json.dumps(record) + "\n")

    def _environment(self, case: "SweptCase", folders: Folders) -> list[str]:
        """Assignments of the variables that tell the kernels what to measure."""
        words = [f"MUSCLEBENCH_MICRO_SCENE={case.scene.name}", f"MUSCLEBENCH_MICRO_STRUCTURES={case.structures(folders)}"]
        return words + ([f"MUSCLEBENCH_DATA={folders.data_dir}"] if folders.data_dir is not None else [])

    def _program(self, case: "SweptCase") -> Path:
        return self._micro if case.group.program == MICRO_PROGRAM else self._micro.parent / case.group.program

    def _digest(self, program: Path) -> str:
        """Empty where it is not built."""
        if program not in self._digests:
            self._digests[program] = fingerprint.file_digest(program) if program.is_file() else ""
        return self._digests[program]
