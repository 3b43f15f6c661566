"""Findings of a history in words: since when, by how much, how sure, and the commits between."""

from pathlib import Path

from ..comparison.comparison_report import as_ratio
from ..comparison.revisions import commits_between
from ..history.history import Finding, Night
from ..tables.table_formats import UNKNOWN

NAMED_COMMITS = 5


def ratio_words(change: Finding) -> str:
    """'1.10 times (95 % 1.08 to 1.12), p 1e-06, change point'; without what is not known."""
    words = [f"{change.before} to {change.after}" if change.before and change.after else ""]
    if change.ratio is not None:
        words.append(f"{as_ratio(change.ratio)} times" + ("" if change.low is None else f" (95 % {interval_words(change)})"))
    words.append("" if change.chance is None else f"p {change.chance:.1g}")
    return ", ".join(filter(None, [*words, change.found_by]))


def interval_words(change: Finding) -> str:
    return UNKNOWN if change.low is None or change.high is None else f"{as_ratio(change.low)} to {as_ratio(change.high)}"


def commits_before(changes: list[Finding], nights: list[Night], repository: Path) -> dict[int, str]:
    """{first night of a change: the commits since the night before it}"""
    order = [night.id for night in nights]
    return {night: _between(nights[order.index(night) - 1], nights[order.index(night)], repository)
            for night in dict.fromkeys(change.changed_in for change in changes) if night in order[1:]}


def _between(before: Night, after: Night, repository: Path) -> str:
    if before.program_sha256 == after.program_sha256:
        return f"none: {after.git} was measured in both nights"
    lines = commits_between(before.git, after.git, repository)
    more = [f"and {len(lines) - NAMED_COMMITS} more"] if len(lines) > NAMED_COMMITS else []
    return f"{before.git}..{after.git}" + (": " + "; ".join([*lines[:NAMED_COMMITS], *more]) if lines else "")
