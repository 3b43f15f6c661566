"""One case in one process: started on a core of its own, followed by its progress lines, its folder put in place."""

import json
import os
import shutil
import signal
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

from .cases import PRESET, Case

GRACE_SECONDS = 5.0
KEPT_LINES = 20


class Worker:
    """A running case. Its output grows in a hidden folder and gets its name in `finish`."""

    def __init__(self, case: Case, command: list[str], raw_dir: Path, core: int):
        self.case, self.core = case, core
        self.started = time.monotonic()
        self.fraction = 0.0
        self.final = raw_dir / case.name
        self._hidden = raw_dir / f".{case.name}.{os.getpid()}"
        shutil.rmtree(self._hidden, ignore_errors=True)
        self._lines: deque[str] = deque(maxlen=KEPT_LINES)
        self._process = self._start([*command, "--out", str(self._hidden / "run"), "--progress"])
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def elapsed(self) -> float:
        return time.monotonic() - self.started

    def is_running(self) -> bool:
        return self._process.poll() is None

    def stop(self) -> None:
        """Ends the process, politely first, and removes what it has written."""
        for ask in (self._process.terminate, self._process.kill):
            if self.is_running():
                ask()
                try:
                    self._process.wait(GRACE_SECONDS)
                except subprocess.TimeoutExpired:
                    continue
        self._close()
        shutil.rmtree(self._hidden, ignore_errors=True)

    def finish(self, timed_out: bool = False) -> str:
        """Moves the folder into place and returns its status; a run that left no run.json gets one that says why."""
        self._close()
        written = self._hidden / "run"
        if timed_out or not (written / "run.json").is_file():
            shutil.rmtree(written, ignore_errors=True)
            written.mkdir(parents=True)
            (written / "run.json").write_text(json.dumps(self._failure_record(timed_out)) + "\n")
        shutil.rmtree(self.final, ignore_errors=True)
        os.replace(written, self.final)
        shutil.rmtree(self._hidden, ignore_errors=True)
        return json.loads((self.final / "run.json").read_text()).get("status", "failed")

    def kill_for_timeout(self) -> None:
        self._process.kill()
        self._process.wait()

    def _start(self, command: list[str]) -> subprocess.Popen:
        # A child inherits the affinity of the thread that starts it, so the core is set here and put back at once.
        self._hidden.mkdir(parents=True)
        allowed = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {self.core})
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
        self._reader.join(GRACE_SECONDS)
        self._process.stderr.close()

    def _failure_record(self, timed_out: bool) -> dict:
        case = {"scene": self.case.scene, "preset": PRESET, "backend": self.case.backend, "threads": 1}
        status = "timeout" if timed_out else "failed"
        return {"schema_version": 1, "status": status, "status_detail": self._reason(timed_out), "case": case}

    def _reason(self, timed_out: bool) -> str:
        if timed_out:
            return f"stopped after {self.elapsed:.0f} s"
        code = self._process.returncode
        ending = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"{ending}: {self._lines[-1]}" if self._lines else f"{ending}, no message"
