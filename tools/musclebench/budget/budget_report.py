"""The table of sources, the table of all their settings, the figure, and a sentence for each scene."""

import math
from pathlib import Path

import pandas as pd

from ..cases.scene import Scene
from ..experiments.caveats import caveats
from ..experiments.swept_case import SweptCase
from ..figures import looks
from ..figures.budget import draw_budget, draw_substeps
from ..program.fingerprint import write_whole
from ..program.optional_packages import left_out_without
from ..results.disturbance import disturbed, note
from ..results.run_folder import Run
from ..results.status import MEASURED
from ..tables.table_formats import Column, Table, write_table
from . import substeps_table
from .sources import Budget, Setting, Source, differences, frame_ms, in_words

ERRORS = [
    Column("shape_mm", "shape, RMS mm", 3, "shape\nmm"), Column("arm_mm", "moment arm, RMS mm", 3, "arm\nmm"),
    Column("volume_percent", "volume %", 3, "volume\n%"), Column("surface_mm", "surface depth mm", 3, "depth\nmm"),
    Column("torque_percent", "joint torque %", 2, "torque\n%"), Column("pressure_percent", "peak pressure %", 2, "pressure\n%"),
]
COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("source", "source"), Column("setting", "setting"), Column("status", "status"),
    Column("reference", "compared with", head="compared\nwith"), *ERRORS, Column("order", "order", 2),
    Column("left_mm", "reference off by mm", 3, "left\nmm"), Column("halved_by", "halved by", head="halved\nby"),
    Column("price", "for x time", is_ratio=True, digits=2),
]
SETTING_COLUMNS = [
    Column("muscle", "muscle"), Column("scene", "scene"), Column("source", "source"), Column("setting", "setting"),
    Column("status", "status"), Column("frame_ms", "ms a frame", 3), Column("times", "x time of the exact run", is_ratio=True, digits=2), *ERRORS,
]
CAPTION = (
    "What each source of error moves, the others as they are: the run of the scene's own setting beside the finest setting of that "
    "source, or beside the exact backend. Shape at full flexion, over the nodes; moment arm over the motion; largest difference of "
    "the volume, of its volume at rest; difference of the largest depth of the surface; joint torque and peak pressure in percent of "
    "the other run's. Rounding: the largest difference of starts that are off by 1 to 3e-12 m; a source below it tells nothing. Order "
    "p: the shape's error falls as 1 / refinement^p; empty where the last steps don't agree on one. Reference off by: how far the "
    "finest shape is itself from the limit, by Richardson's rule where there is an order, else its last step (more where steps shrink "
    "slowly); of the finer muscle mesh, what its last doubling of the substeps moved beside. Halved by: the first finer setting with at "
    "most half of the shape's error; empty where refining has not settled. Times are medians over the frames of "
    "one run each, with forces told. Settling before the motion keeps its number of substeps."
)
WITHOUT = "no collision at all"
SETTINGS_CAPTION = "The runs of the budget: what each setting moves, from the finest of its source or from the exact run, and its time."


def budgets_of(runs: dict[SweptCase, Run]) -> dict[Scene, Budget | str]:
    """Of each scene; a sentence that says why where there is none. `runs`: of bench/experiments/budget.toml."""
    return {scene: budget_of({case: run for case, run in runs.items() if case.scene == scene})
            for scene in dict.fromkeys(case.scene for case in runs)}


def write_report(runs: dict[SweptCase, Run], found: dict[Scene, Budget | str], chosen: list[str], out_dir: Path) -> tuple[Table, list[str], list[Path]]:
    """`chosen`: sentences about what holds a bound. Beside the table a sentence a scene, and those."""
    budgets = [one for one in found.values() if not isinstance(one, str)]
    sentences = [one if isinstance(one, str) else in_words(one) for one in found.values()] + chosen
    table = _table("budget", CAPTION, COLUMNS, [row for budget in budgets for row in _rows(budget)])
    settings = _table("settings", SETTINGS_CAPTION, SETTING_COLUMNS, [row for budget in budgets for row in _setting_rows(budget)])
    substeps = substeps_table.table([run for case, run in sorted(runs.items(), key=lambda one: _count(one[0], "substeps"))
                                     if case.group.name == "time_step"])
    for folder in (out_dir / "tables", out_dir / "figures"):
        folder.mkdir(parents=True, exist_ok=True)
    busy = note(disturbed({run.folder.name: run.record for run in runs.values()}), len(runs))
    said = " ".join(filter(None, [caveats(out_dir), busy]))
    files = [path for one in (table, settings, substeps) for path in write_table(one.with_sentence(said), out_dir / "tables")]
    files.append(out_dir / "tables" / "budget.txt")
    write_whole(files[-1], "\n".join(sentences) + "\n")
    with left_out_without("the figures"):
        files += draw_budget(table.rows, out_dir / "figures" / "budget") + draw_substeps(substeps.rows, out_dir / "figures" / "substeps")
    return table.with_sentence(said), sentences, files


def _table(name: str, caption: str, columns: list[Column], rows: list[dict[str, object]]) -> Table:
    keys = [column.key for column in columns]
    return Table(name, caption, columns, pd.DataFrame(rows, columns=keys), [key for key in keys if key != "muscle"])


def budget_of(runs: dict[SweptCase, Run]) -> Budget | str:
    """Of one scene; a sentence that says why where there is none."""
    scene = next(iter(runs)).scene
    own = _by_count("time_step", "substeps", runs).get(scene.substeps)
    if own is None:
        return f"{scene.key}: no budget: the exact run of the scene's own setting is missing."
    if own.status not in MEASURED:
        return f"{own.scene}: no budget: the exact run of the scene's own setting ended with the status {own.status}."
    refined = {
        "time step": _refined("time step", _by_count("time_step", "substeps", runs), scene.substeps, own, "substep"),
        "iterations": _refined("iterations", _by_count("iterations", "iterations", runs), scene.iterations // scene.substeps, own, "iteration"),
        "muscle mesh": _of_muscle_mesh(runs), "bone mesh": _of_bone_mesh(runs, own)}
    sources = [source for source in refined.values() if source]
    exact = Setting(looks.title_and_name(own.backend), 1.0, own)
    for case, run in runs.items():
        if case.group.name == "collision" and run.backend != own.backend and not looks.backend(run.backend).is_control:
            plain = case.configuration.label == run.backend
            setting = Setting(looks.title_and_name(run.backend) if plain else case.configuration.label.replace("-", " ", 1), 1.0, run)
            sources.append(Source(f"collision, {setting.words}", [setting], setting, exact))
    starts = [differences(run, own) for case, run in runs.items() if case.group.name == "rounding" and run.status in MEASURED]
    ran = {case.group.name.replace("_", " ") for case in runs}
    missing = tuple(f"{name}: no finer run ended well" for name, source in refined.items() if name in ran and source is None)
    without = next((run for case, run in runs.items() if case.group.name == "collision" and looks.backend(run.backend).is_control
                    and run.status in MEASURED), None)
    return Budget(own.scene, own.muscle, own, sources, starts, without, missing)


def _refined(name: str, counts: dict[int, Run], own: int, exact: Run, unit: str) -> Source | None:
    counts = counts | {own: exact}
    return _usable(name, [Setting(f"{count} {unit}{'s' if count > 1 else ''}", count / own, counts[count]) for count in sorted(counts)], exact)


def _of_bone_mesh(runs: dict[SweptCase, Run], exact: Run) -> Source | None:
    """Each refinement halves the edges."""
    splits = _by_count("bone_mesh", "smooth_bones", runs)
    finer = [Setting(f"{4**times} times the triangles", 2.0**times, splits[times]) for times in sorted(splits)]
    return _usable("bone mesh", [Setting("its own triangles", 1.0, exact), *finer], exact)


def _of_muscle_mesh(runs: dict[SweptCase, Run]) -> Source | None:
    """Beside the scene's own mesh at the same time step: the finest at which both were run, and with half as many substeps. None
    where one of these did not end well."""
    coarse, fine = _by_count("time_step", "substeps", runs), _by_count("muscle_mesh", "substeps", runs)
    both = sorted(count for count, run in fine.items() if count in coarse and run.status in MEASURED and coarse[count].status in MEASURED)
    if len(both) < 2:
        return None
    own = Setting(f"its own triangles, {both[-1]} substeps", 1.0, coarse[both[-1]])
    finer = Setting(f"4 times the triangles, {both[-1]} substeps", 2.0, fine[both[-1]])
    return Source("muscle mesh", [own, finer], own, finer, nearly=fine[both[-2]])


def _usable(name: str, settings: list[Setting], exact: Run) -> Source | None:
    """None where nothing finer ended well."""
    usable = [one for one in settings if one.is_usable]
    mine = next(one for one in usable if one.run is exact)
    return Source(name, usable, mine, usable[-1]) if usable[-1].factor > 1 else None


def _by_count(group: str, axis: str, runs: dict[SweptCase, Run]) -> dict[int, Run]:
    return {_count(case, axis): run for case, run in runs.items() if case.group.name == group}


def _count(case: SweptCase, axis: str) -> int:
    return next((int(one.value) for one in case.point if one.axis == axis), 0)


def _rows(budget: Budget) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for source in budget.sources:
        better = source.halving(budget.floor.get("shape_mm", 0.0))
        rows.append({"muscle": budget.muscle, "scene": budget.scene, "source": source.name, "setting": source.own.words,
                     "status": source.own.run.status, "reference": _reference_words(source), **source.errors(), "order": source.order(),
                     "left_mm": source.left_mm() if source.is_refined else math.nan, "halved_by": better.words if better else "",
                     "price": budget.times(better.run) / budget.times(source.own.run) if better else math.nan})
    starts = len(budget.floors)
    if budget.without is not None:
        rows.append({"muscle": budget.muscle, "scene": budget.scene, "source": WITHOUT, "setting": budget.without.backend,
                     "status": budget.without.status, "reference": looks.title_and_name(budget.own.backend), **differences(budget.without, budget.own)})
    return [*rows, {"muscle": budget.muscle, "scene": budget.scene, "source": "rounding", "setting": f"{starts} starts", **budget.floor}]


def _reference_words(source: Source) -> str:
    """With its status where that is another."""
    status = source.reference.run.status
    return source.reference.words + (f" ({status})" if status != source.own.run.status and source.is_refined else "")


def _setting_rows(budget: Budget) -> list[dict[str, object]]:
    return [{"muscle": budget.muscle, "scene": budget.scene, "source": source.name, "setting": one.words, "status": one.run.status,
             "frame_ms": frame_ms(one.run), "times": budget.times(one.run),
             **(differences(one.run, source.reference.run) if one.is_usable and one is not source.reference else {})}
            for source in budget.sources for one in source.settings]
