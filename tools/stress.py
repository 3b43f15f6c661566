#!/usr/bin/python3
"""Tries random scenes and tells what passes through what. Options: musclebench/options/stress.py."""

import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import pandas as pd

from musclebench.experiments.selection import check_backend, usual_backend
from musclebench.options.shared import check_options
from musclebench.options.stress import GUARANTEE, parse_arguments
from musclebench.program.cli import Problem, run_command
from musclebench.program.out_folder import claimed
from musclebench.program.registry import read_registry
from musclebench.stress.trial import Trial, tried

TABLE = "scenes.csv"


def run_all(options, out: Path, backend: str) -> list[Trial]:
    numbers = [options.only] if options.only else list(range(1, options.scenes + 1))
    effects = [] if options.no_effect else options.effect or [GUARANTEE]
    trials: list[Trial] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        waiting = [pool.submit(tried, options.musclebench, options.seed, number, out / f"{number:05d}", effects, backend,
                               options.only is not None) for number in numbers]
        try:
            for done in as_completed(waiting):
                trials.append(done.result())
                tell(trials, len(numbers), options.seed)
        except BaseException:
            for one in waiting:
                one.cancel()
            raise
        finally:
            trials.sort(key=lambda trial: trial.scene)
            pd.DataFrame([trial.row for trial in trials], columns=list(Trial.__dataclass_fields__)).to_csv(out / TABLE, index=False)
    return trials


def tell(trials: list[Trial], count: int, seed: int) -> None:
    last = trials[-1]
    if sys.stderr.isatty():
        print(f"\r{len(trials)} of {count} scenes, {sum(trial.is_finding for trial in trials)} findings\x1b[K", end="", file=sys.stderr, flush=True)
    if last.is_finding:
        where = f" in frame {last.frame}" if last.frame else ""
        start = "\r\x1b[K" if sys.stderr.isatty() else ""
        print(f"{start}scene {last.scene} ({last.what}): {last.verdict}{where}, {last.detail}; again: tools/stress --seed {seed} --only {last.scene}",
              flush=True)


def summary(trials: list[Trial]) -> str:
    lines = [f"  {verdict:<16}{count:>6}" for verdict, count in Counter(trial.verdict for trial in trials).most_common()]
    statuses = Counter(trial.status for trial in trials if trial.status)
    said = ", ".join(f"{status} {count}" for status, count in statuses.most_common())
    return "\n".join([f"{len(trials)} scenes", *lines, f"The program said: {said or 'nothing'}"])


def run_and_report(arguments) -> int:
    options = parse_arguments(arguments)
    check_options(options, "stress")
    registry, out = read_registry(options.musclebench), options.out.absolute()
    backend = check_backend(options.backend, registry) if options.backend else usual_backend(registry).name
    with claimed(out):
        trials = run_all(options, out, backend)
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    print(f"{summary(trials)}\n{out / TABLE}")
    if not any(trial.status for trial in trials):
        raise Problem(f"no scene was run: {trials[0].detail}")
    return 1 if any(trial.is_finding for trial in trials) else 0


def main(arguments=None) -> int:
    return run_command("stress", lambda: run_and_report(arguments), "what was tried stays in scenes.csv")


if __name__ == "__main__":
    sys.exit(main())
