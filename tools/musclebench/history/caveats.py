"""What a night can't say, in words for its first line."""

import pandas as pd

from ..comparison.metrics import COUNTER, METRICS, TIME
from ..comparison.verdicts import fewest_runs
from .history import Night


def caveats(nights: list[Night], measures: pd.DataFrame, moment: str) -> list[str]:
    """`nights`: of the machine, in order. `measures`: theirs, of History.measures. `moment`: now."""
    return [*clock_words(nights, moment), *size_words(measures[measures["night"] == nights[-1].id])]


def clock_words(nights: list[Night], moment: str) -> list[str]:
    """Only the night after one that was stamped wrongly says so; it is in order again."""
    last, before = nights[-1], nights[-2:-1]
    if last.started > moment:
        return [f"it is stamped after now ({moment}): the clock was wrong"]
    return [f"the clock ran backwards: the night before is stamped {one.started}" for one in before if one.started > last.started]


def size_words(measures: pd.DataFrame) -> list[str]:
    """Of one night, whose times can show a change the same night only if complete separation is unlikely enough."""
    tested = measures[(measures["kind"] == TIME) | ((measures["kind"] == COUNTER) & ~measures["metric"].map(_is_deterministic))]
    if tested.empty:
        return []
    runs, needed = int(tested["runs"].min()), fewest_runs(len(tested))
    if runs >= needed:
        return []
    few = f"{runs} repetition{'s' * (runs != 1)}"
    return [f"{few} can't show a slower or faster time the same night, {needed} can"]


def _is_deterministic(metric: str) -> bool:
    return metric in METRICS and METRICS[metric].is_deterministic
