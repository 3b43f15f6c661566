#!/usr/bin/python3
"""libFuzzer on every reader of files: meshes, scenes, motions, landmarks, recordings, structures of backends.

Feeds each reader with changed files, starting from the corpus in the sources and from what earlier runs have kept, under the
sanitizers of addresses and of undefined behaviour. A reader has to read or to refuse what it gets, in 10 s and 2 GB. Keeps in
OUT/READER the corpus as it grew (the smallest files that reach as much), a file for each finding, and libFuzzer's log.
Prints a line a reader. Exit code: 0 nothing was found; 1 there is a finding; 2 something is wrong with the call.

What is found belongs, as small as it can be, into the corpus of the sources: a test of every build replays that.
"""

import argparse
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from musclebench.cases.study_command import PROJECT
from musclebench.fuzzing.fuzzer import Campaign, Fuzzer, Outcome, Progress, find_fuzzers
from musclebench.program.cli import OneLineParser, Problem, check_positive, run_command
from musclebench.program.out_folder import claimed


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reader", nargs="*", metavar="READER", help="only these (default: all; --list names them)")
    parser.add_argument("--seconds", type=float, default=600, metavar="N", help="of each reader (default: 600)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="readers at a time (default: 1)")
    parser.add_argument("--list", action="store_true", help="names the readers")
    parser.add_argument("--out", type=Path, metavar="DIR", default=PROJECT / "reports" / "out" / "fuzz",
                        help="default: reports/out/fuzz")
    parser.add_argument("--build", type=Path, metavar="DIR", default=PROJECT / "build" / "fuzz",
                        help="build with the programs (default: that of the preset fuzz)")
    return parser.parse_args(arguments)


def chosen_fuzzers(options) -> list[Fuzzer]:
    fuzzers = find_fuzzers(options.build, PROJECT)
    if not fuzzers:
        raise Problem(f"{options.build}: holds no fuzzers; build them first (tools/fuzz does)")
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
    check_positive("--seconds", options.seconds)
    check_positive("--jobs", options.jobs)
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
