"""The history of nights: a chart of one case and figure at a time with its change points, and what changed."""

from pathlib import Path

import pandas as pd

from ..comparison.comparison_report import as_ratio
from ..comparison.metrics import EXACT, METRICS
from ..history.detection import ALL_CASES
from ..history.history import Finding, Night, opened
from ..program.cli import Problem
from ..tables.table_formats import UNKNOWN
from .bundle import PROJECT
from .changes import commits_before, interval_words
from .history_rows import metric_name, night_rows
from .parts import Axis, Chart, Chooser, Part, Section, TablePart

FILE_NAME = "history.sqlite"
SQLITE = b"SQLite format 3\0"
CHANGED = " (changed)"
WORDS = ("Each dot is a night, with the 95 % interval of its median over the processes. The grey line is the median between two change "
         "points. A dashed line is a change point; its number is the value after the change over the value before.")


def is_history(path: Path) -> bool:
    return path.is_file() or (path / FILE_NAME).is_file()


def history_section(path: Path) -> Section:
    """Of the file, or of that in the folder; the nights of the machine that measured last. Raises Problem where it can't be
    read or has no night."""
    file = path if path.is_file() else path / FILE_NAME
    every, measures, findings = _read(file)
    nights = [night for night in every if night.machine == every[-1].machine]
    order = {night.id: number for number, night in enumerate(nights)}
    found = sorted((one for one in findings if one.changed_in in order), key=lambda one: -order[one.changed_in])
    answers = [one for one in found if _is_answer(one)]
    changes = [one for one in found if not _is_answer(one)]
    commits = commits_before(found, nights, PROJECT)
    parts: list[Part] = [_chart(night_rows(measures, nights, changes, commits), nights, changes),
             _changes_table("changes", "Times and counters that changed", changes, nights, commits),
             _changes_table("answers", "Answers that changed", answers, nights, commits), _nights_table(nights)]
    return Section("history", "History of nights", _what(every, nights, changes, answers), [], parts, {}, file.parent)


def _read(file: Path) -> tuple[list[Night], pd.DataFrame, list[Finding]]:
    with file.open("rb") as start:
        if start.read(len(SQLITE)) != SQLITE:
            raise Problem(f"{file}: no history (it is no SQLite file); name a folder of results, or history.sqlite of tools/nightly")
    with opened(file, is_written=False) as history:
        nights = history.nights()
        if not nights:
            raise Problem(f"{file}: has no night yet; tools/nightly adds one")
        return nights, history.measures(nights[-1].machine), history.findings()


def _is_answer(one: Finding) -> bool:
    return one.metric in METRICS and METRICS[one.metric].kind == EXACT


def _what(every: list[Night], nights: list[Night], changes: list[Finding], answers: list[Finding]) -> list[tuple[str, str]]:
    first, last = nights[0], nights[-1]
    busy = [night for night in nights if night.busy_runs]
    others = {night.machine for night in every} - {last.machine}
    told = [("Nights", f"{len(nights)}, from {first.started} to {last.started}"), ("Machine", last.machine),
            ("Last program", f"{last.git}, {last.compiler}"),
            ("Changed", f"times and counters: {len(changes)}, answers: {len(answers)}")]
    if busy:
        told.append(("Busy", f"nights during which other programs used the machine: {len(busy)}"))
    if others:
        told.append(("Left out", f"nights of other machines ({'; '.join(sorted(others))}): {len(every) - len(nights)}; "
                                 "a series has nights of one machine only"))
    return told


def _chart(rows: pd.DataFrame, nights: list[Night], changes: list[Finding]) -> Chart:
    """`changes`: the latest first, which is shown at first."""
    changed = {(one.case, one.metric) for one in changes}
    first = changes[0] if changes else None
    cases = sorted(dict.fromkeys(rows["case"]), key=lambda case: case == ALL_CASES)
    metrics = [name for name in METRICS if name in set(rows["metric"])]
    choosers = [
        Chooser("case", "Case", {case: case + CHANGED * any(case == one for one, _ in changed) for case in cases},
                first.case if first else ""),
        Chooser("metric", "Figure", {metric: metric_name(metric) + CHANGED * any(metric == one for _, one in changed) for metric in metrics},
                first.metric if first else ""),
    ]
    return Chart("nights", "Night by night", WORDS, "nights", rows, Axis("started", "night"), Axis("value", "value"),
                 {"commit": "commit", "changed": "changed", "between": "commits between"},
                 {"nights": [night.started for night in nights], "names": {metric: metric_name(metric) for metric in metrics},
                  "whats": {metric: METRICS[metric].what for metric in metrics}}, choosers=choosers)


def _changes_table(name: str, title: str, changes: list[Finding], nights: list[Night], commits: dict[int, str]) -> TablePart:
    """The latest first. Ratios and chances where there are any: answers have none."""
    heads = {"case": "case", "metric": "what", "since": "since", "before": "before", "after": "after", "ratio": "after / before",
             "interval": "95 %", "chance": "p", "found_by": "found by", "commits": "commits between"}
    started = {night.id: night.started for night in nights}
    rows = [{"case": one.case, "metric": one.metric, "since": started[one.changed_in], "before": one.before or UNKNOWN,
             "after": one.after or UNKNOWN, "ratio": UNKNOWN if one.ratio is None else as_ratio(one.ratio),
             "interval": interval_words(one), "chance": UNKNOWN if one.chance is None else f"{one.chance:.1g}", "found_by": one.found_by,
             "commits": commits.get(one.changed_in, UNKNOWN)} for one in changes]
    shown = [key for key in heads if key not in ("ratio", "interval", "chance", "found_by")] if name == "answers" else list(heads)
    table = pd.DataFrame(rows, columns=list(heads))[shown]
    words = "The latest first." if rows else "None."
    return TablePart(name, title, words, [heads[key] for key in shown], [key in ("ratio", "chance") for key in shown],
                     [("", table.astype(str).values.tolist())] if rows else [], table.to_csv(index=False))


def _nights_table(nights: list[Night]) -> TablePart:
    rows = pd.DataFrame([vars(night) for night in nights[::-1]])[["started", "git", "compiler", "runs", "busy_runs", "program_sha256"]]
    shown = rows.drop(columns="program_sha256").astype(str)
    return TablePart("measured", "The nights", "Busy: number of runs during which other programs used the machine.",
                     ["started", "commit", "compiler", "runs", "busy"], [False, False, False, True, True],
                     [("", shown.values.tolist())], rows.to_csv(index=False))
