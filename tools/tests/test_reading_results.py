"""The page about the results names what the program writes: no column that is none, and none left out."""

import json
import re
from pathlib import Path

import pytest

from program import call, needs_program

pytestmark = needs_program
PROJECT = Path(__file__).resolve().parent.parent.parent
PAGE = PROJECT / "reports" / "reading_results.md"


@pytest.fixture(scope="module")
def results() -> dict:
    return json.loads(call("list", "--json").stdout)["results"]


def columns_of(results: dict, kind: str) -> set[str]:
    return {column["name"] for column in results[kind]["columns"]}


def named_in_tables(text: str) -> set[str]:
    """Words in code in the first cell of a table's row; the last table is that of exit codes."""
    cells = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    return {word for cell in cells for word in re.findall(r"`([^`]+)`", cell) if not word.isdigit()}


def test_the_table_names_columns_of_a_run_only(results):
    assert named_in_tables(PAGE.read_text()) - columns_of(results, "run") == set()


@pytest.mark.parametrize("kind", ["run", "muscles", "pairs"])
def test_no_column_is_left_out(results, kind):
    words = set(re.findall(r"`([^`]+)`", PAGE.read_text()))
    assert columns_of(results, kind) - words - {"frame", "muscle"} == set()


def test_what_a_replay_tells_of_pairs_beside_what_it_tells_of_frames_is_named(results):
    words = set(re.findall(r"`([^`]+)`", PAGE.read_text()))
    own = columns_of(results, "replay_pairs") - columns_of(results, "replay")
    assert own and own - words == set()


def test_the_page_has_the_limits_of_the_program(results):
    rows = [line for line in PAGE.read_text().splitlines() if line.startswith("| limit: ")]
    told = [f"| limit: `{limit['name']}`: {limit['help']} | `{limit['limit']:g}` {limit['unit']}".rstrip() + f" | {limit['why']} |"
            for limit in results["limits"]]
    assert rows == told


def test_readme_names_columns_that_are_there(results):
    every = set().union(*(columns_of(results, kind) for kind in ("run", "replay", "replay_pairs", "probe", "muscles", "pairs")))
    units = ("_ns", "_m", "_m3", "_deg", "_bytes")
    named = {word for word in re.findall(r"`([a-z0-9_]+)`", (PROJECT / "README.md").read_text()) if word.endswith(units)}
    keys = {key["name"].split(".")[-1] for keys in results["run_json"].values() for key in keys}
    parameters = {"_m", "distance_m", "margin_m", "outline_m", "centre_m", "depth_m", "to_deg"}
    assert named - every - keys - parameters == set()
