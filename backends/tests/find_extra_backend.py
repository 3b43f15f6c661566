#!/usr/bin/env python3
"""A backend outside the project, from its folder to figures: run by CTest, in the words of the README's recipe. With
MUSCLEBENCH_CGAL_TOO=1 the one on CGAL is beside it: no other build has it, as CGAL is under the GPL, and it takes minutes."""

import argparse
import csv
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

NAME = "capsule"
CGAL = "cgal"
HAS_CGAL = os.environ.get("MUSCLEBENCH_CGAL_TOO") == "1"
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
WRITE_SCENE = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from ball_on_box import write_scene_of_balls
write_scene_of_balls(Path({folder!r}))
"""


def call(*command: str | Path, code: int = 0) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=1000, check=False)
    assert done.returncode == code, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def configure(arguments: argparse.Namespace, backends: Path | str, build: Path, code: int = 0) -> str:
    """Libraries that the build under test has are linked, not compiled once more."""
    return call(arguments.cmake, "-S", arguments.source, "-B", build, *arguments.settings, "-DMUSCLEBENCH_WITH_MICRO=OFF",
                "-DMUSCLEBENCH_PCH=OFF", f"-DMUSCLEBENCH_PREBUILT={arguments.build}",
                f"-DMUSCLEBENCH_EXTRA_BACKENDS={backends}", "-DMUSCLEBENCH_WITH_CGAL=OFF", code=code)


def built_with_it(arguments: argparse.Namespace, folder: Path) -> Path:
    """The program; the contract suite has passed."""
    backend, build = folder / NAME, folder / "build"
    shutil.copytree(Path(arguments.source) / "backends/tests" / NAME, backend)
    others = [Path(arguments.source) / "backends" / CGAL] if HAS_CGAL else []
    configure(arguments, ";".join(map(str, [backend, *others])), build)
    call(arguments.cmake, "--build", build, "-j", "2", "--target", "musclebench", "musclebench_backends_tests")
    call(Path(arguments.cmake).with_name("ctest"), "--test-dir", build, "-R", "|".join([NAME, *(other.name for other in others)]), "--no-tests=error")
    return build / "bench/musclebench"


def is_listed(program: Path) -> None:
    backends = {backend["name"]: backend for backend in json.loads(call(program, "list", "--json"))["backends"]}
    assert NAME in backends and len(backends) > 4, sorted(backends)
    assert (CGAL in backends) == HAS_CGAL, sorted(backends)
    assert backends[NAME]["study"]["series"][0]["sweep"] == {"radius_share": [0.8, 0.9, 1.0]}
    assert backends[NAME]["colour"] == "#56B4E9"
    assert NAME in call(program, "list")


def runs_and_is_judged(program: Path, scene: Path, folder: Path) -> None:
    call(program, "run", scene, "--frames", "6", "--backend", NAME, "--param", "radius_share=0.9", "--out", folder / "run")
    case = json.loads((folder / "run/run.json").read_text())["case"]
    assert case["backend"] == NAME and case["response"] == "project"
    refused = call(program, "run", scene, "--backend", NAME, "--response", "backtrack", code=2)
    assert "has no cells" in refused.splitlines()[-1], refused


def is_tried_by_advise(program: Path, scene: Path) -> None:
    advice = call(program, "advise", scene, "--frames", "6", "--depth-mm", "50", "--seconds", "100")
    assert f"{NAME} radius_share=0.9" in advice, advice


def is_in_tables_and_figures_of_the_study(program: Path, scene: Path, source: str, folder: Path) -> None:
    out = folder / "study"
    script = STUDY.format(tools=str(Path(source) / "tools"), program=str(program), name=NAME)
    # A build with sanitizers reserves terabytes of addresses, which count as memory here; that of threads wants no limit.
    call("/usr/bin/python3", "-c", script, "--musclebench", program, "--out", out, "--scene", scene,
         "--quick", "--frames-limit", "4", "--jobs", "1", "--memory-gb", "inf", "--any-build")
    for table in ("accuracy.csv", "study.csv", "figures/pareto_replay.csv"):
        with open(out / table, newline="") as file:
            assert [row for row in csv.DictReader(file) if row["backend"] == NAME], table
    assert "#56b4e9" in (out / "figures/pareto_replay.svg").read_text().lower(), "its colour"


def a_folder_without_lists_is_refused(arguments: argparse.Namespace, folder: Path) -> None:
    (folder / NAME / "CMakeLists.txt").unlink()
    assert "has no CMakeLists.txt" in configure(arguments, folder / NAME, folder / "build", code=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("source", "build", "cmake"):
        parser.add_argument(f"--{option}", required=True)
    parser.add_argument("settings", nargs="*", help="of the build, for CMake")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = built_with_it(arguments, folder)
        is_listed(program)
        scene = folder / "scene.toml"
        tests = str(Path(arguments.source) / "tools/tests")
        call("/usr/bin/python3", "-c", WRITE_SCENE.format(tests=tests, folder=str(folder)))
        runs_and_is_judged(program, scene, folder)
        is_tried_by_advise(program, scene)
        is_in_tables_and_figures_of_the_study(program, scene, arguments.source, folder)
        a_folder_without_lists_is_refused(arguments, folder)


if __name__ == "__main__":
    main()
