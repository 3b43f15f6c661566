"""What was run and on what, and what went wrong, of coupled runs."""

import pandas as pd

from ..figures import looks
from ..figures.paper_figures import caption
from ..results.disturbance import note
from ..results.licences import citations_of, licences_of
from ..results.run_folder import Run
from ..results.status import MEASURED
from ..tables.paper_tables import disturbed_runs


def what_was_run(runs: list[Run]) -> list[tuple[str, str]]:
    counts = pd.Series([run.status for run in runs]).value_counts()
    records = [run.record for run in runs]
    sources = [("Licence of the shapes", "; ".join(licences_of(records))), ("Cite", "; ".join(citations_of(records)))]
    return [("Runs", f"{len(runs)}: " + ", ".join(f"{count} {status}" for status, count in counts.items())),
            ("What and on what", caption(runs)),
            ("Scenes", ", ".join(dict.fromkeys(run.scene for run in runs))),
            ("Backends", ", ".join(looks.title_and_name(name) for name in looks.backends_in_order(run.backend for run in runs))),
            ("Results schema", str(runs[0].record.get("schema_version", "unknown"))), *((name, text) for name, text in sources if text)]


def problems_of(runs: list[Run]) -> list[str]:
    """Failed runs first, then those that are suspect, each with its reasons."""
    failed = [f"{run.scene} with {looks.title_and_name(run.backend)}: {run.status}, {run.record.get('status_detail')}"
              for run in sorted(runs, key=lambda run: run.status in MEASURED) if run.status != "ok"]
    warned = {f"{run.scene}: {warning['text']}" for run in runs for warning in run.record.get("warnings") or []}
    noted = [f"{run.scene} with {looks.title_and_name(run.backend)}: {text}" for run in runs for text in run.record.get("notes") or []]
    busy = note(disturbed_runs(runs), len(runs))
    return [*failed, *sorted(warned), *noted, *([busy] if busy else [])]
