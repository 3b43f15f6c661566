"""Experiment files: what is multiplied, what a wrong one is told, and how cases are ordered and split."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

import experiment
import fake_registry
from fake_sweep import swept
from musclebench.cases.case import Folders
from musclebench.experiments.expansion import filtered, in_shard
from musclebench.experiments.experiment_file import EXPERIMENT_KEYS, FOLDER, GROUP_KEYS, experiment_path, read_experiment
from musclebench.experiments.selection import backends_of
from musclebench.experiments.toml_lines import key_lines, line_of
from musclebench.program.cli import Problem
from musclebench.program.registry import Backend, Registry
from musclebench.experiments.record_case import RecordCase

FAKE = Path(__file__).resolve().parent / "fake_musclebench.py"
ROLES = fake_registry.roles()
ILIACUS = fake_registry.scene("synthetic/iliacus")
FOLDERS = Folders(Path("out"))
GOOD = f"""title = "A trial"
scenes = ["{{data}}/iliacus"]
repetitions = 3

[[cases]]
name = "small"
backends = ["{ROLES.unit}", "{ROLES.exact}"]

[[cases]]
name = "grid"
backends = ["{ROLES.unit}"]
threads = [1, 2]
[cases.parameters]
cells = [16, 32]
"""


@pytest.fixture
def written(tmp_path):
    def write(text: str) -> Path:
        path = tmp_path / "trial.toml"
        path.write_text(text)
        return path

    return write


def test_lists_are_multiplied(written):
    cases = swept(written(GOOD), ILIACUS)
    assert len(cases) == 3 * (2 + 4)
    firsts = {case.name for case in cases if case.repetition == 0}
    unit, exact = ROLES.unit, ROLES.exact
    assert firsts == {f"iliacus-small-{unit}-r0", f"iliacus-small-{exact}-r0", f"iliacus-grid-{unit}-cells=16-r0",
                      f"iliacus-grid-{unit}-cells=32-r0", f"iliacus-grid-{unit}-cells=16,threads=2-r0",
                      f"iliacus-grid-{unit}-cells=32,threads=2-r0"}
    words = next(case for case in cases if case.name.endswith("cells=32,threads=2-r1")).arguments(FOLDERS)
    assert words[words.index("--param") + 1] == "cells=32" and words[words.index("--threads") + 1] == "2"
    assert words[words.index("--repetition") + 1] == "1"


def test_repetitions_are_interleaved_in_a_random_order_of_their_seed(written):
    path = written(GOOD)
    cases = swept(path, ILIACUS)
    assert [case.repetition for case in cases] == [0] * 6 + [1] * 6 + [2] * 6
    orders = [[case.name[:-3] for case in cases if case.repetition == r] for r in range(3)]
    assert len({tuple(order) for order in orders}) == 3 and len({frozenset(order) for order in orders}) == 1
    assert swept(path, ILIACUS) == cases != swept(replace(read_experiment(path), seed=9), ILIACUS)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 50])
def test_parts_are_disjoint_and_make_the_whole(written, count):
    path = written(GOOD.replace('name = "small"', 'name = "small"\nmode = "replay"'))
    cases = swept(path, ILIACUS, fake_registry.scene("synthetic/gluteus_medius"))
    parts = [in_shard(cases, number, count) for number in range(1, count + 1)]
    swept_names = [case.name for part in parts for case in part if not isinstance(case, RecordCase)]
    assert sorted(swept_names) == sorted(case.name for case in cases if not isinstance(case, RecordCase))
    for part in parts:  # each has what it reads, and repetitions stay together
        assert {need for case in part for need in case.needs} == {case.name for case in part if isinstance(case, RecordCase)}
        repetitions = [case.name[:-3] for case in part if not isinstance(case, RecordCase)]
        assert all(repetitions.count(name) == 3 for name in repetitions)


def test_a_filter_keeps_what_the_kept_cases_need(written):
    cases = swept(written(GOOD.replace('name = "small"', 'name = "small"\nmode = "replay"')), ILIACUS)
    kept = filtered(cases, lambda name: f"small-{ROLES.exact}" in name)
    assert [case.name for case in kept] == ["iliacus", *(f"iliacus-small-{ROLES.exact}-r{r}" for r in range(3))]
    assert "iliacus" not in [case.name for case in filtered(cases, lambda name: "grid" in name)]


@pytest.mark.parametrize(("old", "new", "words"), [
    ('scenes =', 'scnees =', "line 2: key 'scnees': unknown key; did you mean 'scenes'?"),
    ('threads = [1, 2]', 'thraeds = [1, 2]', "line 12: key 'thraeds': unknown key; did you mean 'threads'?"),
    ('threads = [1, 2]', 'threads = [1, 0]', "line 12: key 'threads': 0 is no whole number of 1 or more"),
    ('threads = [1, 2]', 'threads = 2', "line 12: key 'threads': 2 is no list"),
    ('threads = [1, 2]', 'mode = "replays"', "line 12: key 'mode': 'replays'; did you mean 'replay'?"),
    ('threads = [1, 2]', 'named = "{scene}-{bakcend}"', "line 12: key 'named': '{bakcend}' stands for nothing; did you mean 'backend'?"),
    ('threads = [1, 2]', 'frames = [3, 4]', "cases that differ in 'frames' would have one name"),
    ('threads = [1, 2]', 'repetitions = true', "line 12: key 'repetitions': True is no whole number"),
    ('name = "grid"', 'name = "small"', "line 6: key 'name': 'small' is the name of two [[cases]]"),
    ('name = "grid"', '', "line 9: key 'name' is missing"),
    ('cells = [16, 32]', 'cells = [[16]]', "line 13: key 'parameters'"),
    ('cells = [16, 32]', 'cells = [16, 32', "not TOML"),
    ('title = "A trial"', '', "line 1: key 'title' is missing"),
])
def test_a_wrong_file_is_one_line_with_line_key_and_cure(written, capsys, old, new, words):
    path = written(GOOD.replace(old, new, 1))
    code = experiment.main([str(path), "--list-cases", "--musclebench", str(FAKE)])
    errors = capsys.readouterr().err
    assert code == 2 and errors.count("\n") == 1, errors
    assert errors.startswith(f"experiment: {path}: ") and words in errors


@pytest.mark.parametrize(("old", "new", "words"), [
    ("cells =", "clels =", "'clels' is none of"),
    (f'backends = ["{ROLES.unit}", ', 'backends = ["no_such", ', "no_such: not built; there are: "),
    ("/iliacus", "/ilaicus", "did you mean 'synthetic/iliacus'?"),
])
def test_what_only_the_program_knows_is_checked_before_anything_runs(written, tmp_path, capsys, old, new, words):
    path = written(GOOD.replace(old, new, 1))
    code = experiment.main([str(path), "--musclebench", str(FAKE), "--out", str(tmp_path / "out")])
    errors = capsys.readouterr().err
    assert code == 2 and errors.count("\n") == 1 and words in errors and not (tmp_path / "out").exists()


def test_an_unknown_experiment_is_told_its_neighbour():
    with pytest.raises(Problem, match="did you mean 'paper'"):
        experiment_path("papper")


def test_scenes_that_are_asked_take_the_cases_that_name_them(written):
    text = 'title = "A trial"\n' + "".join(f'[[cases]]\nname = "{name}"\nscenes = {scenes}\n' for name, scenes in (
        ("both", '["a", "b"]'), ("one", '["b"]'), ("rest", '"asked"')))
    file = read_experiment(written(text))
    kept = {words: {group.name: group.scenes for group in file.on(words).groups} for words in (("b",), ("a", "c"))}
    assert kept == {("b",): {"both": ("b",), "one": ("b",)}, ("a", "c"): {"both": ("a",), "rest": ("c",)}}
    assert read_experiment(written(GOOD)).on(("c",)).scenes == ("c",)


def test_backends_are_fast_or_slow(written):
    def names(word: str) -> set[str]:
        return {case.configuration.backend for case in swept(written(GOOD.replace(f'["{ROLES.unit}", "{ROLES.exact}"]', word)), ILIACUS)
                if case.group.name == "small"}
    assert names('"slow"') and names('"slow"').isdisjoint(names('"fast"')) and names('"slow"') | names('"fast"') == names('"all"')
    assert not names('"external"')  # the stand-in has no library


def test_libraries_of_others_are_a_group_of_their_own():
    plain, library = Backend("plain", "plain"), Backend("library", "library", study={"external": True})
    registry = Registry((plain, library))
    group, file = SimpleNamespace(name="g", backends="external"), SimpleNamespace(path="x")
    assert backends_of(group, file, registry) == [library]
    group.backends = "fast"
    assert backends_of(group, file, registry) == [plain]


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_the_files_of_the_project_expand_to_cases_of_different_names(path):
    cases = swept(path)
    assert len(cases) > 5 and len({case.name for case in cases}) == len(cases)
    assert all(case.guessed_seconds > 0 for case in cases)


def test_every_key_is_told_in_the_folder_of_the_experiments():
    told = (FOLDER / "README.md").read_text()
    cells = {word for line in told.splitlines() if line.startswith("| `") for word in re.findall(r"`(\w+)`", line.split("|")[1])}
    assert cells == {*EXPERIMENT_KEYS, *GROUP_KEYS} - {"cases"}


def test_the_example_of_the_folder_is_an_experiment(written):
    example = (FOLDER / "README.md").read_text().split("```toml\n")[1].split("```")[0]
    assert {case.group.name for case in swept(written(example)) if not isinstance(case, RecordCase)} == {"grids", "threads"}


def test_lines_of_keys_are_found_in_the_table_they_are_in():
    lines = key_lines('a = 1\n\n[[cases]]\nname = "x"\n[cases.vary.rule]\nnone = []\n[[cases]]\n"quoted key" = 2\nname = "y"\n')
    assert lines[("a",)] == 1 and lines[("cases", 0, "name")] == 4 and lines[("cases", 1, "name")] == 9
    assert lines[("cases", 0, "vary", "rule", "none")] == 6 and lines[("cases", 1, "quoted key")] == 8
    assert line_of(lines, ("cases", 1, "absent")) == 7 and line_of(lines, ("no_table", "no_key")) == 1


CHOSEN = """title = "A trial"

[[cases]]
name = "chosen"
"""


def chosen(tmp_path, lines: str) -> list:
    (tmp_path / "chosen.toml").write_text(CHOSEN + lines)
    return swept(tmp_path / "chosen.toml", fake_registry.scene("synthetic/iliacus"))


def test_a_set_of_choices_goes_by_the_name_that_its_study_gives_it(tmp_path):
    case, = chosen(tmp_path, 'backends = ["fcl"]\nconfigurations = "as advised"\n')
    assert dict(case.configuration.parameters) == {"query": "node_collide", "bounding_volume": "OBB", "node_radius_m": 0.002}
    with pytest.raises(Problem, match=r"configurations: 'as adviced' is no set of choices of fcl; there are: default, .*as advised"):
        chosen(tmp_path, 'backends = ["fcl"]\nconfigurations = "as adviced"\n')


def test_what_is_not_built_is_left_out_where_the_file_says_so(tmp_path):
    case, = chosen(tmp_path, 'backends = ["sdf", "no_such"]\nif_built = true\n')
    assert case.configuration.backend == "sdf"
    with pytest.raises(Problem, match="no_such: not built"):
        chosen(tmp_path, 'backends = ["sdf", "no_such"]\n')
