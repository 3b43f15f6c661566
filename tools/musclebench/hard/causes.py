"""Why cells of the matrix of hard cases break, as causes.toml tells."""

import tomllib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Cause:
    why: str
    cells: dict[str, list[str]]  # by case: the backends that break it


def read_causes() -> list[Cause]:
    return [Cause(**row) for row in tomllib.loads(Path(__file__).with_suffix(".toml").read_text())["cause"]]


def known_to_break() -> set[tuple[str, str]]:
    """(case, backend)"""
    return {(case, backend) for cause in read_causes() for case, backends in cause.cells.items() for backend in backends}
