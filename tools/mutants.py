#!/usr/bin/python3
"""Goes through the faults and sums up what the tests saw. Options: musclebench/options/mutants.py."""

import sys
from argparse import Namespace
from pathlib import Path

from musclebench.cases.study_command import PROJECT
from musclebench.mutants.campaign import Campaign, summary
from musclebench.mutants.faults import Fault, chosen, problems_of, read_faults, stale_keys
from musclebench.mutants.scratch_build import BuildFailed, ScratchBuild
from musclebench.options.mutants import parse_arguments
from musclebench.program.cli import run_command


def check(faults: list[Fault], seen: Path) -> int:
    problems = problems_of(faults, PROJECT) + stale_keys(faults, seen)
    for problem in problems:
        print(f"mutants: {problem}", file=sys.stderr)
    if not problems:
        print(f"{len(faults)} faults apply")
    return 1 if problems else 0


def run(faults: list[Fault], options: Namespace) -> int:
    stale = [f"{fault.name}: {problem}" for fault in faults if (problem := fault.problem(PROJECT))]
    if stale:
        print("\n".join(f"mutants: {line}" for line in stale), file=sys.stderr)
        return 1
    part = f"-{options.shard[0]}-of-{options.shard[1]}" if options.shard else ""
    scratch = options.scratch or PROJECT / f"build/mutants{part}"
    build = ScratchBuild(scratch / "tree", scratch / "build", options.jobs)
    campaign = Campaign(PROJECT, scratch, build, options.seen, options.programs)
    campaign.prepare(faults)
    campaign.judge_all(faults)
    lines, is_well = summary(faults, campaign)
    print("\n".join(lines))
    return 0 if is_well else 1


def work(options: Namespace) -> int:
    faults = read_faults(options.faults)
    if options.check:
        return check(faults, options.seen or options.faults.with_name(f"{options.faults.stem}_seen.json"))
    faults = chosen(faults, options.only, options.shard)
    if options.list:
        for fault in faults:
            print(f"{fault.name}\n  {fault.file}\n  - {fault.line.strip()}\n  + {fault.fault.strip()}")
        return 0
    return run(faults, options)


def main(arguments=None) -> int:
    return run_command("mutants", lambda: work(parse_arguments(arguments)), "the verdicts so far are kept", BuildFailed)


if __name__ == "__main__":
    sys.exit(main())
