"""The leg that comes with the project: what it is made of, and that its scenes hold what they want."""

import json
import os
import tomllib
from pathlib import Path

import pytest

from program import call, needs_program

ANKLE = Path(__file__).resolve().parents[2] / "datasets" / "ankle"
SCENES = sorted(ANKLE.glob("scenes/*/*.toml"))
ALONE = [f"{path.parent.name}/{path.stem}" for path in SCENES if path.stem != "all"]
MUSCLES = {"soleus", "tibialis_anterior", "tibialis_posterior", "extensor_digitorum_longus", "extensor_hallucis_longus", "flexor_digitorum_longus",
           "flexor_hallucis_longus", "peroneus_longus"}


def test_it_is_small_and_names_its_authors():
    assert sum(path.stat().st_size for path in ANKLE.rglob("*") if path.is_file()) < 6e6
    about = json.loads((ANKLE / "import.json").read_text())
    assert about["licence"] == "CC BY 4.0" and len(about["cite"]) == 2 and not about["not_imported"]
    assert {one["name"] for one in about["meshes"] if one["kind"] == "muscle"} == MUSCLES
    assert all(one["error_mm"] <= 0.1 for one in about["meshes"]) and about["passing_triangles"] == 0
    for path in SCENES:
        scene = tomllib.loads(path.read_text())
        assert scene["source"]["licence"] == "CC BY 4.0" and scene["source"]["cite"] == about["cite"]
    for mesh in (ANKLE / "meshes").iterdir():
        assert b"licence CC BY 4.0" in mesh.read_bytes()[:400]


def test_each_joint_has_all_muscles_and_goes_as_far_as_told():
    ranges = {"ankle": (-15, 55), "subtalar": (-10, 10)}  # ankle: the scan has 35 degrees of plantarflexion
    for joint, (low, high) in ranges.items():
        assert {path.stem for path in SCENES if path.parent.name == joint} == MUSCLES | {"all"}
    for path in SCENES:
        motions = [bone["motion"] for bone in tomllib.loads(path.read_text())["bone"] if "motion" in bone]
        assert motions and {(one["from_deg"], one["to_deg"], one["course"]) for one in motions} == {(*ranges[path.parent.name], "rest_to_rest")}


@needs_program
@pytest.mark.parametrize("scene", [pytest.param(name, marks=() if name == "ankle/tibialis_posterior" else pytest.mark.long) for name in ALONE])
def test_a_muscle_alone_holds_what_its_scene_wants(tmp_path, scene):
    """From rest to both ends and back, without a file beside the program."""
    done = call("run", scene, "--backend", "bvh", "--out", tmp_path / "run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    run = json.loads((tmp_path / "run" / "run.json").read_text())
    assert run["status"] == "ok", run["status_detail"]
    outcome = run["outcome"]
    assert outcome["max_surface_depth_m"] < 1e-4 and outcome["bone_crossing_triangles"] == 0 and outcome["self_intersecting_triangles"] == 0
    assert outcome["max_volume_error"] < 0.01 and run["source"]["licence"] == "CC BY 4.0"


@needs_program
@pytest.mark.long
def test_all_muscles_hold_together_what_the_scene_wants(tmp_path):
    """Eight muscles in contact by nodes, edges and faces."""
    done = call("run", "ankle/all", "--backend", "bvh", "--out", tmp_path / "run", cwd=tmp_path, timeout=1800)
    assert done.returncode == 0, done.stderr
    run = json.loads((tmp_path / "run" / "run.json").read_text())
    assert run["status"] == "ok", run["status_detail"]
    outcome = run["outcome"]
    assert not any(outcome[f"{what}_crossing_triangles"] for what in ("bone", "muscle")) and not outcome["self_intersecting_triangles"]
    assert outcome["crossing_frames"] == 120 and outcome["max_surface_depth_m"] < 1e-4
    assert {one["name"]: one.get("activation", 1) for one in run["muscles"]}["soleus"] == 0


@needs_program
def test_a_missing_data_set_is_told(tmp_path):
    done = call("run", "ankle/soleus", "--backend", "bvh", "--out", tmp_path / "run", env={**os.environ, "MUSCLEBENCH_DATASETS": str(tmp_path)})
    assert done.returncode == 2 and "set MUSCLEBENCH_DATASETS to the folder datasets of the sources" in done.stderr
    assert not (tmp_path / "run").exists()
