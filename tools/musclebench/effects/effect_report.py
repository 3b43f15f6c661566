"""Tables and figures of the study of effects."""

from collections.abc import Mapping
from pathlib import Path

from ..experiments.caveats import caveats
from ..experiments.swept_case import SweptCase
from ..figures.effect_figures import draw_changes, draw_costs
from ..figures.effect_scenes import draw_scenes
from ..program.optional_packages import left_out_without
from ..results.run_folder import read_all
from ..results.status import MEASURED
from ..tables.table_formats import Table, write_table
from .effect_runs import MeasuredSet
from .effect_tables import change_table, cost_table, price_table
from .guards import guard_table
from .returns import return_table


def measured_sets(folders: dict[SweptCase, Path]) -> list[MeasuredSet]:
    """One a scene and set, in the order of the plan."""
    runs = dict(zip(folders, read_all(list(folders.values()))))
    groups: dict[tuple, list] = {}
    for case, run in runs.items():
        groups.setdefault((case.scene.name, case.at("effects").meaning), []).append(run)
    return [MeasuredSet(scene, group[0].muscle, chosen, group) for (scene, chosen), group in groups.items()]


def write_report(folders: dict[SweptCase, Path], returned: dict[SweptCase, Path], guarded: dict[SweptCase, Path],
                 shown: dict[SweptCase, Path], colours: Mapping[str, str], out_dir: Path) -> tuple[list[Table], list[Path]]:
    """All of them: of the complete cases. `colours`: by effect."""
    measured = measured_sets(folders)
    tables = [cost_table(measured), change_table(measured), price_table(measured), return_table(returned),
              guard_table(guarded)]
    tables = [table.with_sentence(caveats(out_dir)) for table in tables]
    for name in ("tables", "figures"):
        (out_dir / name).mkdir(parents=True, exist_ok=True)
    files = [path for table in tables for path in write_table(table, out_dir / "tables")]
    scenes = [run for run in read_all(list(shown.values())) if run.status in MEASURED]
    with left_out_without("the figures"):
        files += draw_costs(measured, out_dir / "figures" / "effect_costs", colours)
        files += draw_changes(measured, out_dir / "figures" / "effect_changes")
        files += draw_scenes(scenes, out_dir / "figures" / "effect_scenes")
    return tables, files
