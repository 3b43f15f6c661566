"""What came of a population: which settings hold for how many members, and what broke."""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from ..experiments.swept_case import SweptCase
from ..results.run_folder import Run
from ..tables.table_formats import Column, Table
from .shape_words import Shape

REFUSED = "refused"
Z = 1.959964  # 95 % of a normal distribution
FRAME = re.compile(r"\(frame (\d+)")


@dataclass
class Ending:
    """Of a member with a setting."""

    status: str
    detail: str = ""
    frame_ms: float = math.nan  # median
    bound: dict[str, int] = field(default_factory=dict)  # nodes of each attachment
    run: Run | None = None

    @property
    def holds(self) -> bool:
        return self.status == "ok"

    @property
    def worst_frame(self) -> int | None:
        found = FRAME.search(self.detail)
        return int(found[1]) if found else None


Endings = dict[str, dict[int, Ending]]  # {setting: {member: how it ended}}


def endings_of(cases: list[SweptCase], runs: dict[SweptCase, Run], records: dict[SweptCase, dict[str, Any]], numbers: dict[str, int],
               refused: dict[int, str]) -> Endings:
    """`records`: run.json of cases that have no run to read. What has neither has no ending."""
    found: Endings = {}
    for case in cases:
        mine = found.setdefault(case.configuration.label, {number: Ending(REFUSED, why) for number, why in refused.items()})
        run = runs.get(case)
        if run is None and not records.get(case):
            continue
        if run is None:
            record = records[case]
            ending = Ending(str(record.get("status", "failed")), str(record.get("status_detail", "")))
        else:
            frames = run.timed_frames
            ending = Ending(run.status, str(run.record.get("status_detail", "")),
                            float(frames["frame_ns"].median()) / 1e6 if "frame_ns" in frames else math.nan,
                            {f"{place} {one['name']}": int(one["nodes"]) for place, one in enumerate(run.record.get("attachments", []))}, run)
        mine[numbers[case.scene.name]] = ending
    return found


def interval(held: int, of: int) -> tuple[float, float]:
    """Of a share, with 95 % confidence. Source: Wilson 1927, J. Am. Stat. Assoc. 22, 209."""
    if of == 0:
        return 0.0, 1.0
    share, spread = held / of, Z * Z / of
    middle = (share + spread / 2) / (1 + spread)
    half = Z / (1 + spread) * math.sqrt(share * (1 - share) / of + spread / of / 4)
    return max(0.0, middle - half), min(1.0, middle + half)


def settings_table(endings: Endings, title: str) -> Table:
    rows = []
    for setting, by_member in endings.items():
        members = {number: one for number, one in by_member.items() if number > 0}
        held = sum(one.holds for one in members.values())
        low, high = interval(held, len(members))
        times = [one.frame_ms for one in members.values() if one.run is not None]
        counts = {status: sum(one.status == status for one in members.values()) for status in ("suspect", "diverged")}
        rows.append({"setting": setting, "members": len(members), "hold": held, "percent": 100 * held / len(members) if members else math.nan,
                     "low": 100 * low, "high": 100 * high, **counts, "other": len(members) - held - sum(counts.values()),
                     "scene_itself": by_member[0].status if 0 in by_member else "-", "frame_ms": float(pd.Series(times, dtype=float).median())})
    columns = [Column("setting", "setting"), Column("members", "members", 0), Column("hold", "hold", 0), Column("percent", "%", 1),
               Column("low", "from %", 1), Column("high", "to %", 1), Column("suspect", "suspect", 0), Column("diverged", "diverged", 0),
               Column("other", "other", 0), Column("scene_itself", "the scene itself"), Column("frame_ms", "frame, ms", 2)]
    caption = (f"{title}: members of a population for which a setting holds (their run ends ok), with the 95 % interval of their share, and the "
               "median time of a frame.")
    return Table("settings", caption, columns, pd.DataFrame(rows, columns=[one.key for one in columns]), [one.key for one in columns])


def members_table(endings: Endings, shapes: list[Shape], amounts: dict[int, list[list[float]]]) -> Table:
    names = [name for shape in shapes for name in shape.columns]
    rows = []
    bound = {number: one.bound for by_member in endings.values() for number, one in by_member.items() if one.bound}
    for number in sorted({number for one in endings.values() for number in one}):
        drawn = [value for one in amounts[number] for value in one] or [math.nan] * len(names)
        shares = [nodes / bound[0][name] for name, nodes in bound.get(number, {}).items() if bound.get(0, {}).get(name)]
        of_scene = {"bound_least": min(shares), "bound_most": max(shares)} if shares else {}
        ended = {setting: one[number].status for setting, one in endings.items() if number in one}
        rows.append({"member": number} | dict(zip(names, drawn)) | of_scene | ended)
    columns = [Column("member", "member", 0), *(Column(name, name, 3) for name in names), Column("bound_least", "bound nodes, from", 2),
               Column("bound_most", "to", 2), *(Column(setting, setting) for setting in endings)]
    caption = ("Shapes of the members (factors, degrees, standard deviations), the nodes of its attachments over those of the "
               "scene, and how each ended. Member 0 is the scene as it is.")
    return Table("members", caption, columns, pd.DataFrame(rows, columns=[one.key for one in columns]), [one.key for one in columns])


def broken_table(endings: Endings, commands: dict[tuple[str, int], str], pictures: dict[tuple[str, int], Path]) -> Table:
    rows = [{"member": number, "setting": setting, "status": one.status, "why": one.detail, "picture": str(pictures.get((setting, number), "")),
             "again": commands.get((setting, number), "")} for setting, by_member in endings.items() for number, one in sorted(by_member.items())
            if not one.holds and number > 0]
    columns = [Column("member", "member", 0), Column("setting", "setting"), Column("status", "status"), Column("why", "why"),
               Column("picture", "picture"), Column("again", "run it again by")]
    return Table("broken", "Runs that did not hold.", columns, pd.DataFrame(rows, columns=[one.key for one in columns]), ["member", "setting", "status", "why"])


def best_setting(table: Table, hold: float) -> "pd.Series[Any] | None":
    """The fastest that holds for at least so many percent."""
    enough = table.rows[table.rows["percent"] >= hold]
    return None if enough.empty else enough.loc[enough["frame_ms"].fillna(math.inf).idxmin()]


def answer(table: Table, endings: Endings, hold: float) -> str:
    """In a sentence or two."""
    if table.rows.empty:
        return "Nothing has run."
    best = best_setting(table, hold)
    if best is None:
        most = table.rows.loc[table.rows["percent"].idxmax()]
        words = (f"No setting holds for {hold:g} % of the members. The best is {most['setting']}: {most['hold']:.0f} of {most['members']:.0f} "
                 f"(95 % interval {most['low']:.0f} to {most['high']:.0f} %).")
    else:
        words = (f"{best['setting']} holds for {best['hold']:.0f} of {best['members']:.0f} members (95 % interval {best['low']:.0f} to "
                 f"{best['high']:.0f} %), in {best['frame_ms']:.3g} ms a frame")
        few = f"; with more members the share may prove to be below {hold:g} %" if best["low"] < hold else ""
        words += f"{few}." if len(table.rows) == 1 else f"; of {len(table.rows)} settings it is the fastest that holds for {hold:g} %{few}."
    broken = [{number for number, one in by_member.items() if number > 0 and not one.holds} for by_member in endings.values()]
    never = sorted(set.intersection(*broken))
    if never:
        words += f" No setting holds for {'member' if len(never) == 1 else 'members'} {', '.join(map(str, never[:12]))}{' ...' if len(never) > 12 else ''}."
    return words
