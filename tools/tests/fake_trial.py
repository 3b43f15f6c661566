"""A small experiment with a program that is quick to start, and how it is called."""

import io
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import experiment
import fake_registry
from musclebench.experiments.case_tables import write_tables

QUICK = Path(__file__).resolve().parent / "fake_quick.sh"
ROLES = fake_registry.roles()
TRIAL = f"""title = "A trial"
scenes = ["synthetic/iliacus", "synthetic/gluteus_medius"]
repetitions = 3

[[cases]]
name = "replay"
mode = "replay"
backends = ["{ROLES.unit}", "{ROLES.exact}"]

[[cases]]
name = "run"
backends = ["{ROLES.unit}", "{ROLES.field}"]
"""


def command(trial: Path, out: Path, *more, program=QUICK) -> list[str]:
    return [sys.executable, experiment.__file__, str(trial), "--musclebench", str(program), "--out", str(out), *map(str, more)]


def call(trial: Path, out: Path, *more, program=QUICK) -> subprocess.CompletedProcess:
    """What the command would do, in this process: importing what it needs takes longer than most of what is tested."""
    words = command(trial, out, *more, program=program)[2:]
    with redirect_stdout(io.StringIO()) as output, redirect_stderr(io.StringIO()) as errors:
        code = experiment.main(words)
    return subprocess.CompletedProcess(words, code, output.getvalue(), errors.getvalue())


def answers(out: Path) -> bytes:
    write_tables(out)
    return (out / "answers.csv").read_bytes()


def wait_for(condition, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)
