"""The folder of one cell of the matrix of hard cases: what the program left, and the run.json that is made of it."""

import json
from pathlib import Path

MATRIX = "matrix.csv"
HELD, BROKEN = 0, 1  # exit codes of `musclebench hard`
STATUS = {HELD: "ok", BROKEN: "suspect"}  # suspect: a figure is beyond its bar


def describe(folder: Path, case: dict, exit_code: int) -> None:
    """Writes run.json; `case` is its `case`."""
    lines = (folder / MATRIX).read_text().splitlines()
    record = {"schema_version": 1, "status": STATUS[exit_code], "status_detail": "", "case": case, "rows": len(lines) - 1}
    (folder / "run.json").write_text(json.dumps(record) + "\n")


def joined(folders: list[Path]) -> str:
    """matrix.csv of all of them, as the program writes that of several cells."""
    texts = [(folder / MATRIX).read_text().splitlines(keepends=True) for folder in folders]
    return "".join([*texts[0][:1], *(line for text in texts for line in text[1:])]) if texts else ""
