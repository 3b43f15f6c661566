"""The one list of cases: what bench/experiments/nightly.toml says is what tools/compare and tools/nightly run."""

import argparse
from pathlib import Path

import pytest

import compare
from musclebench.cases.case import Folders
from musclebench.comparison.compared_cases import asked_experiment, first_cases
from musclebench.comparison.interleaved import COUNTED, JUDGED, PROGRAM_NAMES, TIMED, Plan, plan
from musclebench.experiments.experiment_file import of_project
from musclebench.options.shared import add_case_options
from musclebench.program.registry import read_registry
from test_compare import SCENE, program

FOLDERS = Folders(Path("out"))
OWN = """title = "A trial"
scenes = ["hard/resting_contact"]
repetitions = 2

[[cases]]
name = "own"
backends = ["tree"]
threads = [1, 2]
judged = "never"
"""


@pytest.fixture
def planned(tmp_path, monkeypatch):
    monkeypatch.setattr("musclebench.comparison.interleaved.why_not_by_callgrind", lambda: "")
    fake = Path(program(tmp_path, "a"))
    registry = read_registry(fake)

    def make(*words, programs=PROGRAM_NAMES) -> Plan:
        parser = argparse.ArgumentParser()
        add_case_options(parser)
        options = parser.parse_args(words)
        file = asked_experiment(options, registry)
        return plan(first_cases(file, fake, registry, FOLDERS, options.backend), file, programs)
    return make


def value(words: list[str], option: str) -> str:
    return words[words.index(option) + 1] if option in words else ""


def test_the_default_is_the_nightly_experiment(planned):
    found = planned(programs=("after",))
    nightly = of_project("nightly")
    timed = [case for case in found.cases if case.purpose == TIMED]
    assert found.repetitions == nightly.repetitions and len(timed) == nightly.repetitions * (4 + 3)
    told = {(words[1], value(words, "--backend"), value(words, "--frames"), value(words, "--preset"))
            for words in (case.arguments(FOLDERS) for case in timed)}
    small, small_slow, usual, _, _, motion = nightly.groups
    fast = ("plain", "tree", "grid")  # what has no longest_stride in its study
    assert told == {*((SCENE, name, str(small.frames[0]), "") for name in fast), (SCENE, "slow", str(small_slow.frames[0]), ""),
                    *(("synthetic/iliacus", name, str(usual.frames[0]), "paper") for name in fast)}
    judged = [case.arguments(FOLDERS) for case in found.cases if case.purpose == JUDGED and case.asked.group.name == motion.name]
    assert len(judged) == len(fast)  # what is run once is judged, and not timed
    assert all("--fibres-if-possible" in words and "rest_frames=" in value(words, "--loop") for words in judged)
    assert all(value(words, "--snapshots").startswith("0,") for words in judged)


def test_judging_and_counting_are_runs_of_their_own_and_programs_stand_next_to_each_other(planned):
    found = planned("--scene", SCENE, "--backend", "tree", "--repetitions", "2")
    assert [case.folder for case in found.cases[:4]] == [f"{side}/raw/resting_contact-tree-{purpose}"
                                                         for purpose in (JUDGED, COUNTED) for side in PROGRAM_NAMES]
    timed = found.cases[4:]
    assert [case.asked.repetition for case in timed] == [0, 0, 1, 1]
    assert all({one.program, other.program} == set(PROGRAM_NAMES) for one, other in zip(timed[::2], timed[1::2]))
    judged, counted, one = (case.arguments(FOLDERS) for case in (found.cases[0], found.cases[2], timed[0]))
    assert "--no-referee" not in judged and "--no-referee" in counted and "--no-referee" in one
    assert (value(judged, "--frames"), value(counted, "--frames")) == ("60", "6")


def test_neither_program_always_runs_first(planned):
    timed = [case for case in planned("--scene", SCENE, "--backend", "tree").cases if case.purpose == TIMED]
    assert {case.program for case in timed[::2]} == set(PROGRAM_NAMES)


def test_options_replace_what_the_experiment_says(planned, tmp_path):
    scene = tmp_path / "mine.toml"
    scene.write_text("")
    cases = planned("--scene", str(scene), "--frames", "7", "--repetitions", "1").cases
    assert {case.base for case in cases} == {f"mine-{name}" for name in ("plain", "tree", "grid", "slow")}
    assert {value(case.arguments(FOLDERS), "--frames") for case in cases} == {"7"}
    assert not any(case.purpose == COUNTED for case in cases)


def test_an_experiment_of_ones_own(planned, tmp_path):
    (tmp_path / "own.toml").write_text(OWN)
    cases = planned("--experiment", str(tmp_path / "own.toml")).cases
    assert {case.folder for case in cases} == {f"{side}/raw/resting_contact-own-tree{threads}-r{number}" for side in PROGRAM_NAMES
                                               for threads in ("", "-threads=2") for number in range(2)}


@pytest.mark.parametrize(("words", "told"), [
    (["--backend", "nothing"], "--backend nothing: not built; there are: plain, tree, grid, slow"),
    (["--scene", "nothing"], "--scene nothing: neither a scene of the program nor a .toml file"),
    (["--scene", "synthetic/iliacus", "--backend", "slow"], "has no case of these scenes and backends"),
    (["--experiment", "accuracy"], "'probe': mode 'probe'; only runs are interleaved"),
    (["--experiment", "nightl"], "did you mean 'nightly'"), (["--frames", "0"], "--frames 0: must be 1 or more"),
])
def test_what_can_not_be_run_is_one_line(words, told, tmp_path, capsys):
    one = program(tmp_path, "a")
    assert compare.main([one, one, "--out", str(tmp_path / "out"), *words]) == 2
    errors = capsys.readouterr().err
    assert told in errors and errors.count("\n") == 1 and not (tmp_path / "out").exists()
