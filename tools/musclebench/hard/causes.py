"""Why cells of the matrix of hard cases break, as reports/hard_cases/causes.toml tells."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

CAUSES = Path(__file__).resolve().parents[3] / "reports" / "hard_cases" / "causes.toml"


@dataclass(frozen=True)
class Cause:
    why: str
    cells: dict[str, list[str]]  # by case: the backends that break it


def read_causes() -> list[Cause]:
    return [Cause(**row) for row in tomllib.loads(CAUSES.read_text())["cause"]]


def known_to_break() -> set[tuple[str, str]]:
    """(case, backend)"""
    return {(case, backend) for cause in read_causes() for case, backends in cause.cells.items() for backend in backends}
