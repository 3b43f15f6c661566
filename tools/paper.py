#!/usr/bin/python3
"""Runs the paper's experiment; writes tables, figures and page. Options: musclebench/options/paper.py."""

import sys
from pathlib import Path

from musclebench.cases.study_command import end, folders_of
from musclebench.experiments.caveats import caveats
from musclebench.experiments.experiment_file import ExperimentFile, of_project
from musclebench.experiments.running import limits_of, sweep_of
from musclebench.figures import looks, paper_figures
from musclebench.options.paper import parse_arguments
from musclebench.options.shared import check_options
from musclebench.page.of_study import page_of
from musclebench.paper import published
from musclebench.paper.paper_backends import name_of, starts_off_by_rounding
from musclebench.pictures.in_display import draw_in_display
from musclebench.program.cli import Problem, run_command
from musclebench.program.optional_packages import left_out_without
from musclebench.program.registry import Registry, read_registry, whose
from musclebench.results import run_folder
from musclebench.results.disturbance import note
from musclebench.tables import muscle_tables, paper_tables, smoothness_table, table_formats
from musclebench.results.status import MEASURED


def write_report(out_dir: Path, names: list[str]) -> tuple[list[run_folder.Run], list[paper_tables.Table], list[Path]]:
    """Tables and figures drawn from numbers."""
    runs = run_folder.read_all([out_dir / "raw" / name for name in names])
    paper = published.read_published()
    for folder in ("tables", "figures"):
        (out_dir / folder).mkdir(exist_ok=True)
    runs_file = out_dir / "runs.csv"
    rows = run_folder.runs_table(runs)
    told = [f"{name_of(run)}, start off by rounding" if starts_off_by_rounding(run) else name_of(run) for run in runs]
    rows.insert(rows.columns.get_loc("backend") + 1, "configuration", told)
    rows.to_csv(runs_file, index=False)
    made = [paper_tables.memory_table(runs, paper), paper_tables.time_table(runs, paper)]
    smoothness = smoothness_table.smoothness_table(runs)
    if smoothness is not None:
        made.append(smoothness)
    several = muscle_tables.of_several_muscles(runs)
    if several:
        made += [muscle_tables.frame_time_table(several), muscle_tables.depth_table(several), muscle_tables.pair_table(several)]
    made = [table.with_sentence(whose(run_folder.implementations(runs))).with_sentence(caveats(out_dir)) for table in made]
    files = [runs_file]
    for table in made:
        files += table_formats.write_table(table, out_dir / "tables")
    with left_out_without("the figures"):
        files += paper_figures.draw_figures(runs, paper, out_dir / "figures")
    return runs, made, files


def print_report(runs: list[run_folder.Run], made: list[paper_tables.Table]) -> None:
    for table in made:
        print(f"\n{table.caption}\n\n{table_formats.as_text(table)}")
    busy = note(paper_tables.disturbed_runs(runs), len(runs))
    print(f"\n{busy}" if busy else "")
    print(paper_figures.caption(runs))


def left_out_of(file: ExperimentFile, registry: Registry) -> str:
    """What the experiment lists and this program lacks, as a line; empty for nothing."""
    missing = dict.fromkeys(name for group in file.groups if group.if_built for name in group.backends if not registry.has(name))
    return f"Left out, as this program lacks them: {', '.join(missing)}; tools/setup --all installs the libraries" if missing else ""


def run_and_report(options) -> int:
    check_options(options, "paper")
    folders = folders_of(options, "paper")
    out_dir = folders.out_dir
    registry = read_registry(options.musclebench)
    looks.know(registry)
    sweep = sweep_of(of_project("paper"), options, registry, folders)
    sweep.run(sweep.cases, limits_of(options))
    names = [case.name for case in sweep.of("paper")]
    runs, made, files = write_report(out_dir, [case.name for case in sweep.of("paper", "advised", "exact", "floor")])
    problems = [f"{run.scene} with {run.backend}: {run.status}, {run.record.get('status_detail')}"
                for run in runs if run.status not in MEASURED]
    is_drawn = True
    try:
        with left_out_without("the pictures in space"):
            files += draw_in_display("surfaces", out_dir, names)
    except Problem as problem:
        is_drawn = False
        problems.append(str(problem))
    print_report(runs, made)
    if left_out := left_out_of(sweep.file, registry):
        print(left_out)
    files += page_of("paper", out_dir, options)
    return end("paper", files, problems, out_dir if is_drawn else None)


def main(arguments=None) -> int:
    return run_command("paper", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", run_folder.ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
