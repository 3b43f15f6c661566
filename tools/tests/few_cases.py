"""The accuracy study of a real program with a shorter list of cases than the program's, which takes a quarter of an hour."""

import json
import subprocess
import sys
from pathlib import Path

import accuracy
from program import PROGRAM, call

DRIVER = """
import sys
sys.path.insert(0, {tools!r})
import accuracy
from musclebench.program.registry import parse_registry
accuracy.read_registry = lambda program: parse_registry(open({listed!r}).read(), "few")
sys.exit(accuracy.main(sys.argv[1:]))
"""
SLOW_STEP_MS = 1000.0  # of a backend that is there to be right: it replays few frames and moves no muscle


def program_list() -> dict:
    return json.loads(call("list", "--json").stdout)


def run_few(out: Path, *arguments, cwd: Path | None = None) -> subprocess.CompletedProcess:
    """Results go to `out`, the list beside it."""
    listed = out.with_suffix(".json")
    listed.write_text(json.dumps(_few_cases(program_list())))
    command = [sys.executable, "-c", DRIVER.format(tools=str(Path(accuracy.__file__).parent), listed=str(listed))]
    return subprocess.run([*command, "--musclebench", PROGRAM, "--out", str(out), *arguments],
                          capture_output=True, text=True, timeout=400, check=False, cwd=cwd)


def _few_cases(listed: dict) -> dict:
    """The list with the first series of each backend and of what that sweeps two values."""
    return listed | {"backends": [one | {"study": _with_first_series(one["study"] or {})} for one in listed["backends"]]}


def _with_first_series(study: dict) -> dict:
    first = {"step_ms": 0.1} | study.get("defaults", {}) | (study.get("series") or [{}])[0]
    drives = isinstance(first["step_ms"], list) or first["step_ms"] < SLOW_STEP_MS
    sweep = {"sweep": {key: values[:2] for key, values in first.get("sweep", {}).items()}} if "sweep" in first else {}
    return study | {"series": [first | sweep | {"quick": True, "drives": drives}]}
