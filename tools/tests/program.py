"""The program under test, which MUSCLEBENCH_BINARY names; tests that need it are skipped without it."""

import os
import subprocess
from pathlib import Path

import pytest

from musclebench.program.cli import Problem
from musclebench.program.native_module import add_native_module

PROGRAM = os.environ.get("MUSCLEBENCH_BINARY", "")
PROGRAM = PROGRAM and str(Path(PROGRAM).resolve())
needs_program = pytest.mark.skipif(
    not PROGRAM, reason="MUSCLEBENCH_BINARY does not name the program (tools/test sets it)")


def has_native_module() -> bool:
    try:
        add_native_module(Path(PROGRAM))
        return True
    except Problem:
        return False


needs_native_module = pytest.mark.skipif(not has_native_module(), reason="MUSCLEBENCH_BINARY names no program with a Python module (pybind11) beside it")


def call(*arguments, timeout=120, **options) -> subprocess.CompletedProcess:
    """The program with these arguments."""
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, check=False,
                          **options)


def complaint(done: subprocess.CompletedProcess) -> str:
    """What the program says beside its warnings."""
    return "".join(line for line in done.stderr.splitlines(keepends=True) if "warning: " not in line)


def find_lhdl() -> Path | None:
    """The LHDL data folder, where there is one."""
    candidates = [os.environ.get("MUSCLEBENCH_DATA"), Path(__file__).resolve().parents[3] / "shared" / "data" / "lhdl"]
    return next((Path(folder) for folder in candidates if folder and (Path(folder) / "lhdl.json").is_file()), None)
