#!/usr/bin/python3
"""Runs libFuzzer on the readers of files and tells what it found. Options: musclebench/options/fuzz.py."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor

from musclebench.cases.study_command import PROJECT
from musclebench.fuzzing.fuzzer import Campaign, Fuzzer, Outcome, Progress, find_fuzzers
from musclebench.options.fuzz import parse_arguments
from musclebench.options.shared import check_options
from musclebench.program.cli import Problem, run_command
from musclebench.program.out_folder import claimed


def chosen_fuzzers(options) -> list[Fuzzer]:
    fuzzers = find_fuzzers(options.build, PROJECT)
    if not fuzzers:
        raise Problem(f"{options.build}: holds no fuzzers; leave out --build, and tools/fuzz builds them")
    known = [fuzzer.reader for fuzzer in fuzzers]
    for name in options.reader:
        if name not in known:
            raise Problem(f"'{name}' is no reader; there are: {', '.join(known)}")
    return [fuzzer for fuzzer in fuzzers if not options.reader or fuzzer.reader in options.reader]


class ProgressLine:
    """One line that is written over, of the reader that told last; nothing where nobody looks."""

    def __init__(self, seconds: float, count: int):
        self._seconds, self._count, self._done = seconds, count, 0
        self._lock = threading.Lock()

    def tell(self, fuzzer: Fuzzer, progress: Progress, elapsed_s: float) -> None:
        self._write(f"{self._done} of {self._count} done; {fuzzer.reader}: {elapsed_s:.0f} of {self._seconds:.0f} s, "
                    f"{progress.executions} executions, coverage {progress.coverage}")

    def end(self, outcome: Outcome) -> None:
        with self._lock:
            self._done += 1
        self._write("")
        print(outcome.line, flush=True)

    def _write(self, text: str) -> None:
        if sys.stderr.isatty():
            print(f"\r{text}\x1b[K", end="", file=sys.stderr, flush=True)


def run_all(fuzzers: list[Fuzzer], options) -> list[Outcome]:
    line, stopped = ProgressLine(options.seconds, len(fuzzers)), threading.Event()

    def run(fuzzer: Fuzzer) -> Outcome:
        def tell(progress: Progress, elapsed_s: float) -> None:
            if stopped.is_set():
                raise KeyboardInterrupt
            line.tell(fuzzer, progress, elapsed_s)

        outcome = Campaign(fuzzer, options.out.absolute() / fuzzer.reader).run(options.seconds, tell)
        line.end(outcome)
        return outcome

    with ThreadPoolExecutor(options.jobs) as pool:
        try:
            return list(pool.map(run, fuzzers))
        except BaseException:  # an interrupt reaches this thread only
            stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def run_and_report(options) -> int:
    check_options(options)
    fuzzers = chosen_fuzzers(options)
    if options.list:
        print("\n".join(fuzzer.reader for fuzzer in fuzzers))
        return 0
    with claimed(options.out.absolute(), *(fuzzer.reader for fuzzer in fuzzers)):
        outcomes = run_all(fuzzers, options)
    return 1 if any(outcome.findings for outcome in outcomes) else 0


def main(arguments=None) -> int:
    return run_command("fuzz", lambda: run_and_report(parse_arguments(arguments)), "the corpora are kept as they grew")


if __name__ == "__main__":
    sys.exit(main())
