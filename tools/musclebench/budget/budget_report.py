"""The table of sources, the table of all their settings, the figure, and a sentence for each scene."""

import math
from pathlib import Path

import pandas as pd

from ..experiments.caveats import caveats
from ..experiments.swept_case import SweptCase
from ..figures import looks
from ..figures.budget import draw_budget, draw_substeps
from ..program.optional_packages import left_out_without
from ..results.run_folder import Run, read_run
from ..tables.table_formats import Column, Table, write_table
from . import substeps_table
from .sources import FIGURES, Budget, Setting, Source, differences, frame_ms, in_words

NAMES = {"time_step": "time step", "iterations": "iterations"}  # of collision the backend is told, too
ERRORS = [
    Column("shape_mm", "shape, RMS mm", 3, "shape\nmm"), Column("arm_mm", "moment arm, RMS mm", 3, "arm\nmm"),
    Column("volume_percent", "volume %", 3, "volume\n%"), Column("surface_mm", "surface depth mm", 3, "depth\nmm"),
    Column("torque_percent", "joint torque %", 2, "torque\n%"), Column("pressure_percent", "peak pressure %", 2, "pressure\n%"),
]
COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("source", "source"), Column("setting", "setting"), *ERRORS,
    Column("order", "order", 2), Column("left_mm", "reference off by mm", 3, "left\nmm"),
    Column("halved_by", "halved by", head="halved\nby"), Column("times", "x time", is_ratio=True, digits=2),
]
SETTING_COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("source", "source"), Column("setting", "setting"),
    Column("status", "status"), Column("frame_ms", "ms a frame", 3), Column("times", "x time", is_ratio=True, digits=2), *ERRORS,
]
CAPTION = (
    "What each source of error moves, the others as they are: the run of the scene's own setting beside the finest setting of that "
    "source, or beside the exact backend. Shape at full flexion, over the nodes; moment arm over the motion; largest difference of "
    "the volume, of its volume at rest; largest depth of the surface; joint torque and peak pressure in percent of the finer run's. "
    "Rounding: the largest difference of three starts that are off by 1e-12 m; a source below it tells nothing. Order p: the shape's "
    "error falls as 1 / refinement^p; empty where the last steps don't agree on one. Reference off by: how far the finest shape is "
    "itself from the limit, by Richardson's rule where there is an order, else its last step. Halved by: the first finer setting with "
    "at most half of the shape's error, and its time; the finest itself only where there is an order. Times are medians of runs side by side, with forces told."
)
SETTINGS_CAPTION = "All runs of the budget: what each setting moves, from the finest of its source or from the exact run, and its time."


def write_report(done: dict[SweptCase, Path], out_dir: Path) -> tuple[Table, list[str], list[Path]]:
    """`done`: the complete cases of bench/experiments/budget.toml and their folders."""
    runs = {case: read_run(folder) for case, folder in done.items()}
    budgets = [budget for scene in dict.fromkeys(case.scene for case in runs)
               if (budget := budget_of({case: run for case, run in runs.items() if case.scene == scene}))]
    rows = pd.DataFrame([row for budget in budgets for row in _rows(budget)], columns=[column.key for column in COLUMNS])
    table = Table("budget", CAPTION, COLUMNS, rows, [column.key for column in COLUMNS if column.key != "muscle"])
    every = pd.DataFrame([row for budget in budgets for row in _setting_rows(budget)], columns=[column.key for column in SETTING_COLUMNS])
    settings = Table("settings", SETTINGS_CAPTION, SETTING_COLUMNS, every, [column.key for column in SETTING_COLUMNS if column.key != "muscle"])
    substeps = substeps_table.table([run for case, run in sorted(runs.items(), key=lambda one: _count(one[0], "substeps"))
                                     if case.group.name == "time_step"])
    for folder in (out_dir / "tables", out_dir / "figures"):
        folder.mkdir(parents=True, exist_ok=True)
    said = caveats(out_dir)
    files = [path for one in (table, settings, substeps) for path in write_table(one.with_sentence(said), out_dir / "tables")]
    with left_out_without("the figures"):
        files += draw_budget(rows, out_dir / "figures" / "budget") + draw_substeps(substeps.rows, out_dir / "figures" / "substeps")
    return table.with_sentence(said), [in_words(budget, _names(budget)) for budget in budgets], files


def budget_of(runs: dict[SweptCase, Run]) -> Budget | None:
    """Of one scene; None without the exact run of the scene's own setting."""
    scene = next(iter(runs)).scene
    exact = next((run for case, run in runs.items() if case.group.name == "time_step" and _count(case, "substeps") == scene.substeps), None)
    if exact is None:
        return None
    sources = [source for source in (
        _refined("time_step", "substeps", scene.substeps, runs, exact),
        _refined("iterations", "iterations", scene.iterations // scene.substeps, runs, exact)) if source]
    for case, run in runs.items():
        if case.group.name == "collision" and run.backend != exact.backend and not looks.backend(run.backend).is_control:
            plain = case.configuration.label == run.backend
            setting = Setting(looks.title_and_name(run.backend) if plain else case.configuration.label.replace("-", " ", 1), 1.0, run)
            sources.append(Source(f"collision, {setting.words}", [setting], setting, exact))
    starts = [differences(run, exact) for case, run in runs.items() if case.group.name == "rounding"]
    floor = {name: max(start[name] for start in starts if name in start) for name in FIGURES if any(name in start for start in starts)}
    return Budget(scene.name, exact.muscle, sources, floor)


def _refined(group: str, axis: str, own: int, runs: dict[SweptCase, Run], exact: Run) -> Source | None:
    counts = {_count(case, axis): run for case, run in runs.items() if case.group.name == group} | {own: exact}
    settings = [Setting(f"{count} {axis if count > 1 else axis[:-1]}", count / own, counts[count]) for count in sorted(counts)]
    usable = [one for one in settings if one.run.status in ("ok", "suspect") or one.factor < 1]
    mine = next(one for one in settings if one.run is exact)
    return Source(group, usable, mine, usable[-1].run) if usable[-1].factor > 1 else None


def _count(case: SweptCase, axis: str) -> int:
    return next((int(one.value) for one in case.point if one.axis == axis), 0)


def _names(budget: Budget) -> dict[str, str]:
    return {source.name: NAMES.get(source.name, source.name) for source in budget.sources}


def _rows(budget: Budget) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    names = _names(budget)
    for source in budget.sources:
        better = source.halving()
        rows.append({"muscle": budget.muscle, "scene": budget.scene, "source": names[source.name], "setting": source.own.words,
                     **source.errors(), "order": source.order(), "left_mm": source.left_mm() if source.is_refined else math.nan,
                     "halved_by": better.words if better else "",
                     "times": frame_ms(better.run) / frame_ms(source.own.run) if better else math.nan})
    return [*rows, {"muscle": budget.muscle, "scene": budget.scene, "source": "rounding", "setting": "3 starts", **budget.floor}]


def _setting_rows(budget: Budget) -> list[dict[str, object]]:
    names = _names(budget)
    return [{"muscle": budget.muscle, "scene": budget.scene, "source": names[source.name], "setting": one.words, "status": one.run.status,
             "frame_ms": frame_ms(one.run), "times": frame_ms(one.run) / frame_ms(source.own.run),
             **(differences(one.run, source.finest) if one.run is not source.finest else {})}
            for source in budget.sources for one in source.settings]
