"""Whether a program was built with optimisation, asked before any time is spent on measuring it."""

import re
import subprocess
from pathlib import Path

from .cli import Problem

RELEASE = "Release"
ANSWER_SECONDS = 60.0
# `musclebench --version`: name, version, and in brackets commit, compiler, build type.
TOLD = re.compile(r"\((?P<commit>[^,()]*), (?P<compiler>[^()]*), (?P<type>[^,()]*)\)\s*$")


def add_build_option(group) -> None:
    group.add_argument("--any-build", action="store_true",
                       help="measure a build even if it is not Release; its times mean nothing")


def build_type(program: Path) -> str:
    """RELEASE where the program does not tell: its results then do."""
    try:
        done = subprocess.run([str(program), "--version"], capture_output=True, text=True, check=False, timeout=ANSWER_SECONDS)
    except (OSError, subprocess.TimeoutExpired):
        return RELEASE
    found = TOLD.search(done.stdout)
    return found["type"] if found else RELEASE


def refusal(name: str, kind: str, otherwise: str) -> Problem:
    """`otherwise`: the option that lets it pass; may be empty."""
    return Problem(f"{name}: times of a build of type {kind or 'none'} say nothing; build Release"
                   + (f", or take {otherwise}" if otherwise else ""))


def check_release(program: Path, otherwise: str = "--any-build") -> None:
    if (kind := build_type(program)) != RELEASE:
        raise refusal(str(program), kind, otherwise)
