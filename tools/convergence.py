#!/usr/bin/python3
"""How many substeps a muscle needs: the shape at full flexion against the number of substeps a frame.

Runs scenes with the `standard` preset for 5, 10, 20, ... substeps (the time of a frame stays the same), takes the run
with the most substeps as the reference, and writes the distance of each shape to it as a table.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

import argparse
import sys
from pathlib import Path

from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits, run_cases
from musclebench.cases.scene import chosen_names, survey
from musclebench.convergence.convergence_cases import PRESET, ConvergenceCase, plan, usual_backend
from musclebench.convergence.convergence_report import write_report
from musclebench.program.cli import (
    OneLineParser, Problem, add_scene_options, check_data, check_positive, check_program, chosen_cores, data_set_of,
    out_name_of, run_command,
)
from musclebench.program.out_folder import claimed
from musclebench.program.registry import Registry, read_registry
from musclebench.results.run_folder import ResultProblem
from musclebench.tables.table_formats import as_markdown
from musclebench.results.status import MEASURED

PROJECT = Path(__file__).resolve().parent.parent
PROGRAM = PROJECT / "build" / "release" / "bench" / "musclebench"
SUBSTEPS = (5, 10, 20, 40, 80, 160)


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/convergence", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    add_scene_options(parser, "default: all of the data set that have one muscle")
    parser.add_argument("--substeps", type=_counts, default=list(SUBSTEPS), metavar="N,N,...",
                        help=f"numbers to compare (default: {','.join(map(str, SUBSTEPS))})")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--frames-limit", type=int, metavar="N", help="frames of the whole motion, for a quick look")
    parser.add_argument("--out", type=Path, metavar="DIR",
                        help="default: reports/out/convergence-synthetic, -lhdl or -SCENE")
    parser.add_argument("--jobs", type=int, metavar="N",
                        help="runs at a time, each on a core (default: 2, or 1 on one core)")
    parser.add_argument("--timeout", type=float, default=3600.0, metavar="SECONDS", help="of one run (default 3600)")
    parser.add_argument("--force", action="store_true", help="run complete cases again")
    parser.add_argument("--musclebench", type=Path, default=PROGRAM, metavar="PROGRAM",
                        help="the program to measure (default: that of the preset release)")
    return parser.parse_args(arguments)


def _counts(text: str) -> list[int]:
    words = text.split(",")
    if not all(word.isdecimal() and int(word) > 0 for word in words):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 5,10,20")
    return sorted({int(word) for word in words})


def check_input(options) -> None:
    check_program(options.musclebench, "tools/convergence")
    check_data(options.data)
    for option in ("jobs", "frames_limit", "timeout"):
        check_positive(f"--{option.replace('_', '-')}", getattr(options, option))


class ConvergenceStudy(Experiment):
    final_statuses = MEASURED | {"diverged"}  # with few substeps to diverge is an answer


def backend_of(options, registry: Registry) -> str:
    if options.backend and not registry.has(options.backend):
        raise Problem(f"--backend {options.backend}: not built; there are: {', '.join(registry.names)}")
    return options.backend or usual_backend(registry).name


def planned(options, registry: Registry, folders: Folders) -> list[ConvergenceCase]:
    names = chosen_names(options.scene, options.muscle, data_set_of(options), registry)
    scenes = survey(names, options.musclebench, registry, folders, options.frames_limit, PRESET)
    return plan(scenes, backend_of(options, registry), options.substeps)


def run_and_report(options) -> int:
    check_input(options)
    out_dir = (options.out or PROJECT / "reports" / "out" / f"convergence-{out_name_of(options)}").absolute()
    folders = Folders(out_dir, options.data and options.data.resolve())
    cases = planned(options, read_registry(options.musclebench), folders)
    study = ConvergenceStudy(options.musclebench, folders, options.force)
    todo = [case for case in cases if study.wants(case)]
    if len(todo) < len(cases):
        print(f"{len(cases) - len(todo)} of {len(cases)} runs are complete already (--force runs them again)")
    with claimed(out_dir, "raw"):
        statuses = run_cases(todo, study, Limits(chosen_cores(options.jobs), options.timeout))
    problems = [f"{case.name}: {status}, see {study.folder(case) / 'run.json'}" for case, status in statuses.items()
                if status not in study.final_statuses]
    table, files = write_report([study.folder(case) for case in cases if study.is_complete(case)], out_dir / "tables")
    print(as_markdown(table))
    print("Written:", *(f"  {path}" for path in files), sep="\n")
    for problem in problems:
        print(f"convergence: {problem}", file=sys.stderr)
    return 1 if problems else 0


def main(arguments=None) -> int:
    return run_command("convergence", lambda: run_and_report(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
