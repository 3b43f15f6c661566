"""Whether a result folder is whole: what a full disk, a copy that was stopped or an editor may have done to it."""

import json
from pathlib import Path
from .status import MEASURED

TABLE_OF_MODE = {"coupled": "frames.csv", "replay": "frames.csv", "probe": "probe.csv", "hard": "matrix.csv"}
ROWS_OF_A_PROBED_BONE = 3  # smooth, sharp and all


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
    expected = _expected_rows(told)
    if table is None or told["status"] not in MEASURED or expected is None:
        return ""
    last_frame = _last_frame(told)
    for name, rows_of_a_frame in {table: 1, **_tables_of_muscles(told)}.items():
        fault = _damage_of_table(folder / name, expected * rows_of_a_frame, last_frame)
        if fault:
            return fault
    return _damage_of_fibres(folder, told) or _damage_of_forces(folder, told)


def _damage_of_forces(folder: Path, told: dict) -> str:
    rows = told["forces"].get("rows") if isinstance(told.get("forces"), dict) else None
    return _damage_of_table(folder / "forces.csv", rows, told["frames"] if rows else None) if isinstance(rows, int) else ""


def _damage_of_fibres(folder: Path, told: dict) -> str:
    """Their tables have rest beside the frames."""
    followed = told.get("fibres")
    if not isinstance(followed, list):
        return ""
    states, fibres = told["frames"] + 1, sum(muscle.get("followed", 0) for muscle in followed)
    return (_damage_of_table(folder / "fibres.csv", states * len(followed), told["frames"])
            or _damage_of_table(folder / "fibre_lengths.csv", states * fibres, told["frames"]))


def _damage_of_table(table: Path, expected: int, last_frame: int | None) -> str:
    rows, last = _complete_rows(table)
    if rows != expected:
        return f"{table.name} has {rows} of {expected} rows"
    if rows > 0 and last_frame is not None and last != str(last_frame):
        return f"{table.name} ends with frame {last}, not {last_frame}"
    return ""


def _tables_of_muscles(told: dict) -> dict[str, int]:
    """{table: rows a frame}, where there are several muscles."""
    mode = told["case"].get("mode", "coupled")
    muscles, touching = told.get("muscles"), told["case"].get("muscle_contact")
    if mode not in ("coupled", "replay") or not isinstance(muscles, list) or not muscles:
        return {}
    pairs = len(muscles) * len(told["bones"]) + (len(touching) if isinstance(touching, list) else 0)
    return {"muscles.csv": len(muscles), "pairs.csv": pairs}


def _expected_rows(told: dict) -> int | None:
    """Of the table, as run.json tells; None where it doesn't."""
    if told["case"].get("mode") == "probe":
        probed = told.get("probed")
        return ROWS_OF_A_PROBED_BONE * len(probed) if isinstance(probed, list) else None
    rows = told.get("rows" if told["case"].get("mode") == "hard" else "frames")
    return rows if isinstance(rows, int) else None


def _last_frame(told: dict) -> int | None:
    """A replay may leave frames of its recording out, but never the last; None where rows are no frames."""
    if told["case"].get("mode") in ("probe", "hard"):
        return None
    recording = told.get("recording")
    return recording.get("frames") if isinstance(recording, dict) else told["frames"]


def _complete_rows(path: Path) -> tuple[int, str]:
    """Lines below the heading that end as lines do: how many, and the first cell of the last."""
    try:
        *lines, _ = path.read_bytes().split(b"\n")
    except OSError:
        return 0, ""
    return max(0, len(lines) - 1), lines[-1].split(b",")[0].decode(errors="replace") if lines else ""
