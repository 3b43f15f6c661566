"""The example that the README prints runs as it is printed."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from few_cases import run_few
from program import PROGRAM, call, needs_program

PROJECT = Path(__file__).resolve().parents[2]
KNEE = PROJECT / "datasets" / "examples" / "knee.py"
README = (PROJECT / "README.md").read_text()
SCENES = (PROJECT / "datasets" / "README.md").read_text()


@pytest.fixture(scope="module")
def knee(tmp_path_factory) -> Path:
    """The folder that the README's command leaves, in the folder where it was called."""
    where = tmp_path_factory.mktemp("example")
    subprocess.run([sys.executable, str(KNEE), "my_knee"], cwd=where, check=True, capture_output=True)
    return where


def test_three_formats_and_the_scene_are_written(knee):
    assert {path.name for path in (knee / "my_knee").iterdir()} == {
        "tibia.ply", "femur.obj", "popliteus.stl", "my_knee.toml"}


def test_the_scene_that_is_printed_is_the_one_that_is_written(knee):
    printed = tomllib.loads(re.search(r"```toml\n(.*?)```", SCENES, re.DOTALL).group(1))
    made = tomllib.loads((knee / "my_knee" / "my_knee.toml").read_text())
    assert printed == made


def test_the_meshes_are_closed_and_look_outwards():
    """In the STL file each corner stands for itself: equal positions are what joins the triangles."""
    sys.path.insert(0, str(KNEE.parent))
    try:
        import knee as example
    finally:
        sys.path.remove(str(KNEE.parent))
    for vertices, triangles in (*example.bone_meshes(), example.muscle_mesh()):
        edges = {}
        for a, b, c in triangles:
            for edge in ((a, b), (b, c), (c, a)):
                edges[edge] = edges.get(edge, 0) + 1
        assert all(count == 1 and edges.get((b, a)) == 1 for (a, b), count in edges.items())
        a, b, c = (vertices[triangles[:, i]] for i in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0


@needs_program
def test_the_readmes_commands_run_as_they_are_printed(knee):
    """check and run; advise takes minutes."""
    lines = [line.partition("#")[0].split() for line in README.splitlines()
             if line.startswith("build/release/bench/musclebench ")]
    wanted = [line[1:] for line in lines if line[1] in ("check", "run")]
    assert len(wanted) == 3
    for arguments in wanted:
        done = call(*arguments, cwd=knee)
        assert done.returncode == 0, f"{PROGRAM} {' '.join(arguments)}: {done.stderr}"
    assert json.loads((knee / "shin" / "run.json").read_text())["status"] == "ok"
    record = json.loads((knee / "my_knee" / "sdf" / "run.json").read_text())
    assert record["status"] == "ok" and record["muscle"]["nodes"] == 962
    assert all(attachment["nodes"] >= 10 for attachment in record["attachments"])
    assert [bone["name"] for bone in record["bones"]] == ["tibia", "femur"]


@pytest.mark.long
@needs_program
def test_a_study_of_the_example_gives_tables_and_figures(knee, tmp_path):
    """Of a few frames and cases."""
    printed = ["--scene", "my_knee/my_knee.toml", "--quick"]
    done = run_few(tmp_path / "out", *printed, "--frames-limit", "4", cwd=knee)
    assert done.returncode == 0, done.stderr
    written = {path.name for path in (tmp_path / "out").rglob("*")}
    assert {"price_list.csv", "pareto_replay.png"} <= written
