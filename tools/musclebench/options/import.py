"""Makes scenes of a folder of segmented meshes, such as bones and muscles of one patient.

A map says which file is which part, where the data come from, and which bones turn about which joint: datasets/maps has maps of
published data. Meshes may be STL, PLY, OBJ, VTP or VTK, in any unit. They keep their pose. Each is welded, cleaned, closed where a
hole is small, turned outward, and decimated to a wanted error. Muscles are attached where they touch bones. A tendon that the
meshes lack is drawn where the map says it runs. The axis of a joint is fitted to its cartilage, or given.

What can't be used is listed with the reason, and the rest goes on. --out then has scenes, meshes in metres, attachments as points,
pictures, and a README with licence, citations, errors and attachments.

  tools/import ~/Downloads/right --map datasets/maps/visible_human_female.toml --out leg
  build/release/bench/musclebench run leg/scenes/ankle/soleus.toml --backend bvh --out leg_runs/soleus

Exit codes: 0 all was imported; 2 nothing was written, and one line says what is wrong; 3 it is written, and something is not as
told: files that could not be used, a joint that drives bones into each other, or muscles that still overlap.
"""

import argparse
from pathlib import Path

from ..program.cli import OneLineParser, Problem, check_positive
from .shared import Tool, built_program, needs_with_module


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = OneLineParser(prog="tools/import", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="folder with the meshes; folders in it are searched, too")
    parser.add_argument("--map", type=Path, required=True, metavar="FILE", help="TOML file that says which file is which part")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to make")
    parser.add_argument("--unit", choices=("mm", "cm", "m"), help="unit of the meshes (default: the map's, else found by their size)")
    parser.add_argument("--error-mm", type=float, metavar="MM",
                        help="largest distance of a decimated mesh from the given one, mm (default: the map's, else 0.1 mm)")
    parser.add_argument("--near-mm", type=float, metavar="MM",
                        help="a muscle is attached where it is so near to a bone, mm (default: the map's, else 1.5 mm)")
    parser.add_argument("--side", metavar="NAME", help="side of the body, as the files write it (default: the map's, else the only one)")
    parser.add_argument("--muscle", action="append", default=[], metavar="NAME", help="import this muscle only; may be repeated (default: all)")
    parser.add_argument("--no-pictures", action="store_true", help="draw no pictures")
    parser.add_argument("--force", action="store_true", help="replace --out where an earlier import made it")
    parser.add_argument("--musclebench", type=Path, default=built_program("release"), metavar="PROGRAM",
                        help="program whose Python module tells distances (default: the build of preset release)")
    return parser.parse_args(arguments)


def check(options: argparse.Namespace) -> None:
    if not options.folder.is_dir():
        raise Problem(f"{options.folder}: no such folder; name the one with the meshes")
    if not options.map.is_file():
        raise Problem(f"--map {options.map}: no such file; datasets/maps has maps to begin with")
    check_positive("--error-mm", options.error_mm)
    check_positive("--near-mm", options.near_mm)


TOOL = Tool(parse_arguments, check, needs_with_module)
