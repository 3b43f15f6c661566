"""The history as other tools read it.

Apache Otava imports CSV files with a column of times, attributes and metrics, which its otava.yaml names
(github.com/apache/otava, docs/CSV.md); Bencher takes a JSON object of benchmarks, each of measures with `value`,
`lower_value` and `upper_value` (bencher.dev/docs/reference/bencher-metric-format)."""

import csv
import io
import json
import re
from pathlib import Path

import pandas as pd

from ..comparison.metrics import EXACT
from ..program.fingerprint import write_whole
from .history import Night


def write_otava(measures: pd.DataFrame, nights: list[Night], folder: Path) -> list[Path]:
    """otava.yaml, and of each case a CSV file with a row a night."""
    folder.mkdir(parents=True, exist_ok=True)
    numbers = measures[(measures["kind"] != EXACT) & measures["value"].notna()]
    files, tests = [], ["tests:"]
    for case, rows in numbers.groupby("case", sort=False):
        table = rows.pivot(index="night", columns="metric", values="value")
        files.append(folder / f"{_file_name(case)}.csv")
        write_whole(files[-1], _csv(table, nights))
        # JSON's strings and lists are YAML's, too.
        tests += [f"  {json.dumps(_file_name(case))}:", "    type: csv", f"    file: {json.dumps(str(files[-1]))}",
                  "    time_column: time", "    attributes: [commit]", f"    metrics: {json.dumps(list(table.columns))}"]
    write_whole(folder / "otava.yaml", "\n".join(tests) + "\n")
    return [folder / "otava.yaml", *files]


def bencher_metrics(measures: pd.DataFrame, night: int) -> dict:
    """Of one night."""
    found: dict[str, dict] = {}
    for row in measures[(measures["night"] == night) & (measures["kind"] != EXACT)].itertuples():
        ends = {name: end for name, end in (("lower_value", row.low), ("upper_value", row.high)) if pd.notna(end)}
        found.setdefault(row.case, {})[row.metric] = {"value": row.value, **ends}
    return found


def _csv(table: pd.DataFrame, nights: list[Night]) -> str:
    known = {night.id: night for night in nights}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", "commit", *table.columns])
    for night, values in table.iterrows():
        writer.writerow([known[night].started, known[night].git, *("" if pd.isna(value) else repr(float(value)) for value in values)])
    return text.getvalue()


def _file_name(case: str) -> str:
    return re.sub(r"[^A-Za-z0-9_.=-]", "_", case)
