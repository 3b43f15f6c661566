"""Whether a program was built with optimisation, asked before any time is spent on measuring it."""

import json
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

from ..cases.case import Folders
from ..program.cli import Problem
from .interleaved import TIMED, InterleavedCase
from .usual_cases import What

ANSWER_SECONDS = 300.0


def check_release(program: Path, what: What) -> None:
    """By a run of one frame, which says how the program was built. One that does not run is told of where it is measured."""
    with tempfile.TemporaryDirectory() as folder:
        case = InterleavedCase(replace(what, frames=1), "", TIMED)
        command = [str(program), *case.arguments(Folders(Path(folder))), "--out", f"{folder}/run"]
        try:
            subprocess.run(command, capture_output=True, check=False, timeout=ANSWER_SECONDS)
            kind = json.loads((Path(folder) / "run" / "run.json").read_text())["build"]["type"]
        except (OSError, ValueError, KeyError, TypeError, subprocess.TimeoutExpired):
            return
    if kind != "Release":
        raise Problem(f"{program}: times of a build of type {kind or 'none'} say nothing; build Release")
