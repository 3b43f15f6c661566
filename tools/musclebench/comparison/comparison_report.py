"""A comparison as Markdown, for a terminal and for a pull request."""

import math

import pandas as pd

from ..results.disturbance import MARK, note
from ..tables.table_formats import UNKNOWN, Column, markdown_rows
from .metrics import EXACT, TIME, Metric
from .result_set import ResultSet
from .spread import Spread, spread_of
from .verdicts import LEVEL, Comparison, Row

UNITS = ((1e9, "s"), (1e6, "ms"), (1e3, "us"))
HASH_LETTERS = 12
COLUMNS = [Column("case", "case"), Column("metric", "what"), Column("before", "before"), Column("after", "after"),
           Column("ratio", "after / before"), Column("interval", "95 %"), Column("chance", "p"), Column("verdict", "verdict")]
SPREAD_COLUMNS = [Column("case", "case"), Column("runs", "runs"), Column("median", "frame, median"), Column("interval", "95 %"),
                  Column("p95", "p95"), Column("p99", "p99"), Column("cv", "CV"), Column("interrupted", "interrupted"),
                  Column("pinned", "core"), Column("governor", "governor"), Column("turbo", "turbo"), Column("smt", "SMT")]
WORDS = {True: "on", False: "off", None: UNKNOWN}


def report(comparison: Comparison, notes: list[str]) -> str:
    changes, rest = comparison.changes, [row for row in comparison.rows if not row.is_change and row.metric.kind != EXACT]
    parts = [f"## {_headline(comparison)}", _origin(comparison)]
    if changes:
        parts += ["### What changed", _table(changes)]
    if rest:
        parts += ["<details><summary>Times and counters that did not change, or can't be told</summary>", _table(rest), "</details>"]
    for one in (comparison.before, comparison.after):
        spreads = [spread for case, samples in one.cases.items() if (spread := spread_of(case, samples))]
        if spreads:
            parts += [f"<details><summary>Frames of {one.name}</summary>", spread_table(spreads), "</details>"]
    parts.append("\n".join(f"- {line}" for line in [*_warnings(comparison), *notes]))
    return "\n\n".join(parts) + "\n"


def spread_table(spreads: list[Spread]) -> str:
    rows = [{
        "case": spread.case + (MARK if spread.disturbed else ""),
        "runs": f"{spread.runs} (warm-up {spread.warm_up_frames} frames)", "median": as_time(spread.median.value),
        "interval": _interval(spread.median, as_time), "p95": as_time(spread.p95), "p99": as_time(spread.p99),
        "cv": UNKNOWN if math.isnan(spread.variation) else f"{100 * spread.variation:.1f} %",
        "interrupted": f"{100 * spread.interrupted:.0f} %", "pinned": spread.settings.get("core", "not noted"),
        "governor": spread.settings.get("governor") or UNKNOWN, "turbo": WORDS[spread.settings.get("turbo")],
        "smt": WORDS[spread.settings.get("smt")],
    } for spread in spreads]
    return markdown_rows(SPREAD_COLUMNS, pd.DataFrame(rows))


def as_time(ns: float) -> str:
    if math.isnan(ns):
        return UNKNOWN
    scale, unit = next(((scale, unit) for scale, unit in UNITS if ns >= scale), (1.0, "ns"))
    return f"{ns / scale:.4g} {unit}"


def shown(value: float | str, metric: Metric) -> str:
    if isinstance(value, str):
        return value[:HASH_LETTERS] if metric.name.endswith("_hash") and " or " not in value else value or UNKNOWN
    return as_time(value) if metric.kind == TIME else f"{value:.12g}"


def as_ratio(value: float) -> str:
    return f"{value:.3f}" if value < 100 else f"{value:.4g}"


def _table(rows: list[Row]) -> str:
    return markdown_rows(COLUMNS, pd.DataFrame([_cells(row) for row in rows]))


def _cells(row: Row) -> dict:
    doubt = "" if row.is_trusted else MARK
    ratio = UNKNOWN if math.isnan(row.ratio.value) else as_ratio(row.ratio.value) + doubt
    verdict = f"**{row.verdict}**" if row.is_change else row.verdict
    return {"case": row.case, "metric": row.metric.name, "before": shown(row.before, row.metric),
            "after": shown(row.after, row.metric), "ratio": f"({ratio})" if doubt and ratio != UNKNOWN else ratio,
            "interval": _interval(row.ratio, as_ratio), "chance": UNKNOWN if math.isnan(row.chance) else f"{row.chance:.2g}",
            "verdict": f"{verdict} ({row.why})" if row.why else verdict}


def _interval(estimate, form) -> str:
    return UNKNOWN if math.isnan(estimate.low) else f"{form(estimate.low)} to {form(estimate.high)}"


def _headline(comparison: Comparison) -> str:
    count, compared = len(comparison.changes), len(comparison.rows)
    named = f"{comparison.before.name} to {comparison.after.name}"
    return f"{named}: {count} of {compared} figures changed" if count else f"{named}: no change in {compared} figures"


def _origin(comparison: Comparison) -> str:
    return "\n".join(f"- {one.name}: {_words(one)}" for one in (comparison.before, comparison.after))


def _words(one: ResultSet) -> str:
    told = [" and ".join(map(str, one.told(*keys))) or "unknown"
            for keys in (("build", "git"), ("build", "compiler"), ("build", "type"), ("machine", "cpu"))]
    return f"commit {told[0]}, {told[1]} {told[2]}, {told[3]}, {len(one.samples)} runs of {len(one.cases)} cases"


def _warnings(comparison: Comparison) -> list[str]:
    found = [f"left out: {fault}" for one in (comparison.before, comparison.after) for fault in one.faults]
    count = len(comparison.before.samples) + len(comparison.after.samples)
    lines = [note(comparison.disturbed, count)] if comparison.disturbed else []
    if not comparison.is_interleaved:
        taken = ", ".join(f"{name} x {as_ratio(factor)}" for name, factor in comparison.machine.items())
        lines.append("The two were not interleaved, so that the machine may have changed between them"
                     + (f"; what all cases share was taken out as the machine's: {taken}" if taken else "") + ".")
    if comparison.is_one_program:
        lines.append("Both ran the same program: what differs is the machine's, or the program is not deterministic.")
    unclear = sum(row.verdict == "unclear" for row in comparison.rows)
    if comparison.fewest_runs > comparison.runs > 0:
        lines.append(f"{comparison.runs} runs a case can't show a change among so many figures; that takes {comparison.fewest_runs}.")
    if unclear:
        lines.append(f"{unclear} figures are unclear: neither a change nor its absence is shown; more --repetitions tell.")
    lines.append(f"Changed is what a test (Mann-Whitney's U, of interleaved runs or Yuen's of the pairs; p by Holm below {LEVEL:g}), the "
                 "interval and the smallest change that counts agree on: 5 % of a time, 1 % of a counter; answers have to be the same.")
    return found + lines
