"""What the board says of each row: whether its answers were recomputed, how old it is, and whether it may win."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from ..results.status import MEASURED
from .bundle import Bundle, Told

SAME_ANSWERS = ["scene", "backend", "configuration", "threads"]
OURS = ("synthetic/", "lhdl/")  # scenes that everyone can have: the closed division
ROUNDING_MM = 1e-6
VERIFIED, CLAIMED, REFUTED, UNHASHED = "verified", "claimed", "refuted", "claimed, no hash"


def board_rows(bundles: Sequence[Bundle], recomputed: Sequence[pd.DataFrame] = ()) -> pd.DataFrame:
    """Of all bundles, with what the board says of them. Of a setting that one machine measured twice the newest counts."""
    rows = pd.concat([_rows_of(bundle, index) for index, bundle in enumerate(bundles)], ignore_index=True)
    rows["standing"] = _standings(rows, recomputed)
    rows["bound"] = rows.apply(_bound, axis=1)
    rows["is_old"] = _are_old(rows)
    rows["is_replaced"] = rows.sort_values("measured", kind="stable").duplicated([*SAME_ANSWERS, "machine"], keep="last")
    is_wrong = rows["verdict"].str.startswith("wrong")
    rows["why_not"] = [_why_not(row, wrong) for row, wrong in zip(rows.to_dict("records"), is_wrong)]
    is_ours = rows["scene"].str.startswith(OURS)
    rows["division"] = ["closed" if ours and bound == "held" and standing != UNHASHED and not old else "open"
                        for ours, bound, standing, old in zip(is_ours, rows["bound"], rows["standing"], rows["is_old"])]
    return rows


def _rows_of(bundle: Bundle, index: int) -> pd.DataFrame:
    about = bundle.header
    return bundle.rows.assign(bundle=index, machine=bundle.machine, measured=about["measured"], commit=about["commit"])


def _standings(rows: pd.DataFrame, recomputed: Sequence[pd.DataFrame]) -> list[str]:
    """Verified: the same answers to the same questions, to the last bit. Refuted: others to the same questions."""
    known: dict[tuple[Any, ...], set[str]] = {}
    for answers in recomputed:
        for row in answers.to_dict("records"):
            if row["contact_hash"]:
                known.setdefault((*(row[key] for key in SAME_ANSWERS), row["queries_hash"]), set()).add(row["contact_hash"])
    found = []
    for row in rows.to_dict("records"):
        here = known.get((*(row[key] for key in SAME_ANSWERS), row["queries_hash"])) if row["queries_hash"] else None
        found.append(UNHASHED if not row["contact_hash"] or not row["queries_hash"]
                     else CLAIMED if here is None else VERIFIED if here == {row["contact_hash"]} else REFUTED)
    return found


def _bound(row: "pd.Series[Any]") -> str:
    """Whether it kept its own word. One that gives none may err by anything."""
    held, declares = True, True
    for what in ("missed", "false"):
        seen, declared = row[f"{what}_mm"], row[f"declared_{what}_mm"]
        if pd.isna(seen):
            return "not judged"
        declares = declares and not pd.isna(declared)
        held = held and (pd.isna(declared) or seen <= declared + ROUNDING_MM)
    return "broken" if not held else "held" if declares else "none declared"


def _are_old(rows: pd.DataFrame) -> list[bool]:
    """Of a scene and stride those that answered another query set than the newest bundle."""
    hashed = rows[rows["queries_hash"] != ""].sort_values("measured", kind="stable")
    newest = hashed.drop_duplicates(["scene", "stride"], keep="last").set_index(["scene", "stride"])["queries_hash"].to_dict()
    keys = zip(rows["scene"], rows["stride"], rows["queries_hash"])
    return [bool(newest) and newest.get((scene, stride), queries) != queries for scene, stride, queries in keys]


def _why_not(row: Told, is_wrong: bool) -> str:
    """Why it is shown and can't win; empty where it can."""
    if row["is_control"]:
        return "finds no collision: the cost of the loop alone"
    if row["status"] not in MEASURED or pd.isna(row["time_ms"]):
        return f"{row['status']}: {row['detail']}" if row["detail"] else str(row["status"])
    if row["standing"] == REFUTED:
        return "its answers are not those that its program gives here"
    if row["bound"] == "broken":
        return "errs by more than it declares"
    if is_wrong:
        return str(row["verdict"])
    if row["is_replaced"]:
        return "measured anew by the same machine"
    return ""
