"""Runs cases side by side, one process a core."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

from .cases import Case
from .progress import Estimate, ProgressBar
from .worker import Worker

POLL_SECONDS = 0.2


@dataclass
class Settings:
    raw_dir: Path
    cores: list[int]  # one running case on each
    timeout_seconds: float
    command_of: Callable[[Case], list[str]]  # without --out and --progress
    on_finished: Callable[[Case, Path], None]  # the case and its folder, now in place


def run_cases(cases: list[Case], settings: Settings) -> dict[Case, str]:
    """{case: status}. An interrupt ends the children, removes their folders and is passed on."""
    waiting, free, running = list(cases), list(settings.cores), []
    estimate = Estimate(list(cases))
    bar = ProgressBar(estimate, len(settings.cores))
    statuses: dict[Case, str] = {}
    try:
        while waiting or running:
            while waiting and free:
                case = waiting.pop(0)
                running.append(Worker(case, settings.command_of(case), settings.raw_dir, free.pop(0)))
            time.sleep(POLL_SECONDS)
            for worker in [w for w in running if _is_over(w, settings.timeout_seconds)]:
                statuses[worker.case] = _finish(worker, settings)
                running.remove(worker)
                free.append(worker.core)
                estimate.finished[worker.case] = worker.elapsed
            estimate.running = {w.case: (w.elapsed, w.fraction) for w in running}
            bar.show()
    finally:
        for worker in running:
            worker.stop()
    bar.end()
    return statuses


def _is_over(worker: Worker, timeout_seconds: float) -> bool:
    return not worker.is_running() or worker.elapsed > timeout_seconds


def _finish(worker: Worker, settings: Settings) -> str:
    timed_out = worker.is_running()
    if timed_out:
        worker.kill_for_timeout()
    status = worker.finish(timed_out)
    settings.on_finished(worker.case, worker.final)
    return status
