"""Rows of a bundle from the tables of a study of accuracy: those beside its runs, or published ones."""

from pathlib import Path

import pandas as pd

from ..program.cli import Problem
from ..results.disturbance import MARK
from ..results.status import MEASURED
from ..tables.difficulties import TITLES
from .columns import FLAGS, NAMES, TEXTS

SAME = ("scene", "backend", "configuration", "spoken", "parameters", "threads", "series", "fineness", "status", "detail", "verdict", "stride", "frames",
        "build_s", "structure_bytes", "is_disturbed", "sites", "open_sites", "true_contacts", "queries_hash",
        "contact_hash")
RENAMED = {"ok_repetitions": "repetitions", "collision_ms": "time_ms", "collision_ms_low": "time_ms_low", "collision_ms_high": "time_ms_high"}
MILLIMETRES = {"p99_offset_m": "offset_mm", "max_missed_depth_m": "missed_mm",
               "max_false_distance_m": "false_mm", "declared_missed_m": "declared_missed_mm", "declared_false_m": "declared_false_mm"}
OWN = {"collision_ms": "own_ms", "collision_ms_low": "own_ms_low", "collision_ms_high": "own_ms_high", "state_hash": "state_hash"}
ARMS = {"arm_rms_mm": "arm_mm", "arm_floor_mm": "arm_floor_mm"}
FORCES = ("pressure_percent", "pressure_floor_percent", "torque_percent", "torque_floor_percent")
KEY = ["scene", "configuration"]
NEEDED = ("mode", "scene", "muscle", "backend", "configuration", "parameters", "threads", "status", *RENAMED, "p99_offset_m")
MODE_OF_ANSWERS = "replay"  # all backends at the same positions


def study_rows(folder: Path) -> pd.DataFrame:
    """In the order of the study. A column that its tables do not have is empty."""
    study = _table(folder, "study")
    if study is None:
        raise Problem(f"{folder}: has no study.csv; name the --out of tools/accuracy, or a study in reports/measured")
    if missing := [name for name in NEEDED if name not in study]:
        raise Problem(f"{folder}: its study.csv lacks the column {missing[0]}; let tools/accuracy --report-only write it again")
    replays = study[study["mode"] == MODE_OF_ANSWERS]
    if replays.empty:
        raise Problem(f"{folder / 'study.csv'}: has no row of mode {MODE_OF_ANSWERS}; let tools/accuracy end")
    rows = pd.DataFrame({name: replays.get(name) for name in SAME})
    for given, name in RENAMED.items():
        rows[name] = replays[given]
    for given, name in MILLIMETRES.items():
        rows[name] = 1e3 * replays[given] if given in replays else None
    rows = _with(rows, _of_mode(study, "arms", OWN))
    rows = _with(rows, _by_muscle(folder, "contact_difficulties", study, {f"{kind}_mm": f"{kind}_mm" for kind in TITLES}))
    rows = _with(rows, _by_muscle(folder, "arm_errors", study, ARMS))
    rows = _with(rows, _by_muscle(folder, "force_errors", study, dict(zip(FORCES, FORCES))))
    flags = list(FLAGS)
    rows[flags] = rows[flags].astype(object).where(rows[flags].notna(), False).astype(bool)
    return rows.reindex(columns=NAMES).reset_index(drop=True)


def _table(folder: Path, name: str) -> pd.DataFrame | None:
    """Beside the runs of a study its tables are in a folder of their own."""
    path = next((path for path in (folder / f"{name}.csv", folder / "tables" / f"{name}.csv") if path.is_file()), None)
    try:
        # A hash may look like a number.
        return None if path is None else pd.read_csv(path, keep_default_na=False, na_values=[""], dtype=dict.fromkeys(TEXTS, str))
    except ValueError as problem:
        raise Problem(f"{path}: not a table ({problem}); let tools/accuracy --report-only write it again") from None


def _of_mode(study: pd.DataFrame, mode: str, names: dict[str, str]) -> pd.DataFrame:
    mine = study[(study["mode"] == mode) & study["status"].isin(MEASURED)]
    found = mine[KEY].copy()
    for given, name in names.items():
        found[name] = mine.get(given)
    return found


def _by_muscle(folder: Path, name: str, study: pd.DataFrame, names: dict[str, str]) -> pd.DataFrame:
    """These tables know a muscle and not its scene; what two scenes share is left out."""
    table = _table(folder, name)
    scenes = study[["scene", "muscle"]].drop_duplicates()
    scenes = scenes[~scenes["muscle"].duplicated(keep=False)]
    if table is None or table.empty:
        return pd.DataFrame(columns=[*KEY, *names.values()])
    table = table.assign(configuration=table["configuration"].str.removesuffix(MARK)).merge(scenes, on="muscle")
    return table[[*KEY, *names]].rename(columns=names)


def _with(rows: pd.DataFrame, more: pd.DataFrame) -> pd.DataFrame:
    return rows.merge(more.drop_duplicates(KEY), on=KEY, how="left")
