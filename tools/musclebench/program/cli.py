"""What the commands that run experiments share: checks of their options, cores, interrupts."""

import argparse
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from .disk import DiskFull
from .out_folder import FolderInUse, holding_folders


class Problem(Exception):
    """The experiment can't go on; one line with location, problem and cure."""


class Interrupted(KeyboardInterrupt):
    """Says what is kept."""


class OneLineParser(argparse.ArgumentParser):
    """Raises Problem where argparse prints its usage and ends the process."""

    def error(self, message):
        raise Problem(f"{message}; --help shows the options")


def add_scene_options(group, default: str) -> None:
    group.add_argument("--data", type=Path, metavar="DIR",
                       help="LHDL data folder: run lhdl/* scenes (default: none, run synthetic/* scenes)")
    group.add_argument("--scene", action="append", metavar="SCENE",
                       help="a scene that `musclebench list` prints, or your .toml file; may be repeated "
                            f"({default})")
    group.add_argument("--muscle", action="append", metavar="NAME",
                       help="short for the data set's scene of this muscle; may be repeated")


def data_set_of(options) -> str:
    return "lhdl" if options.data else "synthetic"


def out_name_of(options) -> str:
    """The part of the default folder's name that distinguishes results: the data set, or the chosen scenes."""
    return "-".join(sorted({Path(scene).stem for scene in options.scene})) if options.scene else data_set_of(options)


def check_program(program: Path, builder: str) -> None:
    if not os.access(program, os.X_OK) or not program.is_file():
        raise Problem(f"{program}: no such program; build it first ({builder} does)")


def check_data(data_dir: Path | None) -> None:
    if data_dir is not None and not (data_dir / "lhdl.json").is_file():
        raise Problem(f"{data_dir}: has no lhdl.json; tools/import_lhdl.py makes such a folder")


def check_positive(option: str, value: float | None) -> None:
    """Whole numbers are 1 or more; others are above 0. None is not given."""
    if value is None:
        return
    if isinstance(value, int) and value < 1:
        raise Problem(f"{option} {value}: must be 1 or more")
    if not 0 < value < float("inf"):
        raise Problem(f"{option} {value:g}: must be a number above 0")


def chosen_cores(jobs: int | None) -> list[int]:
    """One a job; two jobs unless told, or one on one core. The last ones: the first core has the interrupts."""
    allowed = sorted(os.sched_getaffinity(0))
    return allowed[-min(jobs or 2, len(allowed)):]


def end_by_interrupt() -> None:
    """Being terminated ends a command as Ctrl-C does: tidily."""
    # Not the handler of SIGINT: a shell without job control has its background jobs ignore that signal.
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def run_command(name: str, work: Callable[[], int], interrupted: str, *problems: type[Exception]) -> int:
    """The exit code: that of `work`; 2 with one line for what it can't go on with, `problems` of its own among it; 130
    when it was interrupted, with the words that say what is kept."""
    end_by_interrupt()
    try:
        with holding_folders():
            return work()
    except (Problem, DiskFull, FolderInUse, OSError, *problems) as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as problem:
        print(f"\n{name}: interrupted; {str(problem) or interrupted}", file=sys.stderr)
        return 130
