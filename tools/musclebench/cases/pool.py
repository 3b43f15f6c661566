"""Runs cases side by side, one process a case."""

import os
import select
import sys
from dataclasses import dataclass, replace

from ..program.children import uninterrupted
from ..program.cli import Interrupted
from ..program.cores import own_cores
from ..program.disk import DiskFull, is_disk_full
from .case import Case
from .case_log import CaseLog
from .case_queue import CaseQueue
from .experiment import Experiment, Refusal
from .progress import Estimate, ProgressBar
from .worker import Worker, put_refusal_in_place

POLL_SECONDS = 0.1


@dataclass
class Limits:
    cores: list[int]  # one running case on each; others where another run has these
    timeout_seconds: float
    memory_bytes: int | None = None  # of one case; None: as much as there is


def run_cases(cases: list[Case], experiment: Experiment, limits: Limits) -> dict[Case, str]:
    """{case: status}. An interrupt or a full disk ends the children, removes their folders and is passed on; an interrupt
    as Interrupted, which says what is kept. Each case that ends is a line of LOG_NAME in the experiment's folder."""
    for line in filter(None, map(experiment.quarantine, cases)):
        print(line, file=sys.stderr)
    with own_cores(limits.cores) as cores:
        return _Pool(cases, experiment, replace(limits, cores=cores)).run()


class _Pool:
    def __init__(self, cases: list[Case], experiment: Experiment, limits: Limits):
        self._queue, self._experiment, self._limits = CaseQueue(cases), experiment, limits
        self._free = list(limits.cores)
        self._running: list[Worker] = []
        self._estimate = Estimate([case for case in cases if experiment.is_ever_run(case)])
        self._statuses: dict[Case, str] = {}
        self._log = CaseLog(experiment.folders.out_dir)

    def run(self) -> dict[Case, str]:
        bar = ProgressBar(self._estimate, len(self._limits.cores))
        try:
            while self._queue:
                self._start_cases()
                if self._running:  # until one ends, or its progress may have grown
                    select.select(self._running, [], [], POLL_SECONDS)
                self._end_cases()
                self._estimate.running = {w.case: (w.elapsed, w.fraction) for w in self._running}
                bar.show()
        except KeyboardInterrupt:
            raise self._interrupted() from None
        except OSError as problem:
            if is_disk_full(problem):
                raise DiskFull(self._experiment.folders.out_dir) from None
            raise
        finally:
            with uninterrupted():
                for worker in self._running:
                    worker.stop()
        bar.end()
        return self._statuses

    def _start_cases(self) -> None:
        while self._free and (case := self._queue.take()) is not None:
            # What a case needed may have come out as it was before, or not at all.
            if not self._experiment.wants(case):
                self._leave_out(case, "complete")
            elif (refusal := self._refusal(case)) is not None:
                self._leave_out(case, put_refusal_in_place(case, self._experiment, refusal))
            else:
                self._start(case)

    def _start(self, case: Case) -> None:
        cores = sorted(os.sched_getaffinity(0))[: case.threads] if case.threads > 1 else [self._free.pop(0)]
        with uninterrupted():
            self._running.append(Worker(case, self._experiment, cores, self._limits.memory_bytes))

    def _refusal(self, case: Case) -> Refusal | None:
        cores = len(os.sched_getaffinity(0))
        if case.threads > cores:
            return Refusal("failed", f"not run: wants {case.threads} cores, there are {cores}")
        return self._experiment.refusal(case)

    def _leave_out(self, case: Case, status: str) -> None:
        self._statuses[case] = status
        self._log.end(case, status)
        self._queue.end(case)
        if case in self._estimate.cases:
            self._estimate.cases.remove(case)

    def _end_cases(self) -> None:
        for worker in [w for w in self._running if self._is_over(w)]:
            with uninterrupted():
                self._running.remove(worker)
                timed_out = worker.is_running()
                if timed_out:
                    worker.kill_for_timeout()
                self._statuses[worker.case] = worker.finish(timed_out)
                self._log.end(worker.case, self._statuses[worker.case], worker.elapsed)
            self._queue.end(worker.case)
            self._estimate.finished[worker.case] = worker.elapsed
            if worker.case.threads == 1:
                self._free.append(worker.cores[0])

    def _interrupted(self) -> Interrupted:
        kept, unfinished = len(self._statuses), len(self._running)
        return Interrupted(f"{kept} of the {kept + unfinished + self._queue.waiting} cases of this run have ended and are kept "
                           f"in {self._experiment.folders.out_dir}, {unfinished} unfinished ones are removed; "
                           "the same command goes on")

    def _is_over(self, worker: Worker) -> bool:
        return not worker.is_running() or worker.elapsed > self._limits.timeout_seconds
