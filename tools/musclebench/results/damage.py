"""Whether a result folder is whole: what a full disk, a copy that was stopped or an editor may have done to it."""

import json
from pathlib import Path
from .status import MEASURED

TABLE_OF_MODE = {"coupled": "frames.csv", "replay": "frames.csv"}


def damage(folder: Path) -> str:
    """What is wrong with the folder of an ended run, in words that follow its path; empty where nothing is."""
    record = folder / "run.json"
    if not record.is_file():
        return ""
    try:
        told = json.loads(record.read_text())
    except (OSError, ValueError):
        return f"{record.name} is not JSON"
    if not isinstance(told, dict) or not isinstance(told.get("status"), str) or not isinstance(told.get("case"), dict):
        return f"{record.name} is no record of a run"
    table = TABLE_OF_MODE.get(told["case"].get("mode", "coupled"))
    if table is None or told["status"] not in MEASURED or not isinstance(told.get("frames"), int):
        return ""
    rows = complete_rows(folder / table)
    return "" if rows == told["frames"] else f"{table} has {rows} of {told['frames']} rows"


def complete_rows(path: Path) -> int:
    """Lines below the heading that end as lines do."""
    try:
        return max(0, path.read_bytes().count(b"\n") - 1)
    except OSError:
        return 0
