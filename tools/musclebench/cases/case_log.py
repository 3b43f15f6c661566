"""A line a case as it ends, for who looks at a run from elsewhere or the morning after."""

from datetime import datetime, timezone
from pathlib import Path

from .case import Case

LOG_NAME = "cases.log"


class CaseLog:
    def __init__(self, out_dir: Path):
        self._path = out_dir / LOG_NAME

    def end(self, case: Case, status: str, seconds: float | None = None) -> None:
        """`seconds`: that it ran; None where it did not."""
        now = datetime.now(timezone.utc).isoformat(timespec="seconds")
        took = "not run" if seconds is None else f"{seconds:.1f} s"
        with open(self._path, "a") as log:  # one write of a short line: whole lines, whenever it is killed
            log.write(f"{now}  {status:<14}  {took:>9}  {case.name}\n")
