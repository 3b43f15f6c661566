"""Makes many patients out of one scene, runs each with each setting, and says which setting holds for enough of them.

A member of the population is the scene with other shapes. Each --shape says in which way members differ, and how far at most:

  size=10                  everything up to 10 % larger or smaller
  scale=15                 the same along x, y and z of the scene, each for itself
  bend=10                  the long axis becomes an arc of up to 10 degrees, towards any side
  twist=10                 up to 10 degrees about the long axis, from one end to the other
  scale=5@femur            one bone alone; so do size, bend and twist. Muscles are carried along
  modes=2@femur:FOLDER     one bone, by the modes of the meshes in FOLDER, up to 2 standard deviations. Meshes correspond vertex by vertex

Axes of joints are fitted anew where the bones' surfaces tell them. Attachments, fibres and retinacula go along. Member 0 is the
scene as it is, and does not count. A member stays the same however many there are: it depends on scene, shapes, --seed and its number.

A member holds if its run ends `ok`, by the limits of `musclebench list` and by what the scene or --wanted wants.

  tools/population ankle/soleus --shape scale=15 --shape bend=8
  tools/population lhdl/hip --data DIR --shape scale=15 --setting sdf:cells=32 --setting sdf:cells=64 --wanted surface_mm=1

Written into --out:
  settings.csv     a row a setting: how many members hold, with 95 % interval, and the time of a frame
  members.csv      a row a member: its shape, its bound nodes over those of the scene, and how it ended with each setting
  broken.csv       a row a run that did not hold: why, its picture, and the command that runs it again
  members/         scene and meshes of each member
  broken/          pictures. The first 12 runs that did not hold are run again for them (--no-pictures)

If the scene gives a bone or a pair a `backend`, no setting changes it. A scene whose effects are "auto" is refused: name its effects first.
You can stop the study and start it again. It skips complete runs. tools/experiment --merge joins the parts of --shard; --report-only
with the same options then writes their tables.
Exit codes: 0 a setting holds for enough members; 1 none does, or a run has no result; 2 bad input.
"""

import argparse
from pathlib import Path

from ..population.shape_words import MOST_MEMBERS, read_shape
from ..program.cli import Problem
from .shared import (
    Tool, add_frames_option, add_jobs_option, add_memory_option, add_run_options, add_shard_option, check_options, check_scene, needs_with_module,
    study_parser,
)


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = study_parser("population", __doc__)
    parser.add_argument("scene", metavar="SCENE", help="a scene that `musclebench list` prints, or a .toml file")
    what = parser.add_argument_group("who the members are")
    what.add_argument("--shape", action="append", metavar="KIND=AMOUNT", help="in which way members differ; may be repeated (default: none)")
    what.add_argument("--members", type=int, default=100, metavar="N", help="how many there are (default: 100)")
    what.add_argument("--seed", type=int, default=1, metavar="N", help="of what they draw (default: 1)")
    what.add_argument("--only", type=int, action="append", metavar="N",
                      help="this member alone, 0 or more; says how it ended, and leaves the tables; may be repeated (default: all)")
    what.add_argument("--make-only", action="store_true", help="write the members' scenes and meshes, and run nothing")
    what.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder, for lhdl/* scenes")
    tried = parser.add_argument_group("what they are run with")
    tried.add_argument("--setting", action="append", metavar="BACKEND[:key=value,...]",
                       help="a backend with its parameters; may be repeated (default: every fast backend with its defaults)")
    tried.add_argument("--effect", action="append", metavar="NAME[:key=value,...]", help="add an effect, as `musclebench run` does; may be repeated")
    tried.add_argument("--loop", action="append", metavar="key=value", help="loop parameter, as of `musclebench run`; may be repeated")
    tried.add_argument("--wanted", action="append", metavar="key=value", help="what members want, such as surface_mm=0.1; may be repeated "
                       "(default: what the scene wants)")
    tried.add_argument("--hold", type=float, default=95, metavar="PERCENT", help="of the members, for which a setting has to hold (default: 95)")
    add_frames_option(tried)
    add_shard_option(tried)
    how = parser.add_argument_group("how it runs")
    add_run_options(how, timeout=None)
    add_jobs_option(how)
    add_memory_option(how)
    how.add_argument("--no-pictures", action="store_true", help="draw no pictures of what did not hold")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", action="store_true", help="print the runs with their estimated times, and which are complete")
    instead.add_argument("--report-only", action="store_true", help="write the tables of the results that exist, run nothing")
    return parser.parse_args(arguments)


def check(options: argparse.Namespace) -> None:
    seed, options.seed = options.seed, options.seed or 1  # 0 is one, too
    check_options(options)
    options.seed = seed
    check_scene(options.scene)
    if not options.shape:
        raise Problem("--shape is missing; without it all members are alike: give one such as --shape scale=15")
    options.shape = [read_shape(text) if isinstance(text, str) else text for text in options.shape]
    if options.members > MOST_MEMBERS:
        raise Problem(f"--members {options.members}: at most {MOST_MEMBERS}")
    if options.hold > 100:
        raise Problem(f"--hold {options.hold:g}: at most 100 percent")
    for number in options.only or []:
        if not 0 <= number <= options.members:
            raise Problem(f"--only {number}: there are members 0 to {options.members}; raise --members")


TOOL = Tool(parse_arguments, check, needs_with_module)
