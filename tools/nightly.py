#!/usr/bin/python3
"""Measures a night, adds it to the history and reports. Options: musclebench/options/nightly.py."""

import json
import sys
from datetime import datetime, timezone
from pathlib import Path

from musclebench.cases.case import Folders
from musclebench.cases.study_command import PROJECT
from musclebench.comparison.compared_cases import asked_experiment, first_cases
from musclebench.history import simulation
from musclebench.history.caveats import caveats
from musclebench.history.detection import answer_findings, counter_findings, gone_findings, new_ones, step_findings
from musclebench.history.exchange import bencher_metrics, write_otava
from musclebench.history.history import STARTED, Finding, Night, now, opened
from musclebench.history.night_report import night_report
from musclebench.history.nights import cells_measures, measures_of, night_of
from musclebench.history.one_night import MeasuredNight, keep_program, kept_program, measure_night, read_night
from musclebench.options.nightly import check, parse_arguments
from musclebench.program.cli import Problem, check_program, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.program.out_folder import claimed
from musclebench.program.registry import read_registry
from musclebench.program.release_build import check_release
from musclebench.results.run_folder import ResultProblem


def measured(options, history_file: Path) -> MeasuredNight:
    """Asks the history first: what can't be added to it need not be measured."""
    check_program(options.musclebench, "tools/build")
    registry = read_registry(options.musclebench)
    with opened(history_file) as history:
        nights = history.nights()
    kept = kept_program(nights[-1].program_sha256, options.musclebench, options.out) if nights else None
    started = datetime.now(timezone.utc).strftime(STARTED)
    folder = options.out / "nights" / started.replace(":", "")
    check_release(options.musclebench, "")
    file = asked_experiment(options, registry)
    firsts = first_cases(file, options.musclebench, registry, Folders(folder.absolute()), options.backend)
    return measure_night(folder, started, options.musclebench, kept, firsts, file, 60 * options.minutes,
                         0 if options.no_hard else options.hard_seconds)


def append(night: MeasuredNight, history_file: Path) -> tuple[list[Night], list[Finding], list[Finding], list[str]]:
    """(nights of the machine, new findings, those reported before, what the night can't say)"""
    results = night.results
    row = night_of(results, night.started)
    measures = measures_of(results)
    if night.matrix.is_file():
        try:
            measures += cells_measures(night.matrix)
        except Problem as problem:
            night.notes.append(f"left out: {problem}")
    with opened(history_file) as history:
        if history.has(night.started):
            raise Problem(f"{history_file}: has the night {night.started} already; nothing was added")
        number = history.append(row, measures)
        nights, table = history.nights(row.machine), history.measures(row.machine)
        known = history.findings()
        found = [*gone_findings(table), *answer_findings(table), *counter_findings(table), *night.same_night_findings(number), *step_findings(table)]
        new = new_ones(_each_once(found), known, [one.id for one in nights])
        history.note(number, new)
    return nights, new, known, caveats(nights, table, now())


def _each_once(found: list[Finding]) -> list[Finding]:
    """The first of each case and metric in each night: that found in the most certain way."""
    return list({(one.case, one.metric, one.changed_in): one for one in reversed(found)}.values())[::-1]


def write_files(options, nights: list[Night], history_file: Path, report: str) -> list[Path]:
    with opened(history_file, is_written=False) as history:
        table = history.measures(nights[-1].machine)
    files = write_otava(table, nights, options.out / "otava")[:1]
    for name, text in (("bencher.json", json.dumps(bencher_metrics(table, nights[-1].id), indent=2) + "\n"), ("report.md", report)):
        files.append(options.out / name)
        write_whole(files[-1], text)
    return files


def run_night(options) -> int:
    check(options)
    if options.simulate:
        return print_rates(options.simulate)
    history_file = options.history or options.out / "history.sqlite"
    if options.report_only:
        return report_again(options, history_file)
    with claimed(options.out.absolute(), "nights"):
        night = _read(options.append) if options.append else measured(options, history_file)
        nights, new, known, doubts = append(night, history_file)
        if not options.append:
            keep_program(options.musclebench, options.out)
        text = night_report(nights, new, known, night.results, night.notes, PROJECT, doubts)
        files = write_files(options, nights, history_file, text)
    print(text)
    print("Written:", history_file, *files, sep="\n  ", file=sys.stderr)
    return 1 if new else 0


def report_again(options, history_file: Path) -> int:
    with opened(history_file, is_written=False) as history:
        every, known = history.nights(), history.findings()
        table = history.measures(every[-1].machine) if every else None
    if table is None:
        raise Problem(f"{history_file}: has no night yet; run tools/nightly to add one")
    nights = [night for night in every if night.machine == every[-1].machine]
    text = night_report(nights, [], known, None, [], PROJECT, caveats(nights, table, now()))
    write_files(options, nights, history_file, text)
    print(text)
    return 0


def _read(folder: Path) -> MeasuredNight:
    try:
        return read_night(folder)
    except (OSError, ValueError, KeyError) as problem:
        raise Problem(f"{folder}: no measured night ({problem}); its night.json is missing or broken, so measure the night again") from None


def print_rates(trials: int, nights: int = 30, slowdown: float = 1.1, since: int = 16) -> int:
    noise = simulation.read_noise()
    rates = simulation.simulate(noise, trials, nights, slowdown, since)
    print(f"{trials} histories of {nights} nights without a change: {rates.false_alarms} alarmed.")
    print(f"{trials} with one case's collision slower by {100 * (slowdown - 1):.0f} % since night {since}: found by its steps the same night "
          f"{rates.found_within(1)}, within two nights {rates.found_within(2)}, within three {rates.found_within(3)}, "
          f"within five {rates.found_within(5)}; in {rates.wrong} another case alarmed.")
    false_alarms, found, wrong = simulation.compared(noise, trials, slowdown)
    print(f"{trials} third nights, in which the last night's program ran interleaved with tonight's: {false_alarms} alarmed where they "
          f"were the same; {found} found such a slowdown the same night; in {wrong} another case alarmed.")
    return 0


def main(arguments=None) -> int:
    return run_command("nightly", lambda: run_night(parse_arguments(arguments)),
                       "the history is as it was; what was measured stays in --out", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
