"""`musclebench advise` as a user meets it."""

import json
import re

import pytest

from ball_on_box import write_scene_of_balls
from program import call, needs_program

pytestmark = needs_program


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """So small that all backends are tried in a second."""
    return write_scene_of_balls(tmp_path_factory.mktemp("advise"))


@pytest.fixture(scope="module")
def advise(scene):
    return lambda *arguments: call("advise", scene, "--frames", 12, *arguments)


def test_it_names_what_holds_the_depth_with_the_reason_and_the_command(advise, scene):
    answer = advise("--depth-mm", "5", "--seconds", "120")
    assert answer.returncode == 0, answer.stderr
    chosen = [line for line in answer.stdout.splitlines() if line.startswith("*")]
    assert len(chosen) == 1
    name = re.match(r"\* (\S+(?: \S+=\S+)*)", chosen[0]).group(1)
    assert f"Take {name}: " in answer.stdout and "  promised: " in answer.stdout
    assert "  found, in its own run of all 12 frames: nodes at most " in answer.stdout
    assert f"musclebench run {scene} --backend {name.split()[0]}" in answer.stdout
    p99 = re.match(re.escape(f"* {name}") + r"\s+(\S+)", chosen[0]).group(1)
    assert p99 == "exact" or float(p99) <= 5


@pytest.mark.parametrize("depth_mm", ["-1", "0", "nan", "deep"])
def test_what_is_no_depth_is_refused(advise, depth_mm):
    answer = advise("--depth-mm", depth_mm)
    assert answer.returncode == 2
    assert len(answer.stderr.strip().splitlines()) == 1 and "--depth-mm" in answer.stderr


def test_json_is_the_same_advice_for_scripts(advise, scene):
    answer = advise("--depth-mm", "5", "--seconds", "60", "--json")
    assert answer.returncode == 0, answer.stderr
    advice = json.loads(answer.stdout)
    chosen = next(row for row in advice["measured"] if row["configuration"] == advice["chosen"])
    assert chosen["holds"] and chosen["error_m"] <= advice["wanted"]["m"] == 0.005
    assert chosen["collision_ns"]["low"] <= chosen["collision_ns"]["median"] <= chosen["collision_ns"]["high"]
    assert advice["command"].startswith(f"musclebench run {scene} --backend {chosen['backend']}")
    assert all(row["promises"] == (row["error_m"] <= 0.005) for row in advice["measured"])
    assert chosen["trial"]["frames"] == 12 and chosen["trial"]["node_depth_m"] <= 0.005
    assert not any(row["holds"] for row in advice["measured"] if row["trial"] is None)
    assert advice["frames"] == {"asked": 12, "all": 12} and advice["reasons"]


@pytest.mark.long
def test_what_is_exact_holds_any_depth():
    """Where nothing overlaps at rest, as in the scene of balls."""
    answer = call("advise", "synthetic/adductor_brevis", "--frames", 12, "--depth-mm", "1e-30", "--seconds", "60", "--json")
    advice = json.loads(answer.stdout)
    assert answer.returncode == 0 and advice["chosen"] == advice["best"]
    held = [row for row in advice["measured"] if row["holds"]]  # others were run to be measured, and not judged
    assert [(row["configuration"], row["trial"]["node_depth_m"]) for row in held] == [(advice["chosen"], 0)]


def test_a_time_that_ends_before_the_exact_run_says_what_is_unknown(advise):
    answer = advise("--depth-mm", "1", "--seconds", "0.000001")
    assert answer.returncode == 5 and not answer.stdout
    assert re.search(r"--seconds: .* of the exact run .* before any measurement; give about [1-9]\d* s", answer.stderr), answer.stderr


@pytest.mark.weekly
@pytest.mark.parametrize("muscle", ["adductor_brevis", "gluteus_maximus", "gluteus_medius", "iliacus"])
def test_what_it_recommends_on_real_muscles_holds_in_a_run(muscle, lhdl_folder, tmp_path):
    answer = call("advise", f"lhdl/{muscle}", "--preset", "standard", "--data", lhdl_folder, "--depth-mm", "0.1", "--seconds",
                  "600", "--json", timeout=3000)
    advice = json.loads(answer.stdout)
    if advice["chosen"] is None:  # then every one that promised to hold was run, and says why it does not
        assert answer.returncode == 1 and all(row["refusal"] for row in advice["measured"] if row["promises"])
        return
    run = call(*advice["command"].replace("'", "").split()[1:], "--out", tmp_path / "run", timeout=3000)
    assert run.returncode == 0, run.stderr
    outcome = json.loads((tmp_path / "run" / "run.json").read_text())["outcome"]
    assert outcome["max_depth_m"] <= 1e-4 and outcome["tunnelled_nodes"] == 0
