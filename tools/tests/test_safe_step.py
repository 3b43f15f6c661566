"""tools/safe-step: the search, and the table of a small scene."""

import pandas as pd
import pytest

import safe_step
from musclebench.safe_step.search import RATIO, Limits, largest_safe
from program import PROGRAM, needs_program


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


@needs_program
def test_a_guard_allows_steps_as_long_as_none_at_least(tmp_path):
    code = safe_step.main(["hard/step_size", "--backend", "bvh", "--out", str(tmp_path / "out"), "--musclebench", PROGRAM])
    assert code == 0
    table = pd.read_csv(tmp_path / "out/safe_step.csv")
    assert list(table["guard"]) == ["no", "yes", "no", "yes"]
    projected = table[table.response == "project"].set_index("guard")
    assert 0 < projected["turn_deg"]["no"] <= projected["turn_deg"]["yes"]


@needs_program
@pytest.mark.parametrize(("arguments", "words"), [
    (["hard/step_sice"], "did you mean"), (["hard/step_size", "--backend", "bhv"], "--backend bhv"), ([], "scene"),
])
def test_bad_input_is_one_line(tmp_path, capsys, arguments, words):
    assert safe_step.main([*arguments, "--out", str(tmp_path / "out"), "--musclebench", PROGRAM]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1 and words in errors
