"""A small experiment with a program that is quick to start, and how it is called."""

import os
import subprocess
import sys
import time
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


def call(trial: Path, out: Path, *more, program=QUICK, **environment) -> subprocess.CompletedProcess:
    return subprocess.run(command(trial, out, *more, program=program), capture_output=True, text=True, timeout=120,
                          check=False, env={**os.environ, **environment})


def answers(out: Path) -> bytes:
    write_tables(out)
    return (out / "answers.csv").read_bytes()


def wait_for(condition, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)
