"""How the frames of each timed case are spread: over a run, and from run to run. A median alone hides both."""

import pandas as pd

from ..results.disturbance import MARK, disturbed, note
from ..results.run_folder import Run
from ..results.samples import variation
from ..results.statistics import frame_tail, pooled_median
from ..results.status import MEASURED
from ..tables.table_formats import Column, Table

COLUMNS = [
    Column("case", "case"), Column("runs", "runs", 0), Column("warm_up_frames", "warm-up frames", 0),
    Column("frame_ms", "frame ms", 4, "frame\nms"), Column("low_ms", "frame, 95 % low", 4, "95 %\nlow"),
    Column("high_ms", "frame, 95 % high", 4, "95 %\nhigh"), Column("p95_ms", "frame, p95", 4, "p95\nms"),
    Column("p99_ms", "frame, p99", 4, "p99\nms"), Column("variation_percent", "frame, CV %", 1, "CV\n%"),
    Column("collision_ms", "collision ms", 4, "collision\nms"), Column("collision_low_ms", "collision, 95 % low", 4),
    Column("collision_high_ms", "collision, 95 % high", 4), Column("collision_p99_ms", "collision, p99", 4),
    Column("judged", "judged"), Column("cores", "cores it may use"), Column("governor", "governor"), Column("turbo", "turbo"),
    Column("smt", "SMT"), Column("disturbed", "runs disturbed", 0),
]
SHOWN = ["case", "runs", "frame_ms", "low_ms", "high_ms", "p95_ms", "p99_ms", "variation_percent", "collision_ms"]
CAPTION = ("Times of a frame over all runs of a case, warm-up frames left out: median with its 95 % interval (bootstrap over runs and "
           "blocks of frames), 95th and 99th percentile, coefficient of variation of the medians of the runs. Collision is update, "
           "detection and response; a replay has no other times.")
JUDGED = "In judged runs the Referee leaves colder caches before each frame, and its time is not counted."
WORDS = {True: "on", False: "off", None: ""}


def spread_table(runs: dict[str, list[Run]]) -> Table:
    """`runs`: of each case its repetitions, in the order of the table."""
    timed = {case: chosen for case, some in runs.items() if (chosen := timed_runs(some))}
    every = [run for some in timed.values() for run in some]
    busy = disturbed({run.folder.name: run.record for run in every})
    rows = [_row(case, some, busy) for case, some in timed.items()]
    notes = [JUDGED] if any(is_judged(run) for run in every) else []
    caption = " ".join([CAPTION, *notes, *filter(None, [note(busy, len(every))])])
    return Table("frame_spread", caption, COLUMNS, pd.DataFrame(rows, columns=[column.key for column in COLUMNS]), SHOWN)


def timed_runs(repetitions: list[Run]) -> list[Run]:
    """Of a case that is judged in its first repetition only the others."""
    timed = [run for run in repetitions
             if run.status in MEASURED and "collision_ns" in run.frames and run.timed_frames["collision_ns"].notna().any()]
    return [run for run in timed if not is_judged(run)] or timed


def is_judged(run: Run) -> bool:
    return bool(run.record["case"].get("judged"))


def _row(case: str, runs: list[Run], busy: dict[str, str]) -> dict:
    names = [run.folder.name for run in runs]
    state = runs[0].record.get("machine_state") or {}
    frame, collision = _times(runs, "frame_ns"), _times(runs, "collision_ns")
    return {
        "case": case + (MARK if any(name in busy for name in names) else ""), "runs": len(runs),
        "warm_up_frames": runs[0].warm_up_count, "frame_ms": frame["median"], "low_ms": frame["low"],
        "high_ms": frame["high"], "p95_ms": frame["p95"], "p99_ms": frame["p99"], "variation_percent": frame["variation"],
        "collision_ms": collision["median"], "collision_low_ms": collision["low"], "collision_high_ms": collision["high"],
        "collision_p99_ms": collision["p99"], "judged": "yes" if is_judged(runs[0]) else "", "cores": state.get("allowed_cores", ""),
        "governor": state.get("governor") or "", "turbo": WORDS[state.get("turbo")], "smt": WORDS[state.get("smt")],
        "disturbed": sum(name in busy for name in names),
    }


def _times(runs: list[Run], column: str) -> dict[str, float]:
    if any(column not in run.frames or run.timed_frames[column].isna().all() for run in runs):
        return dict.fromkeys(("median", "low", "high", "p95", "p99", "variation"), float("nan"))
    by_frame = [run.timed_frames.set_index("frame")[column] for run in runs]
    median = pooled_median(by_frame).scaled(1e-6)
    p95, p99 = frame_tail(by_frame)
    return {"median": median.value, "low": median.low, "high": median.high, "p95": 1e-6 * p95, "p99": 1e-6 * p99,
            "variation": 100 * variation(pd.Series([times.median() for times in by_frame]))}
