"""What the board says of each row: whether its answers were computed here, which questions it answers, and whether it may win."""

import math
from collections.abc import Sequence
from typing import Any

import pandas as pd

from ..accuracy.front import EXACT_MM
from ..results.status import MEASURED
from ..tables.difficulties import TITLES
from .bundle import Bundle, Told
from .columns import JUDGED, NUMBERS
from .project_scenes import is_of_project

KEY = ["scene", "backend", "parameters", "threads", "stride"]  # names are words; these decide the answers
FEWEST_CONTACTS = 100
OPEN_SHARE = 0.01  # an offset is the 99th percentile
LARGEST_BOUND_MM = 5.0  # of the closed division
SAME = 1e-9  # figures that were computed alike, relative
VERIFIED, CLAIMED, REFUTED, UNHASHED, OTHER = "verified", "claimed", "refuted", "claimed, no hash", "claimed, other version"


def board_rows(bundles: Sequence[Bundle], recomputed: Sequence[pd.DataFrame] = (), commit: str = "") -> pd.DataFrame:
    """Of all bundles, with what the board says of them. `recomputed`: rows with answers that the program of `commit` gave here. What
    was computed here takes the place of what is claimed."""
    answers = {tuple(row[key] for key in KEY): row for table in recomputed for row in table.to_dict("records") if row["contact_hash"]}
    told = [_told(row, answers, commit) for bundle, machine in zip(bundles, machines_of(bundles)) for row in _rows_of(bundle, machine)]
    questions = _questions(answers, told)
    for row in told:
        row["bound"] = _bound(row)
        row |= _within_search(row)
        row["is_old"] = bool(row["queries_hash"]) and questions.get((row["scene"], row["stride"])) != row["queries_hash"]
        row["why_not"] = _why_not(row)
        row["division"] = "closed" if _is_closed(row) else "open"
    return pd.DataFrame(told)


def _within_search(row: Told) -> Told:
    """Where a backend's surface is farther away than was searched, an offset is the end of the search and no figure. Such places have
    the largest offsets, so a percentile that they reach is above all others."""
    is_open = bool(row["open_sites"] > OPEN_SHARE * row["sites"])
    reached = [f"{kind}_mm" for kind in TITLES if row["open_sites"] > 0 and (is_open or row[f"{kind}_mm"] > row["offset_mm"])]
    return {"is_open": is_open} | dict.fromkeys([*reached, *(["offset_mm"] if is_open else [])], float("nan"))


def machines_of(bundles: Sequence[Bundle]) -> list[str]:
    """A name for each bundle, as times compare within one only."""
    names: list[str] = []
    for bundle in bundles:
        again = sum(name == bundle.machine or name.startswith(f"{bundle.machine} (") for name in names)
        names.append(f"{bundle.machine} ({again + 1})" if again else bundle.machine)
    return names


def _rows_of(bundle: Bundle, machine: str) -> list[Told]:
    about, rows = bundle.header, bundle.rows.astype(dict.fromkeys(NUMBERS, float))
    told: list[Told] = rows.assign(title=about["title"], machine=machine, measured=about["measured"], commit=about["commit"]).to_dict("records")
    return told


def _told(row: Told, answers: dict[tuple[Any, ...], Told], commit: str) -> Told:
    here = answers.get(tuple(row[key] for key in KEY))
    standing, why = _standing(row, here, commit)
    computed = {key: value for key, value in (here or {}).items() if key in (*JUDGED, "configuration", "spoken")} if standing == VERIFIED else {}
    return row | computed | {"standing": standing, "refutation": why}


def _standing(row: Told, here: Told | None, commit: str) -> tuple[str, str]:
    """With what refutes it. Verified: the same answers, errors and name to the same questions. Another version may answer otherwise
    in good faith."""
    if not row["contact_hash"] or not row["queries_hash"]:
        return UNHASHED, ""
    if here is None or here["queries_hash"] != row["queries_hash"]:
        return CLAIMED, ""
    why = ""
    if here["contact_hash"] != row["contact_hash"]:
        why = "its answers are not those that it gives here"
    elif here["configuration"] != row["configuration"]:
        why = f"its parameters are those of '{here['configuration']}'"
    elif wrong := [name for name in JUDGED if name in here and _differ(row[name], here[name])]:
        why = f"{wrong[0]} is {_words(here[wrong[0]])} here, not {_words(row[wrong[0]])}"
    return (VERIFIED, "") if not why else (REFUTED if row["commit"] == commit else OTHER, why)


def _differ(claimed: float, found: float) -> bool:
    """What is not told helps nobody: no error is no place in the ranking."""
    return not pd.isna(claimed) and not math.isclose(claimed, found, rel_tol=SAME, abs_tol=EXACT_MM)


def _words(value: float) -> str:
    return "unknown" if pd.isna(value) else f"{value:.4g}"


def _bound(row: Told) -> str:
    """Whether it kept its own word. One that gives none may err by anything; where nothing touched there was nothing to keep."""
    seen = [(row[f"{what}_mm"], row[f"declared_{what}_mm"]) for what in ("missed", "false")]
    if any(value > declared + EXACT_MM for value, declared in seen):  # never of what is unknown
        return "broken"
    if any(pd.isna(value) for value, _ in seen) or not row["true_contacts"] >= FEWEST_CONTACTS:
        return "not judged"
    return "none declared" if any(pd.isna(declared) for _, declared in seen) else "held"


def _questions(answers: dict[tuple[Any, ...], Told], rows: Sequence[Told]) -> dict[tuple[Any, ...], str]:
    """By scene and stride: what is asked here, else what the first bundle with a hash was asked. Whoever makes the board chooses what
    stands first, and a stranger's date changes nothing."""
    asked: dict[tuple[Any, ...], str] = {}
    for row in [*answers.values(), *rows]:
        if row["queries_hash"]:
            asked.setdefault((row["scene"], row["stride"]), row["queries_hash"])
    return asked


def _is_closed(row: Told) -> bool:
    """Everyone can have the scene, all of its frames were asked, and a bound that says something was held."""
    says_something = max(row["declared_missed_mm"], row["declared_false_mm"]) <= LARGEST_BOUND_MM
    return bool(is_of_project(row["scene"]) and row["bound"] == "held" and says_something and row["stride"] == 1
                and row["standing"] in (VERIFIED, CLAIMED) and not row["why_not"])


def _why_not(row: Told) -> str:
    """Why it is shown and can't win; empty where it can."""
    if row["status"] not in MEASURED or pd.isna(row["time_ms"]):
        return f"{row['status']}: {row['detail']}" if row["detail"] else str(row["status"])
    if row["standing"] in (REFUTED, OTHER):
        return str(row["refutation"])
    if row["is_old"]:
        return "it answers other questions than the scene asks now"
    if row["bound"] == "broken":
        return "errs by more than it declares"
    if row["verdict"].startswith("wrong"):
        return str(row["verdict"])
    return "several threads: what they gain is another question" if row["threads"] != 1 else ""
