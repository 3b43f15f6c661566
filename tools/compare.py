#!/usr/bin/python3
"""Compares two folders of results, or two revisions or programs that it runs. Options: musclebench/options/compare.py."""

import sys
import uuid
from pathlib import Path

from musclebench.cases.case import Folders
from musclebench.cases.study_command import PROJECT
from musclebench.comparison.comparison_report import report
from musclebench.comparison.compared_cases import asked_experiment, first_cases
from musclebench.comparison.interleaved import PROGRAM_NAMES, InterleavedExperiment, measure, plan
from musclebench.comparison.instructions import why_not_by_cpu
from musclebench.comparison.result_set import ResultSet, read_set
from musclebench.comparison.revisions import commit_of, program_of
from musclebench.comparison.verdicts import compare
from musclebench.options.compare import WITHOUT_TIMES, check, parse_arguments
from musclebench.program.cli import Problem, check_program, run_command
from musclebench.program.fingerprint import file_digest, write_whole
from musclebench.program.registry import read_registry
from musclebench.program.release_build import RELEASE, check_release, refusal
from musclebench.results.run_folder import ResultProblem

DIGEST_LETTERS = 12


def check_comparable(before: ResultSet, after: ResultSet, with_times: bool, force: bool) -> None:
    """Times of other hardware or of a build without optimisation say nothing."""
    schemas = [one.told("schema_version") for one in (before, after)]
    if all(schemas) and schemas[0] != schemas[1]:
        raise Problem(f"{before.name} has results of schema {_list(schemas[0])}, {after.name} of {_list(schemas[1])}; run "
                      "one of them again with the program version of the other")
    if not with_times:
        return
    for one in (before, after):
        others = [kind for kind in one.told("build", "type") if kind != RELEASE]
        if others:
            raise refusal(one.name, others[0], WITHOUT_TIMES)
    for key, what in (("cpu", "CPU"), ("cores", "number of cores")):
        told = [one.told("machine", key) for one in (before, after)]
        if not force and all(told) and (told[0] != told[1] or len(told[0]) > 1):
            raise Problem(f"{before.name} and {after.name} were measured on different hardware ({what} {_list(told[0])}, "
                          f"{_list(told[1])}); measure on one machine, or take --force")


def _list(values: list) -> str:
    return " and ".join(map(str, values)) or "unknown"


def run_both(options) -> tuple[ResultSet, ResultSet, list[str]]:
    """Builds what is a revision; runs both, interleaved."""
    programs = {}
    for name, given in zip(PROGRAM_NAMES, (options.before, options.after)):
        commit = None if Path(given).is_file() else commit_of(given, PROJECT)
        programs[name] = program_of(commit, PROJECT, options.out.absolute() / "builds") if commit else Path(given)
        check_program(programs[name], "tools/build")
    if not options.accuracy_only:
        for program in programs.values():
            check_release(program, WITHOUT_TIMES)
    digests = [file_digest(program)[:DIGEST_LETTERS] for program in programs.values()]
    folders = Folders(options.out.absolute() / "runs" / "-".join(digests))  # results of other programs stay apart
    first, registry = programs[PROGRAM_NAMES[0]], read_registry(programs[PROGRAM_NAMES[0]])
    file = asked_experiment(options, registry)
    planned = plan(first_cases(file, first, registry, folders, options.backend), file, PROGRAM_NAMES)
    experiment = InterleavedExperiment(programs, folders, _invocation(folders.out_dir))
    problems = measure(planned.cases, experiment, file.timeout_s)
    why_not = why_not_by_cpu()
    notes = planned.notes + problems + ([f"The CPU's counter of instructions can't be read: {why_not}."] if why_not else [])
    sets = [read_set(folders.out_dir / name, given) for name, given in zip(PROGRAM_NAMES, (options.before, options.after))]
    return *sets, notes


def _invocation(out_dir: Path) -> str:
    """One that was stopped goes on as the same."""
    path = out_dir / "invocation"
    if not path.is_file():
        out_dir.mkdir(parents=True, exist_ok=True)
        write_whole(path, uuid.uuid4().hex)
    return path.read_text()


def compare_and_report(options) -> int:
    check(options)
    given = [Path(options.before), Path(options.after)]
    if all(path.is_dir() for path in given):
        before, after = (read_set(path) for path in given)
        notes: list[str] = []
    else:
        before, after, notes = run_both(options)
    check_comparable(before, after, not options.accuracy_only, options.force)
    found = compare(before, after, not options.accuracy_only)
    text = report(found, notes)
    options.out.mkdir(parents=True, exist_ok=True)
    write_whole(options.out / "compare.md", text)
    print(text)
    print(f"Written: {options.out / 'compare.md'}", file=sys.stderr)
    return 1 if found.changes else 0


def main(arguments=None) -> int:
    return run_command("compare", lambda: compare_and_report(parse_arguments(arguments)),
                       "complete runs are kept; the same command goes on", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
