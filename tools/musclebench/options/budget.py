"""Says where the error of a run comes from, and what halving it costs.

The tool runs a scene with its own settings and the exact backend. Then it refines one source of error at a time. The time step
gets smaller, by more substeps in a frame of the same time. There are more iterations. The mesh of the muscle has four triangles
for one, those of the bones four and sixteen. Other backends find the collisions, with their defaults. Starts that are off by
rounding give the floor. A table in --out has what each source moves: the shape, moment arm, volume, surface depth, joint torque
and peak pressure. Sentences for each scene (budget.txt) say which source is the largest, and which settings halve the errors that
were refined.

A finer muscle mesh wants smaller time steps, so it is run with the two smallest ones, and compared at the smallest. These two
runs take most of the time.
Scenes of the program run with the preset `standard`, scene files with their own.

  tools/budget --scene my_scene.toml
  tools/budget --muscle iliacus --backend sdf
  tools/budget --scene my_scene.toml --error-mm 1

You can stop the study and start it again. It skips complete cases. A case runs again if its arguments, the program or the
data changed.
"""

from ..experiments.experiment_file import ExperimentFile, of_project
from ..program.cli import add_scene_options
from .shared import EVERY_SCENE, Tool, add_frames_option, add_jobs_option, add_run_options, study_parser


def parse_arguments(arguments, file: ExperimentFile):
    parser = study_parser("budget", __doc__)
    add_scene_options(parser, EVERY_SCENE)
    finest = int(max((factor for group in file.groups for factor in group.times_substeps), default=1))
    parser.add_argument("--finest", type=int, default=finest, metavar="N",
                        help="most substeps and iterations, in multiples of the scene's own; the multiples double up to it. 8 or more "
                             f"show whether errors have an order (default: {finest})")
    parser.add_argument("--backend", action="append", metavar="NAME",
                        help="backend whose collision error is told; may be repeated (default: all fast ones)")
    parser.add_argument("--error-mm", type=float, metavar="E",
                        help="also choose: the fastest time step, iterations, backend and resolution whose shape at full flexion is at most "
                             "E mm (RMS) off: its distance to that of the finest time step, and what that one may itself be off by; "
                             "what is told was run (default: nothing is chosen)")
    add_frames_option(parser)
    add_run_options(parser, timeout=file.timeout_s)
    add_jobs_option(parser)
    return parser.parse_args(arguments)


TOOL = Tool(lambda arguments: parse_arguments(arguments, of_project("budget")))
