"""The build of a scratch tree: which test programs a change reaches, and whether they pass."""

import os
import re
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

CMAKE_OPTIONS = ("-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DMUSCLEBENCH_WITH_TESTS=ON",
                 "-DMUSCLEBENCH_WITH_MICRO=OFF", "-DMUSCLEBENCH_WERROR=OFF",
                 # Building takes longer than testing: half of it goes without the last optimisations.
                 "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG",
                 # Else a faulty program is run while it is built.
                 "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST")
LINKED = re.compile(r"Linking CXX executable (\S+_tests)$")
PROGRAM_RULE = re.compile(r"^(\S+_tests): CXX_EXECUTABLE_LINKER")
FAILED_TEST = re.compile(r"^\[  FAILED  \] ([\w/.]+)", re.MULTILINE)


class BuildFailed(Exception):
    """The text of the first error."""


@dataclass(frozen=True)
class ProgramRun:
    passed: bool
    seconds: float
    detail: str = ""  # the first test that failed, or how the program ended


class ScratchBuild:
    def __init__(self, tree: Path, folder: Path, jobs: int):
        self._tree, self._folder, self._jobs = tree, folder, jobs

    def configure(self) -> None:
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        done = subprocess.run(["cmake", "-S", str(self._tree), "-B", str(self._folder), *CMAKE_OPTIONS, *launcher],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BuildFailed(_first_error(done.stderr))

    def programs(self) -> list[str]:
        """All test programs, as ninja names them."""
        lines = self._ninja("-t", "targets", "all").stdout.splitlines()
        return sorted(match[1] for line in lines if (match := PROGRAM_RULE.match(line)))

    def stale(self, programs: list[str]) -> list[str]:
        """Those that a build would link anew: what a change of a source or a header reaches."""
        output = self._ninja("-n", *programs).stdout
        if "Re-running CMake" in output:  # a dry run ends there and tells nothing of what follows
            raise BuildFailed("the build wants to be configured anew each time; a glob with CONFIGURE_DEPENDS does that")
        lines = output.splitlines()
        linked = {match[1] for line in lines if (match := LINKED.search(line))}
        return [program for program in programs if program in linked]

    def build(self, programs: list[str]) -> None:
        done = self._ninja(f"-j{self._jobs}", *programs)
        if done.returncode != 0:
            raise BuildFailed(_first_error(done.stdout))

    def run(self, program: str, timeout_s: float) -> ProgramRun:
        """One run that ends at the first failure. What is not in the sources is not there for it."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("MUSCLEBENCH_")}
        start = time.monotonic()
        try:
            done = subprocess.run([str(self._folder / program), "--gtest_fail_fast", "--gtest_brief=1"],
                                  cwd=(self._folder / program).parent, env=environment | {"OMP_NUM_THREADS": "2"},
                                  capture_output=True, text=True, errors="replace", timeout=timeout_s, check=False)
        except subprocess.TimeoutExpired:
            return ProgramRun(False, time.monotonic() - start, f"no end within {timeout_s:.0f} s")
        failed = FAILED_TEST.search(done.stdout)
        detail = failed[1] if failed else f"exit code {done.returncode}"
        return ProgramRun(done.returncode == 0, time.monotonic() - start, detail if done.returncode != 0 else "")

    def _ninja(self, *arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run(["ninja", "-C", str(self._folder), *arguments], capture_output=True, text=True,
                              check=False)


def nearest_first(programs: list[str], file: str, seconds: dict[str, float]) -> list[str]:
    """Test programs of the file's own folder, then of folders around it, short ones first."""
    def shared_folders(program: str) -> int:
        ours, theirs = Path(file).parts[:-1], Path(program).parts[:-1]
        return len(os.path.commonprefix([ours, theirs]))

    return sorted(programs, key=lambda program: (-shared_folders(program), seconds.get(program, 0.0), program))


def _first_error(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if re.search(r"\berror\b|undefined reference", line, re.I)]
    return lines[0] if lines else (output.strip().splitlines() or ["no message"])[-1]
