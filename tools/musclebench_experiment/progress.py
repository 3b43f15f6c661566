"""How far the whole experiment is and how long it still takes, counted in work and not in cases."""

import sys
import time
from dataclasses import dataclass, field

from .cases import Case

TRUSTED_FRACTION = 0.05  # from here on a running case says how long it takes
BAR_WIDTH = 30
LINE_WIDTH = 99
LINE_SECONDS = 10.0


@dataclass
class Estimate:
    """Seconds of every case: measured for finished ones, extrapolated for running ones, guessed for the others."""

    cases: list[Case]
    finished: dict[Case, float] = field(default_factory=dict)  # seconds each took
    running: dict[Case, tuple[float, float]] = field(default_factory=dict)  # elapsed seconds, fraction done

    def seconds(self, case: Case) -> float:
        measured = self._measured(case)
        if measured is not None:
            return measured
        elapsed = self.running.get(case, (0.0, 0.0))[0]
        return max(elapsed, case.guessed_seconds * self._slowness(case.backend))

    def total_seconds(self) -> float:
        return sum(self.seconds(case) for case in self.cases)

    def done_seconds(self) -> float:
        running = sum(self.seconds(case) * fraction for case, (_, fraction) in self.running.items())
        return sum(self.finished.values()) + running

    def fraction(self) -> float:
        total = self.total_seconds()
        return min(1.0, self.done_seconds() / total) if total > 0 else 1.0

    def remaining_seconds(self, jobs: int) -> float:
        """No shorter than the longest case that is left."""
        unfinished = [case for case in self.cases if case not in self.finished]
        left = [self.seconds(case) * (1 - self.running.get(case, (0.0, 0.0))[1]) for case in unfinished]
        return max(sum(left) / jobs, max(left, default=0.0))

    def _measured(self, case: Case) -> float | None:
        if case in self.finished:
            return self.finished[case]
        elapsed, fraction = self.running.get(case, (0.0, 0.0))
        return elapsed / fraction if fraction >= TRUSTED_FRACTION else None

    def _slowness(self, backend: str) -> float:
        """Measured over guessed seconds, of the cases of the same backend that are measured, else of any."""
        measured = {case: self._measured(case) for case in self.cases}
        known = {case: seconds for case, seconds in measured.items() if seconds is not None}
        alike = {case: seconds for case, seconds in known.items() if case.backend == backend} or known
        guessed = sum(case.guessed_seconds for case in alike)
        return sum(alike.values()) / guessed if guessed > 0 else 1.0


class ProgressBar:
    """One bar that is redrawn on a terminal; elsewhere a line every ten seconds."""

    def __init__(self, estimate: Estimate, jobs: int, stream=sys.stderr):
        self._estimate, self._jobs, self._stream = estimate, jobs, stream
        self._is_terminal = stream.isatty()
        self._shown_fraction = 0.0
        self._last_line = time.monotonic()

    def show(self, force: bool = False) -> None:
        text = self._text()
        if self._is_terminal:
            self._stream.write(f"\r{text}\x1b[K")
            self._stream.flush()
        elif force or time.monotonic() - self._last_line >= LINE_SECONDS:
            self._last_line = time.monotonic()
            print(text, file=self._stream, flush=True)

    def end(self) -> None:
        self.show(force=True)
        if self._is_terminal:
            self._stream.write("\n")

    def _text(self) -> str:
        # A better estimate of the whole may lower the share that is done; a bar that runs back helps nobody.
        self._shown_fraction = max(self._shown_fraction, self._estimate.fraction())
        full = round(BAR_WIDTH * self._shown_fraction)
        names = ", ".join(case.name for case in self._estimate.running) or "done"
        eta = duration(self._estimate.remaining_seconds(self._jobs))
        count = f"{len(self._estimate.finished)}/{len(self._estimate.cases)} runs"
        bar = f"[{'#' * full}{'.' * (BAR_WIDTH - full)}] {100 * self._shown_fraction:3.0f} %"
        return f"{bar}  {count}  ETA {eta}  {names}"[:LINE_WIDTH]


def duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes else f"{rest} s"
