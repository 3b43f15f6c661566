"""One case in one process: started on cores of its own, followed by its progress lines, its folder put in place."""

import json
import os
import shutil
import signal
import subprocess
import threading
import time
from collections import deque
from contextlib import suppress
from pathlib import Path

from ..program.children import ENDS_WITH_PARENT, GRACE_SECONDS, end
from ..program.disk import DiskFull, says_disk_full
from ..program.machine_state import oom_kills
from ..results.damage import damage
from .case import Case
from .experiment import Experiment, Refusal

KEPT_LINES = 20
BAD_INPUT, UNSUPPORTED = 2, 6  # exit codes of musclebench
NO_MEMORY_WORDS = ("memory", "bad_alloc")


class Worker:
    """A running case. Its output grows in a hidden folder and gets its name in `finish`."""

    def __init__(self, case: Case, experiment: Experiment, cores: list[int], memory_bytes: int | None = None):
        self.case, self.cores = case, cores
        self.started, self._oom_kills = time.monotonic(), oom_kills()
        self.fraction = 0.0
        self._experiment = experiment
        self._final = experiment.folder(case)
        self._hidden = self._final.parent / f".{self._final.name}.{os.getpid()}"
        self._lines: deque[str] = deque(maxlen=KEPT_LINES)
        shutil.rmtree(self._hidden, ignore_errors=True)
        self._hidden.mkdir(parents=True)
        try:
            experiment.prepare(case, self._hidden / "run")
            self._process = self._start(limits(memory_bytes) + experiment.command(case, self._hidden / "run"))
        except OSError:
            shutil.rmtree(self._hidden, ignore_errors=True)
            raise
        self._end = os.pidfd_open(self._process.pid)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def elapsed(self) -> float:
        return time.monotonic() - self.started

    def fileno(self) -> int:
        """Can be read from when the process has ended."""
        return self._end

    def is_running(self) -> bool:
        return self._process.poll() is None

    def stop(self) -> None:
        """Ends the process, politely first, and removes what it has written."""
        end(self._process)
        self._close()
        shutil.rmtree(self._hidden, ignore_errors=True)

    def finish(self, timed_out: bool = False) -> str:
        """Moves the folder into place and returns its status; a run that left no run.json gets one that says why.
        Raises DiskFull, and then leaves nothing."""
        self._close()
        written = self._hidden / "run"
        try:
            code = self._process.returncode
            if self._experiment.ended_well(self.case, code):
                self._experiment.complete(self.case, written, code)
            if timed_out or not (written / "run.json").is_file():
                write_refusal(self.case, self._failure(timed_out), written)
            return put_in_place(self.case, self._experiment, written)
        finally:
            shutil.rmtree(self._hidden, ignore_errors=True)

    def kill_for_timeout(self) -> None:
        self._process.kill()
        self._process.wait()

    def _start(self, command: list[str]) -> subprocess.Popen:
        # A child inherits the affinity of the thread that starts it, so the cores are set here and put back at once.
        allowed = os.sched_getaffinity(0)
        os.sched_setaffinity(0, self.cores)
        try:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                    stderr=subprocess.PIPE, text=True, errors="replace", start_new_session=True)
        finally:
            os.sched_setaffinity(0, allowed)

    def _read(self) -> None:
        for line in self._process.stderr:
            words = line.split()
            if len(words) == 3 and words[0] == "progress" and words[1].isdigit() and words[2].isdigit():
                self.fraction = min(1.0, int(words[1]) / max(1, int(words[2])))
            elif words:
                self._lines.append(line.strip())

    def _close(self) -> None:
        # What the process has started and left behind would keep its core and its standard error.
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._reader.join(GRACE_SECONDS)
        self._process.stderr.close()
        os.close(self._end)

    def _failure(self, timed_out: bool) -> Refusal:
        lines = tuple(self._lines)
        if timed_out:
            return Refusal("timeout", f"stopped after {self.elapsed:.0f} s", lines)
        code, last = self._process.returncode, lines[-1] if lines else ""
        if says_disk_full(last):
            raise DiskFull(self._experiment.folders.out_dir)
        if code == UNSUPPORTED:
            return Refusal("unsupported", last, lines)
        ending = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        if code == -signal.SIGKILL and oom_kills() > self._oom_kills:
            return Refusal("out_of_memory", f"{ending}: the system had no memory left", lines)
        has_no_memory = code in (BAD_INPUT, -signal.SIGABRT) and any(words in last for words in NO_MEMORY_WORDS)
        return Refusal("out_of_memory" if has_no_memory else "failed", f"{ending}: {last or 'no message'}", lines)


def limits(memory_bytes: int | None) -> list[str]:
    """A command in front of the program's: it ends with this process, however that ends, and has no more memory."""
    return ENDS_WITH_PARENT + ([] if memory_bytes is None else ["prlimit", f"--as={memory_bytes}"])


def write_refusal(case: Case, refusal: Refusal, folder: Path) -> None:
    """The run.json of a case that has none of its own."""
    record = {"schema_version": 1, "status": refusal.status, "status_detail": refusal.detail, "case": case.record(),
              "last_lines": list(refusal.last_lines)}
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "run.json").write_text(json.dumps(record) + "\n")


def put_in_place(case: Case, experiment: Experiment, written: Path) -> str:
    """Seals a folder that is whole and gives it its name; its status."""
    experiment.seal(case, written)
    fault = damage(written)
    if fault:
        write_refusal(case, Refusal("failed", fault), written)
        experiment.seal(case, written)
    status = json.loads((written / "run.json").read_text()).get("status", "failed")
    final = experiment.folder(case)
    shutil.rmtree(final, ignore_errors=True)
    os.replace(written, final)
    return status


def put_refusal_in_place(case: Case, experiment: Experiment, refusal: Refusal) -> str:
    hidden = experiment.folder(case).parent / f".{case.name}.{os.getpid()}"
    try:
        write_refusal(case, refusal, hidden / "run")
        return put_in_place(case, experiment, hidden / "run")
    finally:
        shutil.rmtree(hidden, ignore_errors=True)
