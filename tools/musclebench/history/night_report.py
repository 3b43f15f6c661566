"""What a night found, as Markdown."""

from pathlib import Path

import pandas as pd

from ..comparison.comparison_report import as_ratio, spread_table
from ..comparison.result_set import ResultSet
from ..comparison.revisions import commits_between
from ..comparison.spread import spread_of
from ..results.disturbance import disturbed, note
from ..tables.table_formats import UNKNOWN, Column, markdown_rows
from .detection import GONE
from .history import Finding, Night

SHOWN_GONE = 4
COLUMNS = [Column("case", "case"), Column("metric", "what"), Column("since", "since"), Column("before", "before"),
           Column("after", "after"), Column("ratio", "after / before"), Column("interval", "95 %"), Column("chance", "p"),
           Column("found_by", "found by")]


def night_report(nights: list[Night], new: list[Finding], known: list[Finding], results: ResultSet | None, notes: list[str],
                 repository: Path, doubts: list[str]) -> str:
    """`nights`: of this machine, the last one being reported on. `doubts`: what it can't say, see caveats."""
    last = nights[-1]
    parts = [f"## Night of {last.started}: " + "; ".join([*_changed_words(new), *doubts]),
             f"Commit {last.git}, {last.compiler}, {last.machine}; night {len(nights)} of this machine."]
    if new:
        parts += ["### New", findings_table(new, nights), *_commits(new, nights, repository)]
    if known:
        parts += ["### Reported before", findings_table(known, nights)]
    if results is not None:
        spreads = [spread for case, samples in results.cases.items() if (spread := spread_of(case, samples))]
        parts += ["### Frames of tonight", spread_table(spreads)] if spreads else []
        busy = disturbed({sample.run.folder.name: sample.run.record for sample in results.samples})
        notes = [*notes, *(f"left out: {fault}" for fault in results.faults), *filter(None, [note(busy, len(results.samples))])]
    return "\n\n".join([*parts, "\n".join(f"- {line}" for line in notes)]).rstrip() + "\n"


def _changed_words(new: list[Finding]) -> list[str]:
    gone = [one.case for one in new if one.found_by == GONE]
    count = len(new) - len(gone)
    shown = ", ".join(gone[:SHOWN_GONE]) + (f" and {len(gone) - SHOWN_GONE} more" if len(gone) > SHOWN_GONE else "")
    words = [f"{len(gone)} case{'s' * (len(gone) > 1)} vanished ({shown})"] if gone else []
    return words + ([f"{count} figure{'s' * (count > 1)} changed"] if count else []) or ["nothing changed"]


def findings_table(findings: list[Finding], nights: list[Night]) -> str:
    started = {night.id: night.started for night in nights}
    return markdown_rows(COLUMNS, pd.DataFrame([{
        "case": one.case, "metric": one.metric, "since": started.get(one.changed_in, UNKNOWN), "before": one.before or UNKNOWN,
        "after": one.after or UNKNOWN, "ratio": UNKNOWN if one.ratio is None else as_ratio(one.ratio),
        "interval": UNKNOWN if one.low is None else f"{as_ratio(one.low)} to {as_ratio(one.high)}",
        "chance": UNKNOWN if one.chance is None else f"{one.chance:.1g}", "found_by": one.found_by} for one in findings]))


def _commits(findings: list[Finding], nights: list[Night], repository: Path) -> list[str]:
    """Between the last night without the change and the first with it."""
    parts, order = [], [night.id for night in nights]
    for changed_in in dict.fromkeys(one.changed_in for one in findings):
        at = order.index(changed_in) if changed_in in order else 0
        if at == 0:
            continue
        before, after = nights[at - 1], nights[at]
        lines = commits_between(before.git, after.git, repository)
        if before.program_sha256 == after.program_sha256:
            lines = ["none: the program was the same in both nights, so that the machine changed"]
        parts.append(f"Commits between {before.started} ({before.git}) and {after.started} ({after.git}):\n\n"
                     + "\n".join(f"- {line}" for line in lines or ["none that git knows"]))
    return parts
