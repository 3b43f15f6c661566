"""Options that choose among the cases of an experiment, and the plan as a dry run prints it."""

import fnmatch

from ..cases.case import Case
from ..cases.progress import duration
from ..program.cli import Problem
from .expansion import filtered, in_shard
from .running import Sweep


def chosen(sweep: Sweep, shard: tuple[int, int], filters: list[str] | None = None) -> list[Case]:
    """Those to run here."""
    patterns = [words if set(words) & set("*?[") else f"*{words}*" for words in filters or []]
    cases = sweep.cases
    if patterns:
        cases = filtered(cases, lambda name: any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns))
        if not cases:
            raise Problem(f"--filter {filters[0]}: no case has that in its name; --list-cases names them")
    return in_shard(cases, *shard) if shard != (1, 1) else cases


def print_plan(cases: list[Case], sweep: Sweep, jobs: int) -> None:
    print("  seconds  threads  stride  case")
    left = [case for case in cases if not case.is_too_long and sweep.experiment.wants(case)]
    for case in cases:
        note = "  (not run, too long)" if case.is_too_long else "" if case in left else "  (complete)"
        print(f"{case.guessed_seconds:9.1f}  {case.threads:7}  {getattr(case, 'stride', ''):>6}  {case.name}{note}")
    seconds = sum(case.guessed_seconds for case in left)
    print(f"{len(cases)} cases; about {duration(seconds)} of work left, {duration(seconds / jobs)} with {jobs} at a time; "
          f"about {sum(case.guessed_bytes for case in left) / 1e9:.1f} GB")
