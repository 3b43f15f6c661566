"""A build without optimisation is not timed: every command refuses it in one line before anything is measured."""

import subprocess
from pathlib import Path

import pytest

import accuracy
import hard
import effects
import experiment
import paper
import speed
from fake_trial import QUICK, TRIAL
from musclebench.program.cli import Problem
from musclebench.program.release_build import TOLD, build_type, check_release
from program import PROGRAM, needs_program

TESTS = Path(__file__).resolve().parent
ASKED = """title = "What is asked, not timed"
scenes = ["synthetic/iliacus"]

[[cases]]
name = "probe"
mode = "probe"
"""


def build_of(folder: Path, kind: str, stand_in: Path) -> Path:
    """A stand-in that says it was built so."""
    path = folder / f"{kind}.sh"
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && echo "musclebench 0.1.0 (abc, GNU 12.2.0, {kind})" && exit\n'
                    f'exec {stand_in} "$@"\n')
    path.chmod(0o755)
    return path


@pytest.mark.long
@pytest.mark.parametrize(("command", "words"), [
    (paper, []), (accuracy, ["--quick"]), (effects, ["--quick"]), (experiment, ["nightly", "--scene", "synthetic/iliacus"]),
])
def test_a_debug_build_is_refused_before_anything_is_written(command, words, tmp_path, capsys):
    program = build_of(tmp_path, "Debug", TESTS / "fake_musclebench.py")
    muscle = [] if command is experiment else ["--muscle", "iliacus"]
    assert command.main([*words, *muscle, "--musclebench", str(program), "--out", str(tmp_path / "out")]) == 2
    errors = capsys.readouterr().err
    assert errors == (f"{command.__name__}: {program}: times of a build of type Debug say nothing; build Release, "
                      "or take --any-build\n")
    assert not (tmp_path / "out").exists()


def test_the_speed_table_is_not_made_of_a_debug_build(tmp_path, capsys):
    program = build_of(tmp_path, "Debug", TESTS / "fake_speed.py")
    words = ["--quick", "--musclebench", str(program), "--micro", str(program), "--out", str(tmp_path / "out")]
    assert speed.main(words) == 2
    assert "times of a build of type Debug say nothing" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_who_insists_measures_it(tmp_path):
    (tmp_path / "trial.toml").write_text(TRIAL)
    words = [str(tmp_path / "trial.toml"), "--musclebench", str(build_of(tmp_path, "RelWithDebInfo", QUICK)),
             "--repetitions", "1", "--filter", "run", "--out", str(tmp_path / "out")]
    assert experiment.main(words) == 2
    assert experiment.main([*words, "--any-build"]) == 0
    assert experiment.main(words) == 0  # nothing is left to measure


def test_answers_need_no_release_build(tmp_path):
    (tmp_path / "asked.toml").write_text(ASKED)
    program = str(build_of(tmp_path, "Debug", TESTS / "fake_musclebench.py"))
    assert experiment.main([str(tmp_path / "asked.toml"), "--musclebench", program, "--out", str(tmp_path / "out")]) == 0
    with pytest.raises(Problem, match="unrecognized arguments: --any-build"):
        hard.parse_arguments(["--any-build"], experiment.read_experiment(tmp_path / "asked.toml"))


def test_a_program_that_does_not_tell_passes(tmp_path):
    check_release(build_of(tmp_path, "x, y (z", Path("/bin/true")))
    check_release(tmp_path / "no_such_program")


@needs_program
def test_the_program_tells_how_it_was_built():
    told = TOLD.search(subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout)
    assert told and told["type"] == build_type(Path(PROGRAM))
