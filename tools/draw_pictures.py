#!/usr/bin/python3
"""Draws the surface figures of an experiment's runs. A process of its own, because VTK needs a display."""

import sys
from pathlib import Path

from musclebench.figures import looks
from musclebench.pictures import surface_figures
from musclebench.program.cli import Problem
from musclebench.program.registry import saved_registry
from musclebench.results import run_folder


def main(arguments: list[str]) -> int:
    """Arguments: the experiment's folder and the names of its runs. Prints `drawing WHAT` and `file PATH` lines."""
    out_dir, names = Path(arguments[0]), arguments[1:]
    try:
        looks.know(saved_registry(out_dir))
        runs = run_folder.read_all([out_dir / "raw" / name for name in names])
        files = surface_figures.draw_surface_figures(
            runs, out_dir / "figures", lambda text: print(f"drawing {text}", flush=True)
        )
    except (Problem, run_folder.ResultProblem, OSError) as problem:
        print(f"draw_surfaces: {problem}", file=sys.stderr)
        return 2
    for path in files:
        print(f"file {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
