"""Moment arms of hip muscles in flexion, beside published ones.

Turns each muscle's joint from rest to both ends of its range (-10 and 90 degrees) with the `standard` preset and the effects
that the scene calls for, in exact contact, follows 100 fibres through the muscle, and writes their moment arms dL/d(angle)
with their band over the fibres, of the muscle as it is and of the activated one, both laid to rest before the joint turns
(bench/experiments/moment_arms.toml). With --data they stand beside those of the same hip (Modenese and Kohout 2020), of finite
elements (Blemker and Delp 2005) and measurements; of the synthetic hip nothing is published.

A study goes on where it was stopped: complete runs are skipped until their arguments, the program or the data change.
"""

from dataclasses import replace
from pathlib import Path

from ..experiments.experiment_file import ExperimentFile, of_project, read_experiment
from ..program.cli import Problem, add_scene_options
from .shared import Tool, add_jobs_option, add_page_option, add_run_options, check_options, study_parser

EXPERIMENT = "moment_arms"
PASSIVE, ACTIVE = "passive_", "active_"  # how names of [[cases]] begin


def parse_arguments(arguments):
    parser = study_parser("moment-arms", __doc__)
    add_scene_options(parser, "default: all of the data set that have one muscle, and those with muscles that no such scene has")
    parser.add_argument("--passive-only", action="store_true", help="run no active muscle")
    parser.add_argument("--backend", metavar="NAME", help="of all runs (default: an exact one)")
    parser.add_argument("--experiment", type=Path, metavar="FILE",
                        help=f"of other angles, fibres, activation: a copy of bench/experiments/{EXPERIMENT}.toml whose [[cases]] "
                             f"begin with {PASSIVE} and {ACTIVE}")
    add_run_options(parser, timeout=None, is_timed=False)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


def asked_experiment(options) -> ExperimentFile:
    file = read_experiment(options.experiment) if options.experiment else of_project(EXPERIMENT)
    for group in file.groups:
        if group.mode != "run" or not group.name.startswith((PASSIVE, ACTIVE)):
            raise Problem(f"{file.path}: [[cases]] '{group.name}': moment arms are of mode run, and names begin with {PASSIVE} or "
                          f"{ACTIVE}; rename it, or leave it out")
        if "--fibres" not in group.options:
            raise Problem(f"{file.path}: [[cases]] '{group.name}': follows no fibres; put \"--fibres\", \"100\" into its options")
    groups = tuple(group for group in file.groups if not options.passive_only or group.name.startswith(PASSIVE))
    if not any(group.name.startswith(PASSIVE) for group in groups):
        raise Problem(f"{file.path}: none of its [[cases]] begins with {PASSIVE}; active muscles are compared with those")
    return replace(file, groups=groups)


def check(options) -> None:
    check_options(options)
    asked_experiment(options)


TOOL = Tool(parse_arguments, check)
