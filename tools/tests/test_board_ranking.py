"""The ranking of the board, as the browser computes it."""

import json
import shutil
import subprocess

import pytest

from published_bundle import PROJECT

RANK = PROJECT / "tools" / "page" / "rank.js"


def ranked(rows: list[dict], **state) -> dict:
    if not shutil.which("node"):
        pytest.skip("node is missing (tools/setup nodejs): the ranking is not tried")
    asked = {"scene": "s", "machine": "m", "error": "surface", "contacts": "all", "division": "all", "at": 0.1} | state
    script = (f"import {{ asked, ranking, frontOf, columnOf }} from 'file://{RANK}';\n"
              f"const rows = asked({json.dumps(rows)}, {json.dumps(asked)});\nconst {{ ranked, unable }} = ranking(rows, {json.dumps(asked)});\n"
              "console.log(JSON.stringify({ unable, column: columnOf(" + json.dumps(asked) + "), front: [...frontOf(rows)].map((row) => row.configuration),\n"
              "  ranked: ranked.map((row) => ({ ...row, pays_after: row.pays_after === Infinity ? 'never' : row.pays_after })) }));\n")
    done = subprocess.run(["node", "--input-type=module", "-e", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def row(configuration: str, time_ms: float | None, offset_mm: float | None, **values) -> dict:
    return {"scene": "s", "machine": "m", "backend": configuration.split()[0], "configuration": configuration, "division": "open", "why_not": None,
            "time_ms": time_ms, "time_ms_low": time_ms and 0.9 * time_ms, "time_ms_high": time_ms and 1.1 * time_ms, "own_ms": None,
            "offset_mm": offset_mm, "build_s": 1.0, "ridge_mm": None, "arm_mm": None, "arm_floor_mm": None} | values


def test_the_cheapest_setting_that_holds_the_error_is_first():
    rows = [row("grid 64", 1.0, 0.09), row("grid 16", 0.5, 0.4), row("tree", 2.0, 0.0), row("grid 128", 1.5, 0.01), row("other", 0.1, 5.0),
            row("wrong", 0.01, 0.0, why_not="errs by more than it declares"), row("unknown", 0.01, None), row("late", None, None, why_not="timeout"),
            row("else", 0.1, 0.0, machine="another")]
    found = ranked(rows)
    assert [one["configuration"] for one in found["ranked"]] == ["grid 64", "tree"] and found["ranked"][1]["times"] == 2
    assert found["front"] == ["other", "grid 16", "grid 64", "grid 128", "tree"]
    why = {one["backend"]: (one["why"], one["error"]) for one in found["unable"]}
    assert why == {"other": ("its most accurate setting is off by", 5), "wrong": ("errs by more than it declares", None),
                   "unknown": ("this error of it was not measured", None), "late": ("timeout", None)}
    assert [one["configuration"] for one in ranked(rows, at=0.5)["ranked"]] == ["grid 16", "tree"]
    assert ranked(rows, division="closed")["ranked"] == []


def test_what_was_searched_in_vain_says_so():
    rows = [row("near", 1.0, 0.0), row("far", 0.5, None, is_open=1, arm_mm=None), row("mute", 0.5, None)]
    why = {one["backend"]: one["why"] for one in ranked(rows, at=100)["unable"]}
    assert why == {"far": "its surface is farther away than was searched", "mute": "this error of it was not measured"}
    assert {one["why"] for one in ranked(rows, error="arm")["unable"]} == {"this error of it was not measured"}


def test_all_scenes_stand_side_by_side():
    rows = [row("grid 64", 1.0, 0.09), row("tree", 2.0, 0.0), row("grid 64", 4.0, 0.5, scene="t"), row("tree", 3.0, 0.0, scene="t"),
            row("late", 30.0, 0.01, scene="t"), row("tree", 1.0, 0.0, scene="u", machine="n"), row("wrong", 0.1, 5.0), row("off", 0.1, 0.0)]
    state = {"machine": "m", "scene": "s", "error": "surface", "contacts": "all", "division": "all", "at": 0.1}
    script = (f"import {{ overScenes }} from 'file://{RANK}';\n"
              f"const found = overScenes({json.dumps(rows)}, {json.dumps(state)}, (name) => name !== 'off');\n"
              "console.log(JSON.stringify(found, (key, value) => (value === undefined ? 'absent' : value)));\n")
    if not shutil.which("node"):
        pytest.skip("node is missing (tools/setup nodejs): the ranking is not tried")
    found = json.loads(subprocess.run(["node", "--input-type=module", "-e", script], capture_output=True, text=True, check=True).stdout)
    assert found["scenes"] == [{"scene": "s", "machine": "m"}, {"scene": "t", "machine": "m"}, {"scene": "u", "machine": "n"}]
    lines = {line["backend"]: line["times"] for line in found["lines"]}
    assert list(lines) == ["tree", "grid", "late"]  # in three scenes, then the faster of those in one
    assert lines == {"tree": [2, 1, 1], "grid": [1, None, "absent"], "late": ["absent", 10, "absent"]}


def test_a_build_pays_after_so_many_frames():
    rows = [row("slow", 10.0, 0.0, build_s=0.1), row("fast", 1.0, 0.0, build_s=1.0), row("loser", 12.0, 0.0, build_s=2.0),
            row("unknown", 20.0, 0.0, build_s=None)]
    pays = {one["backend"]: one["pays_after"] for one in ranked(rows)["ranked"]}
    assert set(pays.values()) == {None}  # one of them may be ready sooner
    pays = {one["backend"]: one["pays_after"] for one in ranked(rows[:-1])["ranked"]}
    assert pays == {"slow": 0, "fast": 100, "loser": "never"}  # 0.9 s later, 9 ms a frame faster


def test_hard_contacts_and_other_errors_have_columns_and_times_of_their_own():
    rows = [row("grid", 1.0, 0.01, ridge_mm=0.5, own_ms=3.0, own_ms_low=2.0, own_ms_high=4.0, arm_mm=0.01, arm_floor_mm=0.2),
            row("tree", 2.0, 0.0, ridge_mm=0.0)]
    assert [one["backend"] for one in ranked(rows, contacts="ridge")["ranked"]] == ["tree"]
    arm = ranked(rows, error="arm", contacts="ridge", at=0.1)
    assert arm["ranked"] == [] and arm["column"] == "arm_mm"  # nobody is better than rounding
    assert [(one["backend"], one["time_ms"], one["error"]) for one in ranked(rows, error="arm", at=0.2)["ranked"]] == [("grid", 3.0, 0.2)]
    alone = [row("grid", 1.0, 0.01, own_ms=3.0, own_ms_low=2.0, own_ms_high=4.0, arm_mm=0.0)]
    assert ranked(alone, error="arm", at=1.0)["ranked"] == []  # nobody knows what rounding does


def test_times_whose_intervals_overlap_are_said_to():
    found = ranked([row("first", 1.0, 0.0), row("second", 1.1, 0.0), row("third", 3.0, 0.0)])["ranked"]
    assert [one["is_tied"] for one in found] == [False, True, False]
