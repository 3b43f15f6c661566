"""What stands in for the program says what the program says: the same keys, kinds of values and columns."""

import csv
import json
import re
import subprocess
from pathlib import Path

import pytest

import fake_registry
import fake_runs
import fake_speed
import fake_study
from fake_study import Truth
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.kernels import MICRO_PROGRAM
from musclebench.program.registry import parse_registry
from program import PROGRAM, call, needs_program
from musclebench.results import disturbance
from musclebench.speed import bars

pytestmark = needs_program
SCENE = "synthetic/adductor_brevis"


@pytest.fixture(scope="module")
def listed() -> dict:
    done = call("list", "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def real(tmp_path_factory) -> Path:
    """A coupled run, a recording's replay and a probe of the real program."""
    folder = tmp_path_factory.mktemp("real")
    grid = ("--backend", "voxel", "--param", "cells=16")
    for done in (
        call("run", SCENE, *grid, "--preset", "paper", "--frames", 4, "--snapshots", "0,2",
             "--out", folder / "coupled"),
        call("record", SCENE, "--preset", "paper", "--frames", 4, "--out", folder / "a.recording"),
        call("replay", folder / "a.recording", *grid, "--out", folder / "replay"),
        call("probe", SCENE, *grid, "--points", 100, "--out", folder / "probe"),
    ):
        assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def fake(tmp_path) -> Path:
    truth = Truth(parameters={"cells": 16, "voxel_size_m": 0.0})
    fake_study.write_coupled(tmp_path / "raw" / "coupled", SCENE, "voxel", truth)
    fake_study.write_replay(tmp_path / "raw" / "replay", SCENE, "voxel", truth)
    fake_study.write_probe(tmp_path / "raw" / "probe", SCENE, "voxel", truth)
    return tmp_path / "raw"


def shape(value):
    """Kinds of values without the values; numbers are numbers, null fits everything."""
    if isinstance(value, dict):
        return {key: shape(part) for key, part in value.items()}
    if isinstance(value, list):
        return [shape(value[0])] if value else []
    return "number" if isinstance(value, (int, float)) and not isinstance(value, bool) else type(value).__name__


def misfits(mine, real, path: str = "") -> list[str]:
    """What a fake says that the program does not say, or says as something else."""
    if isinstance(mine, dict) and isinstance(real, dict):
        return [line for key, part in mine.items() for line in (
            misfits(part, real[key], f"{path}.{key}") if key in real else [f"{path}.{key} is not in the program's"])]
    if isinstance(mine, list) and isinstance(real, list):
        return misfits(mine[0], real[0], f"{path}[]") if mine and real else []
    return [] if "NoneType" in (mine, real) or mine == real else [f"{path}: {mine}, the program's {real}"]


def test_the_fixture_has_the_schema_of_the_programs_list(listed):
    mine = fake_registry.listed()
    for keys in ("backends", "effects", "loop", "presets", "scenes", "responses"):
        for theirs in listed[keys][:1]:
            assert misfits(shape(mine[keys][0]), shape(theirs), keys) == []
    assert set(mine) <= set(listed) and mine["schema"] == listed["schema"]


def test_the_fixture_has_the_programs_backends_and_parameters(listed):
    theirs = {backend["name"]: backend for backend in listed["backends"]}
    for backend in fake_registry.listed()["backends"]:
        if backend["name"] not in theirs:
            pytest.skip(f"{backend['name']} is not a backend of this build")
        real = theirs[backend["name"]]
        for key in ("label", "implementation", "colour", "dash", "default_response", "exact"):
            assert backend[key] == real[key], f"{backend['name']}: {key}"
        told = [[{key: one.get(key) for key in ("name", "kind", "unit", "default", "minimum", "maximum", "choices", "role")}
                 for one in about["parameters"]] for about in (backend, real)]
        assert told[0] == told[1], backend["name"]
        assert backend["capabilities"].items() <= real["capabilities"].items(), backend["name"]
        assert backend["study"] == real["study"]


def test_the_fixture_has_the_programs_scenes(listed):
    told = [{scene["name"]: scene["bones"] for scene in about["scenes"]} for about in (fake_registry.listed(), listed)]
    assert told[0] == told[1]


def test_the_fixture_has_effects_of_the_program(listed):
    theirs = {effect["name"]: effect for effect in listed["effects"]}
    for effect in fake_registry.listed()["effects"]:
        assert effect == theirs[effect["name"]]


def test_the_tools_read_the_programs_list(listed):
    registry = parse_registry(json.dumps(listed), "the program")
    assert registry.control and registry.unit_of_price and registry.names


@pytest.mark.parametrize("mode", ["coupled", "replay", "probe"])
def test_a_fake_run_says_nothing_that_the_program_does_not_say(real, fake, mode):
    theirs, mine = [json.loads((folder / mode / "run.json").read_text()) for folder in (real, fake)]
    mine["case"]["parameters"] = theirs["case"]["parameters"]
    assert misfits(shape(mine), shape(theirs)) == []


@pytest.mark.parametrize("mode, name, columns", [
    ("coupled", "frames.csv", fake_runs.COLUMNS), ("replay", "frames.csv", fake_study.REPLAY_COLUMNS),
    ("probe", "probe.csv", fake_study.PROBE_COLUMNS),
])
def test_fake_tables_have_the_programs_columns(real, mode, name, columns):
    with open(real / mode / name, newline="") as file:
        theirs = next(csv.reader(file))
    assert set(columns) <= set(theirs)


@pytest.mark.parametrize("table, columns", [("muscles", fake_runs.MUSCLE_COLUMNS), ("pairs", fake_runs.PAIR_COLUMNS)])
def test_fake_tables_of_several_muscles_are_the_programs(listed, table, columns):
    assert columns == [column["name"] for column in listed["results"][table]["columns"]]


@pytest.fixture(scope="module")
def micro() -> Path:
    program = Path(PROGRAM).parent / "micro" / MICRO_PROGRAM
    if not program.is_file():
        pytest.skip(f"{MICRO_PROGRAM} is not built beside the program")
    return program


def kernels_of(program: Path) -> set[str]:
    """Without what tells how they are timed."""
    done = subprocess.run([str(program), "--benchmark_list_tests"], capture_output=True, text=True, check=True)
    return {re.sub(r"(/iterations:\d+)?(/(real|manual)_time)?$", "", name) for name in done.stdout.splitlines()}


@pytest.mark.long
def test_every_target_names_kernels_that_there_are(listed, micro):
    groups = {group.name: micro.with_name(group.program) for group in of_project("speed").groups if group.mode == "kernels"}
    names = {program: kernels_of(program) for program in set(groups.values()) if program.is_file()}
    for target in bars.targets(parse_registry(json.dumps(listed), "the program")):
        for kernel in (target[key] for key in ("kernel", "below") if key in target):
            pattern = re.compile(re.escape(kernel).replace(r"\{\}", ".*"))
            there = names.get(groups[target["group"]])
            assert there is None or any(map(pattern.fullmatch, there)), f"{target['what']}: {kernel}"


def test_fake_kernels_are_kernels_of_the_program(micro):
    mine = {name.replace("pelvis", "hip_bone") for name, _, _ in fake_speed.KERNELS}
    assert mine <= kernels_of(micro), mine - kernels_of(micro)


@pytest.mark.long
def test_fake_results_of_kernels_are_as_the_program_writes_them(micro, tmp_path):
    files = {program: tmp_path / f"{Path(program).name}.json" for program in (micro, fake_speed.__file__)}
    for program, file in files.items():
        subprocess.run([str(program), "--benchmark_filter=^voxel_test/femur$", "--benchmark_repetitions=2",
                        "--benchmark_min_time=0.001", f"--benchmark_out={file}", "--benchmark_out_format=json"],
                       capture_output=True, check=True, timeout=120)
    theirs, mine = ([one for one in json.loads(files[program].read_text())["benchmarks"]
                     if one["run_type"] == "iteration"][0] for program in files)
    assert misfits(shape(mine), shape(theirs)) == []


def test_a_survey_is_a_part_of_a_probe(real):
    theirs = json.loads((real / "probe" / "run.json").read_text())
    assert misfits(shape(fake_registry.survey_record(SCENE, 4)), shape(theirs)) == []


def test_the_machines_state_is_read_as_the_program_writes_it(real):
    for mode in ("coupled", "replay"):
        record = json.loads((real / mode / "run.json").read_text())
        assert disturbance.usual_clock_mhz([record]) is None or disturbance.usual_clock_mhz([record]) > 0
        assert "load 99.0" in disturbance.disturbance(
            record | {"machine_state": record["machine_state"] | {"load_average_1m": {"before": 1.0, "after": 99.0}}})
