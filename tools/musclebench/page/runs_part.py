"""Runs of no study: those of `musclebench run`, one folder or several beside each other, over their frames and in space."""

from pathlib import Path

from ..accuracy.configurations import configuration
from ..figures import looks
from ..program.cli import Problem
from ..results.run_folder import Run, read_all
from .frame_charts import Cases, depth_chart, memory_chart, time_charts
from .looks_of import looks_of_names
from .parts import Part, Section
from .told_of_runs import problems_of, what_was_run
from .views import views_of


def run_folders(folder: Path) -> list[Path]:
    """The folder itself, those in it, or those in its raw."""
    for pattern in ("run.json", "*/run.json", "raw/*/run.json"):
        found = sorted(path.parent for path in folder.glob(pattern) if not path.parent.name.startswith("."))
        if found:
            return found
    return []


def is_runs(folder: Path) -> bool:
    return bool(run_folders(folder))


def runs_section(folder: Path) -> Section:
    """Of the coupled ones. Raises Problem where there are none."""
    runs = [run for run in read_all(run_folders(folder)) if run.mode == "coupled" and not run.frames.empty]
    if not runs:
        raise Problem(f"{folder}: holds no run of 'musclebench run' with frames; name its --out folder")
    cases = told_apart(runs)
    parts: list[Part] = [views_of(cases, "The runs in 3D"), *time_charts(cases), memory_chart(cases), depth_chart(cases)]
    return Section("runs", "Runs", what_was_run(runs), problems_of(runs), parts, looks_of_names(name for _, name in cases), folder)


def _name_of(run: Run) -> str:
    case = run.record["case"]
    return configuration(looks.backend(run.backend), case.get("parameters", {}), case.get("threads", 1)).spoken


def told_apart(runs: list[Run]) -> Cases:
    """By muscle and backend; runs of one backend by their settings as people write them, or by their folders."""
    cases: Cases = {}
    for run in runs:
        alike = [other for other in runs if (other.muscle, other.backend) == (run.muscle, run.backend)]
        names = [_name_of(other) for other in alike]
        own = _name_of(run) if names.count(_name_of(run)) == 1 else run.folder.resolve().name
        cases[run.muscle, run.backend if len(alike) == 1 else own] = run
    return cases
