"""One reader under libFuzzer: the program that feeds it, the corpus that grows, and what was found."""

import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..program.children import started
from ..program.cli import Problem

PROGRAM_NAME = "fuzz_readers"
SLOWEST_INPUT_S, MOST_MEMORY_MB, LARGEST_INPUT_BYTES = 10, 2048, 1 << 15
LIMITS = [f"-timeout={SLOWEST_INPUT_S}", f"-rss_limit_mb={MOST_MEMORY_MB}", f"-max_len={LARGEST_INPUT_BYTES}"]
LOOK_S = 1.0
FINDINGS = ("crash-*", "leak-*", "timeout-*", "oom-*")


@dataclass(frozen=True)
class Fuzzer:
    reader: str
    program: Path
    corpus: Path  # in the sources; of some readers the program makes all


@dataclass(frozen=True)
class Progress:
    executions: int = 0
    coverage: int = 0  # of libFuzzer's counters, those that were reached


@dataclass(frozen=True)
class Outcome:
    fuzzer: Fuzzer
    progress: Progress
    corpus_files: int
    findings: list[Path] = field(default_factory=list)
    report: str = ""  # the line in which libFuzzer says what is wrong

    @property
    def line(self) -> str:
        found = "no findings" if not self.findings else \
            f"{len(self.findings)} finding{'s' if len(self.findings) > 1 else ''}: {self.report}; {self.findings[-1]}"
        return (f"{self.fuzzer.reader:16} {self.progress.executions:>10} executions, coverage {self.progress.coverage}, "
                f"corpus of {self.corpus_files} files, {found}")


def find_fuzzers(build: Path, sources: Path) -> list[Fuzzer]:
    """Of all programs in the build; a folder there is that of its sources."""
    fuzzers = []
    for program in sorted(build.rglob(PROGRAM_NAME)):
        listed = subprocess.run([program, "--list"], capture_output=True, text=True, check=False)
        if listed.returncode != 0:
            raise Problem(f"{program}: does not list its readers; remove the build folder, and tools/fuzz builds it again")
        corpus = sources / program.parent.relative_to(build) / "corpus"
        fuzzers += [Fuzzer(reader, program, corpus / reader) for reader in listed.stdout.split()]
    return fuzzers


def progress_in(log: str) -> Progress:
    """The last that the log tells."""
    executed = re.findall(r"^stat::number_of_executed_units: (\d+)", log, re.MULTILINE) or re.findall(r"^#(\d+)", log, re.MULTILINE)
    covered = re.findall(r"\bcov: (\d+)", log)
    return Progress(int(executed[-1]) if executed else 0, int(covered[-1]) if covered else 0)


def report_in(log: str) -> str:
    """What the sanitizer or the reader's own exception says, in one line."""
    for pattern in (r"runtime error: .*", r"^  what\(\): .*", r"^SUMMARY: .*", r"ERROR: .*"):
        if found := re.search(pattern, log, re.MULTILINE):
            return found.group(0).strip()
    return "see the log"


class Campaign:
    """A reader's folder of results: `corpus`, `findings` and libFuzzer's log."""

    def __init__(self, fuzzer: Fuzzer, folder: Path):
        self.fuzzer, self.folder = fuzzer, folder
        self.corpus, self.findings, self.log = folder / "corpus", folder / "findings", folder / "log.txt"
        for each in (self.corpus, self.findings):
            each.mkdir(parents=True, exist_ok=True)

    def run(self, seconds: float, tell: Callable[[Progress, float], None]) -> Outcome:
        """Ends at the first finding: what comes after it would mostly be the same once more."""
        with tempfile.TemporaryDirectory(prefix="musclebench-fuzz-") as scratch:
            starts = self._starts(Path(scratch))
            before = set(self._found())
            command = [f"-max_total_time={max(1, round(seconds))}", "-print_final_stats=1",
                       f"-artifact_prefix={self.findings}/", str(self.corpus), *map(str, starts)]
            code = self._call(command, Path(scratch), tell)
            log = self.log.read_text(errors="replace")
            found = [path for path in self._found() if path not in before]
            if code != 0 and not found:
                raise Problem(f"{self.fuzzer.program} --reader={self.fuzzer.reader} ended with {code}; {self.log} tells why")
            self._minimise(starts, Path(scratch))
        return Outcome(self.fuzzer, progress_in(log), len(list(self.corpus.iterdir())), found, report_in(log) if found else "")

    def _found(self) -> Iterator[Path]:
        return (path for pattern in FINDINGS for path in self.findings.glob(pattern))

    def _starts(self, scratch: Path) -> list[Path]:
        seeds = scratch / "seeds"
        seeds.mkdir()
        done = subprocess.run([self.fuzzer.program, f"--reader={self.fuzzer.reader}", f"--write-seeds={seeds}"], check=False)
        if done.returncode != 0:
            raise Problem(f"{self.fuzzer.program}: cannot write its seeds for '{self.fuzzer.reader}'")
        return [seeds, *([self.fuzzer.corpus] if self.fuzzer.corpus.is_dir() else [])]

    def _call(self, arguments: list[str], scratch: Path, tell: Callable[[Progress, float], None] | None) -> int:
        """libFuzzer's exit code. Files that a killed reader leaves are in the scratch folder."""
        command = ["nice", "-n", "10", str(self.fuzzer.program), f"--reader={self.fuzzer.reader}", *LIMITS, *arguments]
        begin = time.monotonic()
        with open(self.log, "w") as log, started(command, stdout=log, stderr=log, cwd=scratch,
                                                  env={**os.environ, "TMPDIR": str(scratch)}) as process:
            while True:
                try:
                    return process.wait(LOOK_S)
                except subprocess.TimeoutExpired:
                    if tell:
                        tell(progress_in(self.log.read_text(errors="replace")), time.monotonic() - begin)

    def _minimise(self, starts: list[Path], scratch: Path) -> None:
        """Keeps the smallest files that reach what all of them do."""
        least = scratch / "least"
        least.mkdir()
        log, self.log = self.log, scratch / "merge.txt"
        code = self._call(["-merge=1", str(least), str(self.corpus), *map(str, starts)], scratch, None)
        self.log = log
        if code != 0:
            return  # a finding in the way: the corpus stays as it grew
        whole = self.folder / ".corpus"  # what is left of an interrupted copy goes with the next run
        shutil.copytree(least, whole)
        shutil.rmtree(self.corpus)
        whole.rename(self.corpus)
