"""Bisection for the largest step at which something is still right."""

from collections.abc import Callable
from dataclasses import dataclass

RATIO = 1.1  # between the step that is returned and the next one that was seen to be wrong


@dataclass(frozen=True)
class Limits:
    least: float
    most: float


@dataclass(frozen=True)
class SafeStep:
    largest: float | None  # nothing: not even the least is right
    wrong_at: float | None  # nothing: even the most is right
    tries: int


def largest_safe(is_right: Callable[[float], bool], start: float, limits: Limits) -> SafeStep:
    """Doubles or halves from `start` until one side is right and the other wrong, then halves between the two in
    proportion. What is right far beyond a step that is wrong is not looked for."""
    tries, right, wrong = 0, None, None
    step = min(max(start, limits.least), limits.most)
    while right is None or wrong is None:
        tries += 1
        if is_right(step):
            right = step
            if step >= limits.most:
                return SafeStep(right, None, tries)
            step = min(2 * step, limits.most) if wrong is None else step
        else:
            wrong = step
            if step <= limits.least:
                return SafeStep(None, wrong, tries)
            step = max(step / 2, limits.least) if right is None else step
    while wrong / right > RATIO:
        tries += 1
        middle = (right * wrong) ** 0.5
        if is_right(middle):
            right = middle
        else:
            wrong = middle
    return SafeStep(right, wrong, tries)
