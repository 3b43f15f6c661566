"""How far the whole experiment is and how long it still takes, counted in work and not in cases."""

import sys
import time
from dataclasses import dataclass, field

from .case import Case

TRUSTED_FRACTION = 0.05  # from here on a running case says how long it takes
BAR_WIDTH = 30
LINE_WIDTH = 99
REDRAW_SECONDS = 0.5  # drawing takes time from the cases that are measured
LINE_SECONDS = 10.0


@dataclass
class Estimate:
    """Seconds of every case: measured for finished ones, extrapolated for running ones, guessed for the others."""

    cases: list[Case]
    finished: dict[Case, float] = field(default_factory=dict)  # seconds each took
    running: dict[Case, tuple[float, float]] = field(default_factory=dict)  # elapsed seconds, fraction done

    def seconds(self, case: Case) -> float:
        return self._all_seconds()[case]

    def total_seconds(self) -> float:
        return sum(self._all_seconds().values())

    def done_seconds(self) -> float:
        return self._done(self._all_seconds())

    def fraction(self) -> float:
        seconds = self._all_seconds()
        total = sum(seconds.values())
        return min(1.0, self._done(seconds) / total) if total > 0 else 1.0

    def remaining_seconds(self, jobs: int) -> float:
        """No shorter than the longest case that is left."""
        left = [seconds * (1 - self.running.get(case, (0.0, 0.0))[1])
                for case, seconds in self._all_seconds().items() if case not in self.finished]
        return max(sum(left) / jobs, max(left, default=0.0))

    def _all_seconds(self) -> dict[Case, float]:
        measured = {case: seconds for case in self.cases if (seconds := self._measured(case)) is not None}
        by_kind: dict[str, dict[Case, float]] = {}
        for case, seconds in measured.items():
            by_kind.setdefault(case.kind, {})[case] = seconds
        slowness = {kind: _slowness(of_kind) for kind, of_kind in by_kind.items()}
        of_any = _slowness(measured)
        return {case: measured[case] if case in measured
                else max(self.running.get(case, (0.0, 0.0))[0], case.guessed_seconds * slowness.get(case.kind, of_any))
                for case in self.cases}

    def _measured(self, case: Case) -> float | None:
        if case in self.finished:
            return self.finished[case]
        elapsed, fraction = self.running.get(case, (0.0, 0.0))
        return elapsed / fraction if fraction >= TRUSTED_FRACTION else None

    def _done(self, seconds: dict[Case, float]) -> float:
        running = sum(seconds[case] * fraction for case, (_, fraction) in self.running.items())
        return sum(self.finished.values()) + running


def _slowness(measured: dict[Case, float]) -> float:
    """Measured over guessed seconds."""
    guessed = sum(case.guessed_seconds for case in measured)
    return sum(measured.values()) / guessed if guessed > 0 else 1.0


class ProgressBar:
    """One bar that is redrawn on a terminal; elsewhere a line every ten seconds."""

    def __init__(self, estimate: Estimate, jobs: int, stream=sys.stderr):
        self._estimate, self._jobs, self._stream = estimate, jobs, stream
        self._is_terminal = stream.isatty()
        self._shown_fraction = 0.0
        self._last_shown = time.monotonic()

    def show(self, force: bool = False) -> None:
        now = time.monotonic()
        if not force and now - self._last_shown < (REDRAW_SECONDS if self._is_terminal else LINE_SECONDS):
            return
        self._last_shown = now
        if self._is_terminal:
            self._stream.write(f"\r{self._text()}\x1b[K")
            self._stream.flush()
        else:
            print(self._text(), file=self._stream, flush=True)

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
