"""Any scene takes part in an experiment: named, or a file of the user's own, with what the program tells of it."""

import json
from pathlib import Path

import pytest

import accuracy
import budget
import fake_registry
import paper
import speed
from musclebench.cases import scene
from musclebench.cases.case import Folders
from musclebench.cases.scene import Scene, chosen_names, full_flexion_frame, half_flexion_frame, survey
from musclebench.program.cli import Problem
from fake_sweep import swept
from program import PROGRAM, needs_program

FAKE = Path(__file__).resolve().parent / "fake_musclebench.py"
REGISTRY = fake_registry.registry()
THERE_AND_BACK = {"times": [0, 1], "angles_rad": [0, 1.5708], "there_and_back": True}


@pytest.fixture
def knee(tmp_path) -> Path:
    path = tmp_path / "my_knee.toml"
    path.write_text("title = 'a knee'\n")
    return path


@pytest.mark.parametrize("motion, frames, expected", [
    (THERE_AND_BACK, 314, 157), (THERE_AND_BACK, 5, 2),
    ({"times": [0, 1], "angles_rad": [0, -1.5708], "there_and_back": True}, 90, 45),  # to the back is a flexion, too
    ({"times": [0, 1], "angles_rad": [0, 1], "there_and_back": False}, 90, 90),
    ({"times": [0, 1, 4], "angles_rad": [0.1, -2, 1], "there_and_back": False}, 100, 25),
    ({"angles_rad": []}, 90, 90),
])
def test_full_flexion_is_where_the_angle_is_largest_either_way(motion, frames, expected):
    assert full_flexion_frame([{"angles_rad": []}, motion], frames) == expected


@pytest.mark.parametrize("motion, frames, expected", [
    (THERE_AND_BACK, 314, 79), (THERE_AND_BACK, 20, 5), (THERE_AND_BACK, 1, 1),
    ({"times": [0, 3, 4], "angles_rad": [0, 0.1, 1]}, 100, 86),  # it turns late
    ({"times": [0, 1], "angles_rad": [-0.5, 1.5]}, 10, 5), ({"angles_rad": []}, 90, 45),
])
def test_half_flexion_is_the_frame_whose_angle_is_nearest_to_half(motion, frames, expected):
    assert half_flexion_frame([motion, {"angles_rad": [0, 0.01]}], frames) == expected


def test_scenes_are_chosen_by_name_by_file_or_by_muscle(knee):
    names = chosen_names([str(knee), "lhdl/iliacus", str(knee)], ["gluteus_medius"], "synthetic", REGISTRY)
    assert names == [str(knee), "lhdl/iliacus", "synthetic/gluteus_medius"]
    assert chosen_names(None, None, "lhdl", REGISTRY) == [f"lhdl/{muscle}" for muscle in fake_registry.NODES]
    assert chosen_names(None, None, "synthetic", REGISTRY, "iliacus") == ["synthetic/iliacus"]


@pytest.mark.parametrize("command", [accuracy, budget, paper, speed])
def test_help_says_which_scenes_are_the_default(command, capsys):
    with pytest.raises(SystemExit):
        command.main(["--help"])
    assert "every scene of the data set with one muscle" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("scenes, words", [
    (["my_knee.toml"], "--scene my_knee.toml: no such file"),
    (["synthetic/iliacs"], "did you mean 'synthetic/iliacus'?"),
])
def test_a_scene_that_is_not_there_is_named(scenes, words):
    with pytest.raises(Problem, match="--scene") as problem:
        chosen_names(scenes, None, "synthetic", REGISTRY)
    assert words in str(problem.value)


def test_two_files_of_one_name_are_refused(knee, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "my_knee.toml").write_text("")
    with pytest.raises(Problem, match="two files are named my_knee.toml"):
        chosen_names([str(knee), str(tmp_path / "other" / "my_knee.toml")], None, "synthetic", REGISTRY)


def test_scenes_of_one_muscle_have_keys_of_their_own(tmp_path):
    found = survey(["lhdl/iliacus", "synthetic/iliacus", "lhdl/gluteus_medius"], FAKE, REGISTRY, Folders(tmp_path))
    assert [one.key for one in found] == ["lhdl-iliacus", "synthetic-iliacus", "gluteus_medius"]


def test_a_scene_file_is_planned_with_its_own_preset_and_probed_on_its_own_bones(knee, tmp_path):
    mine, = survey([str(knee)], FAKE, REGISTRY, Folders(tmp_path))
    assert mine.key == "my_knee" and mine.nodes == 1000 and mine.digest
    cases = swept("accuracy", mine, fake_registry.scene("synthetic/iliacus"))
    mine_only = [case for case in cases if case.name.startswith("my_knee")]
    assert all(str(knee) in case.arguments(Folders(tmp_path)) for case in mine_only if "-replay-" not in case.name)
    assert not any("--preset" in case.arguments(Folders(tmp_path)) for case in mine_only)
    probed = {case.scene.name for case in cases if "-probe-" in case.name}
    assert probed == {str(knee), "synthetic/adductor_brevis"}


def test_a_changed_scene_file_is_measured_again(knee, tmp_path):
    before, = survey([str(knee)], FAKE, REGISTRY, Folders(tmp_path))
    knee.write_text("title = 'another knee'\n")
    after, = survey([str(knee)], FAKE, REGISTRY, Folders(tmp_path))
    assert before.digest != after.digest


def test_the_study_of_a_scene_file_leaves_its_rows(knee, tmp_path, monkeypatch, capsys):
    few = {"null": {"control": True, "series": [{"replays": False}]}, "bvh": {"series": [{}]}}
    (tmp_path / "registry.json").write_text(fake_registry.with_studies(few))
    monkeypatch.setenv("FAKE_REGISTRY", str(tmp_path / "registry.json"))
    monkeypatch.setattr(accuracy.report, "write_report", lambda out_dir: [])
    out = tmp_path / "out"
    assert accuracy.main(["--musclebench", str(FAKE), "--scene", str(knee), "--repetitions", "1", "--out", str(out)]) == 0
    assert {path.name for path in (out / "raw").iterdir()} == {
        "my_knee-coupled-null-r0", "my_knee-coupled-bvh-r0", "my_knee-replay-bvh-r0", "my_knee-floor-bvh-r0",
        "my_knee-arms-null-r0", "my_knee-arms-bvh-r0", "my_knee-arms_floor-bvh-r0", "my_knee-forces-null-r0",
        "my_knee-forces-bvh-r0", "my_knee-forces_floor-bvh-r0"}
    sealed = json.loads((out / "raw" / "my_knee-coupled-bvh-r0" / "case.json").read_text())
    assert sealed["scene_sha256"]


@needs_program
def test_the_program_tells_of_a_scene_what_experiments_ask(tmp_path):
    found, = survey(["synthetic/adductor_brevis"], Path(PROGRAM), REGISTRY, Folders(tmp_path), 10)
    expected = fake_registry.scene("synthetic/adductor_brevis", 10)
    assert found == expected and (found.frames, found.full_flexion_frame, found.iterations) == (10, 5, 3)
    with pytest.raises(Problem, match="preset"):
        scene.survey([str(_broken(tmp_path))], Path(PROGRAM), REGISTRY, Folders(tmp_path))


def _broken(folder: Path) -> Path:
    path = folder / "broken.toml"
    path.write_text("preset = 'no such preset'\n")
    return path


def test_the_numbers_without_a_survey_are_the_papers():
    plain = Scene("lhdl/iliacus")
    assert (plain.steps, plain.size, plain.key) == (942, 1.0, "iliacus")
