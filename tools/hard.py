#!/usr/bin/python3
"""Runs the matrix of hard cases, writes and draws it. Options: musclebench/options/hard.py."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd

from musclebench.cases.case import Folders
from musclebench.cases.study_command import PROJECT, end
from musclebench.experiments.caveats import caveats
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.running import Sweep, limits_of, sweep_of
from musclebench.experiments.selection import check_backend
from musclebench.figures import looks
from musclebench.figures.hard_cases import draw_counts, draw_matrix, draw_strips
from musclebench.hard import hard_tables
from musclebench.hard.cell_folder import BROKEN, HELD, joined
from musclebench.hard.cells import cases_of, cells_of
from musclebench.hard.strips import run_scene
from musclebench.options.hard import parse_arguments
from musclebench.options.shared import check_options
from musclebench.page.of_study import page_of
from musclebench.program.cli import Problem, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.program.optional_packages import left_out_without
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem, Run

OUT = PROJECT / "reports" / "out" / "hard"
ALL_SECONDS = 4000.0  # of a cell of the long sweeps, a little over the program's own


def asked(file: ExperimentFile, options, registry: Registry) -> ExperimentFile:
    """The experiment as the options want it."""
    group = replace(file.groups[0], hard_cases=tuple(options.case or ()), options=("--all",) if options.all else ())
    if options.backend:
        group = replace(group, backends=tuple(check_backend(name, registry) for name in options.backend))
    return replace(file, groups=(group,))


def write_tables(sweep: Sweep, options, out_dir: Path) -> tuple[pd.DataFrame, pd.DataFrame, list[Path]]:
    """The rows, a figure each; the cells; the files, of which tools/publish takes over a row a cell and a row a case."""
    words = [word for case in options.case or [] for word in ("--case", case)]
    listed = subprocess.run([str(options.musclebench), "hard", "--list", *words], capture_output=True, text=True, check=False)
    cases, done = cases_of(listed.stdout), sweep.done("hard")
    order = list(cases["case"])  # cases down, backends across
    folders = [done[case] for case in sorted(done, key=lambda case: order.index(case.at("case").value))]
    write_whole(out_dir / "matrix.csv", joined(folders))
    rows = pd.read_csv(out_dir / "matrix.csv", keep_default_na=False)
    cells = cells_of(rows)
    files = [out_dir / "matrix.csv", out_dir / "matrix.md"]
    page = [f"# {sweep.file.title}", *filter(None, [caveats(out_dir)]),
            *(made(cells) for made in (hard_tables.matrix, hard_tables.beyond, hard_tables.unasked)),
            hard_tables.texts(cases)]
    write_whole(files[1], "\n\n".join(page) + "\n")
    for name, table in (("cells", cells), ("cases", cases)):
        files.append(out_dir / "tables" / f"{name}.csv")
        table.to_csv(files[-1], index=False)
    return rows, cells, files


def strips(rows: pd.DataFrame, options, registry: Registry, folder: Path) -> tuple[list[Run], list[str]]:
    """A run of each scene that the cases move; a line for each that can't be."""
    runs, problems = [], []
    for scene in dict.fromkeys(name for name in rows["scene"] if name):
        try:
            runs.append(run_scene(options.musclebench, scene, registry, folder / Path(scene).name))
        except Problem as problem:
            problems.append(str(problem))
    return runs, problems


def run_and_report(arguments) -> int:
    file = of_project("hard")
    options = parse_arguments(arguments, file)
    check_options(options, "hard")
    if options.all:
        options.timeout = max(options.timeout, ALL_SECONDS)
    registry = read_registry(options.musclebench)
    folders = Folders((options.out or OUT).absolute())
    looks.know(registry)
    sweep = sweep_of(asked(file, options, registry), options, registry, folders)
    problems = sweep.run(sweep.cases, limits_of(options))
    if not sweep.done("hard"):
        return end("hard", [], problems)
    for name in ("tables", "figures", "raw/scenes"):
        (folders.out_dir / name).mkdir(exist_ok=True)
    rows, cells, files = write_tables(sweep, options, folders.out_dir)
    print("\n" + "\n\n".join(filter(None, [hard_tables.as_text(cells), caveats(folders.out_dir)])))
    with left_out_without("the matrix as a picture and the strips of scenes"):
        files += draw_counts(rows, folders.out_dir / "figures" / "counts")
        files += draw_matrix(rows, folders.out_dir / "figures" / "matrix")
        if not options.no_pictures:
            runs, more = strips(rows, options, registry, folders.out_dir / "raw" / "scenes")
            problems += more
            files += draw_strips(runs, folders.out_dir / "figures" / "scenes")
    files += page_of("hard", folders.out_dir, options)
    code = BROKEN if (rows["verdict"] == "breaks").any() and not options.breaks_are_results else HELD
    return max(code, end("hard", files, problems, folders.out_dir))


def main(arguments=None) -> int:
    return run_command("hard", lambda: run_and_report(arguments), "complete cells are kept, unfinished ones removed",
                       ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
