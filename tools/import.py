#!/usr/bin/python3
"""Makes scenes of a folder of meshes. Options: musclebench/options/import.py."""

import importlib
import sys
from pathlib import Path

from musclebench.anatomy.anatomy_map import read_map
from musclebench.anatomy.found_files import find_files
from musclebench.anatomy.import_folder import MARK, write_import
from musclebench.anatomy.importing import import_anatomy
from musclebench.pictures.in_display import draw_in_display
from musclebench.program.cli import Problem, run_command
from musclebench.program.native_module import add_native_module
from musclebench.program.optional_packages import require
from musclebench.program.talker import Talker
from musclebench.program.whole_folder import whole_folder

TOOL = importlib.import_module("musclebench.options.import").TOOL  # its name is a word of Python's
CODE_PARTLY = 3


def draw(folder: Path, say: Talker) -> None:
    """An import without pictures is one, too."""
    say("drawing pictures")
    try:
        draw_in_display("import", folder, [])
    except (Problem, OSError) as problem:
        print(f"import: no pictures: {problem}", file=sys.stderr)


def tell(problems: list[str]) -> None:
    for problem in problems:
        print(f"not imported, or not as told: {problem}", file=sys.stderr)


def counted(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def make(options) -> int:
    TOOL.check(options)
    require("vtk")
    add_native_module(options.musclebench)
    anatomy = read_map(options.map)
    anatomy.unit = options.unit or anatomy.unit
    for joint in anatomy.joints:
        joint.opensim = joint.opensim and str(options.folder / joint.opensim)
    anatomy.side = options.side or anatomy.side
    anatomy.title = anatomy.title.replace("{side}", anatomy.side)
    anatomy.error_mm = options.error_mm or anatomy.error_mm
    anatomy.near_mm = options.near_mm or anatomy.near_mm
    out = options.out.resolve()
    for path, what in ((options.folder, "FOLDER"), (options.map, "--map")):
        if path.resolve().is_relative_to(out):
            raise Problem(f"--out {options.out}: {what} lies in it; name another folder")
    files, problems = find_files(options.folder, anatomy, out)
    if options.muscle:
        known = [one.name for one in files if one.kind == "muscle"]
        if missing := [name for name in options.muscle if name not in known]:
            raise Problem(f"--muscle {missing[0]}: the folder has no such muscle; there are {', '.join(known) or 'none'}")
        files = [one for one in files if one.kind != "muscle" or one.name in options.muscle]
    if not files:
        raise Problem(f"{options.folder}: no file matches a pattern of {options.map}; list the folder, and mend [files] of the map")
    say = Talker("import")
    try:
        with whole_folder(options.out, MARK, "import", options.force) as folder:
            result = import_anatomy(files, anatomy, problems, say, not options.muscle)
            scenes = write_import(folder, result, anatomy)
            if not options.no_pictures:
                draw(folder, say)
    except Problem:
        tell(problems)  # the reason may be one of these
        raise
    kinds = ", ".join(counted(len(result.surfaces(kind)), kind) for kind in ("bone", "cartilage", "muscle"))
    such_as = f", such as {options.out / scenes[0]}" if scenes else ""
    print(f"{options.out}: {kinds}, unit {result.unit}; {counted(len(scenes), 'scene')}{such_as}; see README.md there")
    if result.carried:
        print(f"Places of the map were carried to this body: {result.carried}.")
    for joint in result.joints:
        if joint.carried:
            print(f"Joint {joint.name}: {joint.carried}. So its axis is that of the map's reference, carried to this body.")
    print(f"Licence: {anatomy.licence}{': not for commercial use' if anatomy.is_non_commercial else ''}." + "".join(f"\nCite: {one}" for one in anatomy.cite))
    if not scenes and any(kind == "muscle" for kind, _ in anatomy.rules):
        result.problems.append(f"{options.map}: no scene: no muscle is attached to a bone that a joint moves and to one that stays; see README.md there")
    tell(result.problems)
    return CODE_PARTLY if result.problems else 0


def main(arguments=None) -> int:
    return run_command("import", lambda: make(TOOL.parse(arguments)), "nothing was written")


if __name__ == "__main__":
    sys.exit(main())
