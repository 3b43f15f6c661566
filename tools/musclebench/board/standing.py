"""What the board says of each row: whether its answers were computed here, which questions it answers, and whether it may win."""

import math
from collections.abc import Sequence
from typing import Any

import pandas as pd

from ..results.status import MEASURED
from .bundle import Bundle, Told
from .columns import JUDGED

KEY = ["scene", "backend", "parameters", "threads", "stride"]  # names are words; these decide the answers
DATA_SETS = ("synthetic/", "lhdl/")  # scenes that everyone can have: the closed division
ROUNDING_MM = 1e-6  # a nanometre
SAME = 1e-9  # figures that were computed alike, relative
VERIFIED, CLAIMED, REFUTED, UNHASHED, OTHER = "verified", "claimed", "refuted", "claimed, no hash", "claimed, other version"


def board_rows(bundles: Sequence[Bundle], recomputed: Sequence[pd.DataFrame] = (), commit: str = "") -> pd.DataFrame:
    """Of all bundles, with what the board says of them. `recomputed`: rows with answers that the program of `commit` gave here."""
    rows = pd.concat([_rows_of(bundle, index) for index, bundle in enumerate(bundles)], ignore_index=True)
    answers = {tuple(row[key] for key in KEY): row for table in recomputed for row in table.to_dict("records") if row["contact_hash"]}
    told = [_standing(row, answers, commit) for row in rows.to_dict("records")]
    rows["standing"], rows["refutation"] = [standing for standing, _ in told], [why for _, why in told]
    rows["bound"] = [_bound(row) for row in rows.to_dict("records")]
    rows["is_old"] = _are_old(rows, answers)
    rows["why_not"] = [_why_not(row) for row in rows.to_dict("records")]
    rows["why_not"] = rows["why_not"].mask(_are_replaced(rows), "measured anew")
    is_closed = rows["scene"].str.startswith(DATA_SETS) & (rows["bound"] == "held") & ~rows["standing"].isin([UNHASHED, REFUTED]) & ~rows["is_old"]
    rows["division"] = is_closed.map({True: "closed", False: "open"})
    return rows


def _rows_of(bundle: Bundle, index: int) -> pd.DataFrame:
    about = bundle.header
    return bundle.rows.assign(bundle=index, title=about["title"], machine=bundle.machine, measured=about["measured"], commit=about["commit"])


def _standing(row: Told, answers: dict[tuple[Any, ...], Told], commit: str) -> tuple[str, str]:
    """With what refutes it. Verified: the same answers, errors and name to the same questions. Another version may answer otherwise
    in good faith."""
    if not row["contact_hash"] or not row["queries_hash"]:
        return UNHASHED, ""
    here = answers.get(tuple(row[key] for key in KEY))
    if here is None or here["queries_hash"] != row["queries_hash"]:
        return CLAIMED, ""
    if here["contact_hash"] != row["contact_hash"]:
        return (REFUTED, "its answers are not those that it gives here") if row["commit"] == commit else (OTHER, "")
    if here["configuration"] != row["configuration"] or (here["spoken"] and row["spoken"] != here["spoken"]):
        return REFUTED, f"its parameters are those of '{here['configuration']}'"
    wrong = [name for name in JUDGED if name in here and _differ(row[name], here[name])]
    return (REFUTED, f"{wrong[0]} is {_words(here[wrong[0]])} here, not {_words(row[wrong[0]])}") if wrong else (VERIFIED, "")


def _differ(claimed: float, found: float) -> bool:
    """What is not told helps nobody: no error is no place in the ranking."""
    return not pd.isna(claimed) and not math.isclose(claimed, found, rel_tol=SAME, abs_tol=ROUNDING_MM)


def _words(value: float) -> str:
    return "unknown" if pd.isna(value) else f"{value:.4g}"


def _bound(row: Told) -> str:
    """Whether it kept its own word. One that gives none may err by anything."""
    held, declares = True, True
    for what in ("missed", "false"):
        seen, declared = row[f"{what}_mm"], row[f"declared_{what}_mm"]
        if pd.isna(seen):
            return "not judged"
        declares = declares and not pd.isna(declared)
        held = held and (pd.isna(declared) or seen <= declared + ROUNDING_MM)
    return "broken" if not held else "held" if declares else "none declared"


def _are_old(rows: pd.DataFrame, answers: dict[tuple[Any, ...], Told]) -> list[bool]:
    """Those that answer another query set than the answers here do, else than the first bundle with a hash does: whoever makes the
    board chooses what stands first, and a stranger's date changes nothing."""
    asked: dict[tuple[Any, ...], str] = {}
    for row in [*answers.values(), *rows.to_dict("records")]:
        if row["queries_hash"] and not pd.isna(row["stride"]):
            asked.setdefault((row["scene"], row["stride"]), row["queries_hash"])
    known = {scene for scene, _ in asked}
    return [row["scene"] in known and asked.get((row["scene"], row["stride"]), row["queries_hash"] or "?") != row["queries_hash"]
            if not pd.isna(row["stride"]) else row["scene"] in known for row in rows.to_dict("records")]


def _are_replaced(rows: pd.DataFrame) -> "pd.Series[bool]":
    """By a newer row of the same bundle's name and machine that can win."""
    able = rows[rows["why_not"] == ""].sort_values("measured", kind="stable")
    replaced = able.duplicated([*KEY, "machine"], keep="last")
    return replaced.reindex(rows.index, fill_value=False)


def _why_not(row: Told) -> str:
    """Why it is shown and can't win; empty where it can."""
    if row["status"] not in MEASURED or pd.isna(row["time_ms"]):
        return f"{row['status']}: {row['detail']}" if row["detail"] else str(row["status"])
    if row["standing"] == REFUTED:
        return str(row["refutation"])
    if row["bound"] == "broken":
        return "errs by more than it declares"
    if row["verdict"].startswith("wrong"):
        return str(row["verdict"])
    return "several threads: what they gain is another question" if row["threads"] != 1 else ""
