"""tools/safe-step: the search, and the table of a small scene."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest

import safe_step
from musclebench.program.out_folder import LOCK_NAME, claimed
from musclebench.safe_step.search import RATIO, Limits, largest_safe
from musclebench.safe_step.trials import stayed_right
from program import PROGRAM, call, complaint, needs_program


@pytest.mark.parametrize("limit", [0.013, 0.9, 1.0, 7.3, 55.0])
@pytest.mark.parametrize("start", [0.01, 1.0, 99.0])
def test_the_search_ends_within_a_tenth_below_the_limit(limit, start):
    found = largest_safe(lambda step: step <= limit, start, Limits(0.01, 100))
    assert limit / RATIO <= found.largest <= limit < found.wrong_at <= limit * RATIO
    assert found.tries < 25


def test_what_is_always_right_or_always_wrong_is_said():
    always = largest_safe(lambda step: True, 1.0, Limits(0.01, 100))
    assert always.largest == 100 and always.wrong_at is None
    never = largest_safe(lambda step: False, 1.0, Limits(0.01, 100))
    assert never.largest is None and never.wrong_at == 0.01


@pytest.mark.parametrize(("tunnelled", "volume_error", "expected"), [
    (0, 0.05, True), (0, None, True), (1, 0.0, False), (0, 0.051, False),
])
def test_right_is_without_tunnelled_nodes_and_with_its_volume(tunnelled, volume_error, expected):
    assert stayed_right({"outcome": {"tunnelled_nodes": tunnelled, "max_volume_error": volume_error}}) is expected


@pytest.mark.long
@needs_program
def test_a_guard_allows_steps_as_long_as_none_at_least(tmp_path, capsys):
    code = safe_step.main(["hard/step_size", "--backend", "bvh", "--out", str(tmp_path / "out"), "--musclebench", PROGRAM])
    assert code == 0
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "1 of 4: bvh, project, no guard"
    assert told[3].startswith("4 of 4: bvh, backtrack, guard; about ") and told[3].endswith(" left")
    table = pd.read_csv(tmp_path / "out/safe_step.csv")
    assert list(table["guard"]) == ["no", "yes", "no", "yes"]
    projected = table[table.response == "project"].set_index("guard")
    assert 0 < projected["turn_deg"]["no"] <= projected["turn_deg"]["yes"]
    checked = call("check", "hard/step_size", "--backend", "bvh", "--safe-step", tmp_path / "out/safe_step.json", "--json")
    assert checked.returncode == 0, checked.stderr


@needs_program
def test_two_in_one_folder_are_refused_before_the_search(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(safe_step, "searched", lambda *_: pytest.fail("searched in another's folder"))
    with claimed(tmp_path / "out"):
        code = safe_step.main(["hard/step_size", "--out", str(tmp_path / "out"), "--musclebench", PROGRAM])
    errors = capsys.readouterr().err
    assert code == 2 and errors.count("\n") == 1 and "another run writes there" in errors
    assert [path.name for path in (tmp_path / "out").iterdir()] == [LOCK_NAME]


@needs_program
def test_bad_input_leaves_no_folder(tmp_path, capsys):
    assert safe_step.main(["hard/step_size", "--backend", "bhv", "--out", str(tmp_path / "out"), "--musclebench", PROGRAM]) == 2
    assert "--backend bhv" in capsys.readouterr().err and not (tmp_path / "out").exists()


def known_steps(folder: Path, **changes) -> Path:
    step = {"backend": "bvh", "response": "project", "guard": False, "turn_deg": 1e-5, "turn_wrong_deg": 2e-5,
            "time_step_s": 1.0, "time_step_wrong_s": None}
    guarded = {**step, "guard": True, "turn_deg": 90.0, "turn_wrong_deg": None}
    file = folder / "safe_step.json"
    file.write_text(json.dumps({"schema": 1, "scene": "hard/step_size", "steps": [step, guarded], **changes}))
    return file


@needs_program
def test_check_names_a_step_beyond_the_safe_one_and_what_mends_it(tmp_path):
    checked = json.loads(call("check", "hard/step_size", "--safe-step", known_steps(tmp_path), "--json").stdout)
    finding, = [one for one in checked["findings"] if one["id"] == "step_beyond_safe"]
    assert finding["where"] == "bvh with response project" and finding["figures"]["safe_turn_deg"] == 1e-5
    assert finding["figures"]["turn_deg"] > 1e-5 and finding["add"] == ["[effects.tunnelling_guard]"]
    other = call("check", "hard/step_size", "--backend", "sdf", "--safe-step", known_steps(tmp_path), "--json")
    assert "step_beyond_safe" not in other.stdout


@pytest.mark.long
@needs_program
def test_advise_leaves_out_what_goes_wrong_at_the_scenes_step(tmp_path):
    done = call("advise", "hard/step_size", "--depth-mm", "1", "--seconds", "20", "--safe-step", known_steps(tmp_path))
    assert re.search(r"bvh +not measured: bones turn by .* degrees a frame, and runs stay right up to 1e-05", done.stdout)


@needs_program
@pytest.mark.parametrize(("changes", "words"), [
    ({"schema": 2}, "schema 2"), ({"scene": "hard/rest"}, "hard/rest"), ({"steps": [{}]}, "tools/safe-step writes"),
])
def test_steps_that_are_of_something_else_are_refused(tmp_path, changes, words):
    done = call("check", "hard/step_size", "--safe-step", known_steps(tmp_path, **changes))
    assert done.returncode == 2 and complaint(done).count("\n") == 1 and words in done.stderr


@needs_program
@pytest.mark.parametrize(("arguments", "words"), [
    (["hard/step_sice"], "did you mean"), (["hard/step_size", "--backend", "bhv"], "--backend bhv"), ([], "scene"),
])
def test_bad_input_is_one_line(tmp_path, capsys, arguments, words):
    assert safe_step.main([*arguments, "--out", str(tmp_path / "out"), "--musclebench", PROGRAM]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1 and words in errors
