"""Measures moment arms of hip muscles in flexion and compares them with published moment arms.

The tool turns the joint of each muscle over its range, from -10 to 90 degrees. It uses the `standard` preset, the effects that
`musclebench check` recommends, and exact contact. It follows 100 fibres through each muscle, passive and active: active fibres
pull with a twentieth of their peak stress (`fibre_force`). The moment arm is dL/d(angle), the change of a fibre's length with
the angle. Of active muscles the table also has the joint's torque over the force of the fibres. Tables in --out give the mean
and the band over the fibres. bench/experiments/moment_arms.toml holds the settings.

With --data the tables also show published values of the same hip (Modenese and Kohout 2020), of finite elements (Blemker
and Delp 2005), and measurements. Nothing is published for the synthetic hip.

  tools/moment-arms --data lhdl --muscle iliacus

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

from dataclasses import replace
from pathlib import Path

from ..experiments.experiment_file import ExperimentFile, of_project, read_experiment
from ..program.cli import Problem, add_scene_options
from .shared import EVERY_SCENE, Tool, add_jobs_option, add_page_option, add_run_options, check_options, study_parser

EXPERIMENT = "moment_arms"
PASSIVE, ACTIVE = "passive_", "active_"  # how names of [[cases]] begin


def parse_arguments(arguments):
    parser = study_parser("moment-arms", __doc__)
    add_scene_options(parser, f"{EVERY_SCENE}, and scenes with muscles that no such scene has")
    parser.add_argument("--passive-only", action="store_true", help="run only passive muscles")
    parser.add_argument("--backend", metavar="NAME", help="backend of all runs (default: an exact backend)")
    parser.add_argument("--experiment", type=Path, metavar="FILE",
                        help=f"settings with other angles, fibres or activation: a changed copy of bench/experiments/{EXPERIMENT}.toml, whose "
                             f"[[cases]] have names that begin with {PASSIVE} or {ACTIVE} (default: {EXPERIMENT}.toml)")
    add_run_options(parser, timeout=None, is_timed=False)
    add_jobs_option(parser)
    add_page_option(parser)
    return parser.parse_args(arguments)


def asked_experiment(options) -> ExperimentFile:
    file = read_experiment(options.experiment) if options.experiment else of_project(EXPERIMENT)
    for group in file.groups:
        if group.mode != "run" or not group.name.startswith((PASSIVE, ACTIVE)):
            raise Problem(f"{file.path}: [[cases]] '{group.name}': needs mode run, and names begin with {PASSIVE} or "
                          f"{ACTIVE}; rename it, or leave it out")
        if "--fibres" not in group.options:
            raise Problem(f"{file.path}: [[cases]] '{group.name}': follows no fibres; put \"--fibres\", \"100\" into its options")
    groups = tuple(group for group in file.groups if not options.passive_only or group.name.startswith(PASSIVE))
    if not any(group.name.startswith(PASSIVE) for group in groups):
        raise Problem(f"{file.path}: none of its [[cases]] begins with {PASSIVE}; add one: active muscles are compared with passive muscles")
    return replace(file, groups=groups)


def check(options) -> None:
    check_options(options)
    asked_experiment(options)


TOOL = Tool(parse_arguments, check)
