#!/usr/bin/python3
"""Draws the pictures in space of an experiment's runs. A process of its own, because VTK needs a display."""

import sys
from pathlib import Path

from musclebench.accuracy.bone_pressure_figure import draw_bone_pressures
from musclebench.anatomy.import_pictures import draw_import
from musclebench.figures import looks
from musclebench.pictures.fibre_figure import draw_fibres, name_of
from musclebench.pictures.surface_figures import draw_surface_figures
from musclebench.population.pictures import draw_broken
from musclebench.program.cli import Problem
from musclebench.program.registry import saved_registry
from musclebench.results import run_folder

KINDS = {
    "surfaces": lambda runs, folder, say: draw_surface_figures(runs, folder, say),
    "fibres": lambda runs, folder, say: draw_fibres({name_of(run): run for run in runs}, folder / "fibres", say),
}
IMPORT = "import"  # no runs: a folder of tools/import
BONE_PRESSURE = "bone_pressure"  # no runs: a folder of tools/accuracy
POPULATION = "population"  # runs that did not hold


def draw(kind: str, out_dir: Path, names: list[str], say) -> list[Path]:
    if kind == IMPORT:
        return draw_import(out_dir, say)
    if kind == BONE_PRESSURE:
        return draw_bone_pressures(out_dir, say)
    if kind == POPULATION:
        return draw_broken(run_folder.read_all([out_dir / "raw" / name for name in names]), out_dir, say)
    looks.know(saved_registry(out_dir))
    return KINDS[kind](run_folder.read_all([out_dir / "raw" / name for name in names]), out_dir / "figures", say)


def main(arguments: list[str]) -> int:
    """Arguments: what is drawn, the experiment's folder, the names of its runs. Prints `drawing WHAT` and `file PATH`
    lines."""
    kind, out_dir, names = arguments[0], Path(arguments[1]), arguments[2:]
    try:
        files = draw(kind, out_dir, names, lambda text: print(f"drawing {text}", flush=True))
    except (Problem, run_folder.ResultProblem, OSError) as problem:
        print(f"draw_pictures: {problem}", file=sys.stderr)
        return 2
    for path in files:
        print(f"file {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
