"""Random scenes: they begin apart, the judge sees what passes, and with no_passage nothing does."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from musclebench.stress.judge import passing, sides, winding
from musclebench.stress.scenes import random_scene
from musclebench.stress.shapes import box, room
from program import PROGRAM, needs_program

TOOL = Path(__file__).resolve().parents[1] / "stress.py"
FLUNG_SCENE = 98  # of seed 1: three muscles at 15 m/s in a room


def stress(out: Path, *words: str) -> tuple[subprocess.CompletedProcess, pd.DataFrame]:
    done = subprocess.run([sys.executable, TOOL, "--musclebench", PROGRAM, "--out", out, *words], capture_output=True, text=True,
                          check=False, timeout=1500)
    return done, pd.read_csv(out / "scenes.csv", keep_default_na=False)


def test_scenes_begin_apart_and_are_the_same_again():
    for number in range(1, 9):
        scene, again = random_scene(3, number), random_scene(3, number)
        bodies = [*scene.bones, *scene.muscles]
        for i, one in enumerate(bodies):
            assert np.array_equal(one.mesh.points, [*again.bones, *again.muscles][i].mesh.points)
            assert not any(passing(one.mesh.points, one.mesh.triangles, other.mesh.points, other.mesh.triangles) for other in bodies[:i])


def test_a_room_goes_round_its_wall_only():
    mesh = room(0.03, 0.004, 2)
    turns = [winding(np.array([x, 0.0013, 0.0007]), mesh.points, mesh.triangles) for x in (0, 0.032, 0.04)]
    assert turns == pytest.approx([0, 1, 0], abs=1e-9)


def test_touching_is_not_passing():
    cube = box((1, 1, 1))
    for by, expected in (((2.0, 0.3, 0.1), False), ((2.0 - 1e-9, 0.3, 0.1), True), ((0.0, 0.0, 0.0), False)):
        assert bool(passing(cube.points, cube.triangles, cube.points + np.array(by), cube.triangles.copy())) == expected, by
    corners = np.array([[0.1, 0.2, 0.3]] * 4)
    assert sides(*(corners[k:k + 1] for k in range(4))).tolist() == [0]


@needs_program
def test_with_no_passage_nothing_passes(tmp_path):
    done, rows = stress(tmp_path / "out", "--scenes", "16")
    assert done.returncode == 0, done.stdout
    assert len(rows) == 16 and set(rows["verdict"]) == {"held"} and not list((tmp_path / "out").glob("0*"))


@needs_program
def test_without_it_the_judge_sees_what_passes(tmp_path):
    done, rows = stress(tmp_path / "out", "--only", str(FLUNG_SCENE), "--no-effect")
    assert done.returncode == 1 and rows["verdict"].tolist() == ["passed through"] and rows["triangles"][0] > 0
    assert f"again: tools/stress --seed 1 --only {FLUNG_SCENE}" in done.stdout
    assert (tmp_path / "out" / f"{FLUNG_SCENE:05d}" / "scene.toml").is_file()


@pytest.mark.weekly
@needs_program
def test_with_no_passage_nothing_passes_in_a_thousand_scenes(tmp_path):
    done, rows = stress(tmp_path / "out", "--scenes", "1000", "--seed", "2")
    assert done.returncode == 0, done.stdout
    assert set(rows["verdict"]) <= {"held", "told", "flew off"} and (rows["verdict"] == "held").mean() > 0.98
