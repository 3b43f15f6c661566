#!/usr/bin/env python3
"""A backend outside the project, from its folder to advice: run by CTest with a program that has it."""

import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

NAME = "capsule"
# The study of few backends: the newcomer, what prices are told in, and the exact and empty ones to compare with.
STUDY = """
import json, subprocess, sys
sys.path.insert(0, {tools!r})
import accuracy
from musclebench.program.registry import parse_registry
listed = json.loads(subprocess.run([{program!r}, "list", "--json"], capture_output=True, check=True).stdout)
few = [one for one in listed["backends"] if one["name"] == {name!r} or "unit_of_price" in (one["study"] or {{}}).get("advise", {{}})]
accuracy.read_registry = lambda program: parse_registry(json.dumps(listed | {{"backends": few}}), "few")
sys.exit(accuracy.main(sys.argv[1:]))
"""
SCENE = ("synthetic/adductor_brevis", "--frames", "6")


def call(*command: str | Path, code: int = 0) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == code, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def is_listed(program: str) -> None:
    backends = {backend["name"]: backend for backend in json.loads(call(program, "list", "--json"))["backends"]}
    assert NAME in backends and len(backends) > 4, sorted(backends)
    assert backends[NAME]["study"]["series"][0]["sweep"] == {"radius_share": [0.8, 0.9, 1.0]}
    assert backends[NAME]["colour"] == "#56B4E9"
    assert NAME in call(program, "list")


def runs_and_is_judged(program: str, folder: Path) -> None:
    call(program, "run", *SCENE, "--backend", NAME, "--param", "radius_share=0.9", "--out", folder / "run")
    case = json.loads((folder / "run/run.json").read_text())["case"]
    assert case["backend"] == NAME and case["response"] == "project"
    refused = call(program, "run", *SCENE, "--backend", NAME, "--response", "backtrack", code=2)
    assert refused.count("\n") == 1 and "cells" in refused, refused


def is_tried_by_advise(program: str) -> None:
    advice = call(program, "advise", *SCENE, "--depth-mm", "50", "--seconds", "100")
    assert f"{NAME} radius_share=0.9" in advice, advice


def is_in_tables_and_figures_of_the_study(arguments: argparse.Namespace, folder: Path) -> None:
    out = folder / "study"
    script = STUDY.format(tools=str(Path(arguments.source) / "tools"), program=arguments.program, name=NAME)
    call("/usr/bin/python3", "-c", script, "--musclebench", arguments.program, "--out", out, "--muscle", "adductor_brevis",
         "--quick", "--frames-limit", "4", "--jobs", "1")
    for table in ("accuracy.csv", "study.csv", "figures/pareto_replay.csv"):
        with open(out / table, newline="") as file:
            assert [row for row in csv.DictReader(file) if row["backend"] == NAME], table
    assert "#56b4e9" in (out / "figures/pareto_replay.svg").read_text().lower(), "its colour"


def is_built_by_the_option(arguments: argparse.Namespace, folder: Path) -> None:
    """Only configured: what is compiled then is what this program was made from."""
    configure = [arguments.cmake, "-S", arguments.source, "-B", folder / "build", "-G", arguments.generator,
                 f"-DCMAKE_CXX_COMPILER={arguments.compiler}", "-DMUSCLEBENCH_WITH_TESTS=OFF",
                 "-DMUSCLEBENCH_WITH_MICRO=OFF", "-DMUSCLEBENCH_WITH_FCL=OFF"]
    extra = folder / NAME
    extra.mkdir()
    for source in (Path(arguments.source) / "backends/tests" / NAME).iterdir():
        (extra / source.name).write_bytes(source.read_bytes())
    call(*configure, f"-DMUSCLEBENCH_EXTRA_BACKENDS={extra}")
    table = (folder / "build/backends/backend_table.cpp").read_text()
    assert f"{NAME}_entry()" in table and "radius_share = [0.8" in table
    (extra / "CMakeLists.txt").unlink()
    assert "has no CMakeLists.txt" in call(*configure, f"-DMUSCLEBENCH_EXTRA_BACKENDS={extra}", code=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("program", "source", "cmake", "compiler", "generator"):
        parser.add_argument(f"--{option}", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        is_listed(arguments.program)
        runs_and_is_judged(arguments.program, Path(folder))
        is_tried_by_advise(arguments.program)
        is_in_tables_and_figures_of_the_study(arguments, Path(folder))
        is_built_by_the_option(arguments, Path(folder))


if __name__ == "__main__":
    main()
