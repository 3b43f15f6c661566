"""`musclebench hard`: the matrix of hard cases, as a user meets it."""

import json
import subprocess

import hard
import hard_reds
import pandas as pd
import pytest

from musclebench.hard.causes import known_to_break
from musclebench.hard.strips import worst_frame
from musclebench.publish.measured import source_of
from program import PROGRAM, call, find_lhdl, needs_program

pytestmark = needs_program
# Those of every build. What libraries break is published (reports/libraries.md): their code is not ours to mend. The exact tree
# and the field see what a change of the loop or of a distance does; the others take three times as long together.
FAST, SLOW = ("sdf", "bvh"), ("null", "voxel", "brute_force", "fcl")
# A second or two each: distances, signs, contact, passage, and two that break.
FEW = ("soundness", "inverted-normals", "thin-plate", "pinch", "muscle-on-muscle", "needle", "press-shut")


def options_of(backends):
    return [word for name in backends for word in ("--backend", name)]


def all_cells(folder, backends, cases=(), *options, seconds):
    """(process, folder) of these backends."""
    options = [*options, *(word for name in cases for word in ("--case", name))]
    data = ["--data", folder_of_data] if (folder_of_data := find_lhdl()) else []
    done = subprocess.run([PROGRAM, "hard", *options_of(backends), *data, "--out", folder, *options], capture_output=True, text=True, timeout=seconds,
                          check=False)
    return done, folder


@pytest.fixture(scope="module", params=[pytest.param((FAST, FEW), id="few"), pytest.param((FAST, ()), marks=pytest.mark.long, id="fast"),
                                        pytest.param((SLOW, ()), marks=pytest.mark.weekly, id="slow")])
def matrix(request, tmp_path_factory):
    """The short run, and its backends."""
    backends, cases = request.param
    done = all_cells(tmp_path_factory.mktemp("hard") / "out", backends, cases, seconds=1800)  # tests beside it share the cores
    return *done, backends


def check_known(done, folder):
    rows = pd.read_csv(folder / "matrix.csv", keep_default_na=False)
    broken = rows[rows.verdict == "breaks"]
    assert done.returncode == (1 if len(broken) else 0)
    # Without anatomical data, or where a busy machine would take too long, a cell or its later runs are left out.
    asked = hard_reds.sure_cells(hard_reds.rows_of(folder / "matrix.csv"))
    assert set(zip(broken.case, broken.backend)) & asked == known_to_break() & asked


def test_what_can_hold_does(matrix):
    check_known(*matrix[:2])


def test_no_figure_that_is_red_gets_worse_unseen(matrix):
    """Nor one of a cell that a status excuses. What is mended is taken out of the list: `python3 tools/tests/hard_reds.py
    FOLDER`."""
    _, folder, _ = matrix
    assert hard_reds.changes(hard_reds.rows_of(folder / "matrix.csv"), hard_reds.known_reds()) == []


def test_a_red_that_moves_is_a_line():
    def row(value, verdict="breaks", detail=""):
        return {"case": "pinch", "backend": "bvh", "verdict": verdict, "figure": "depth", "value": value, "bar": "1",
                "detail": detail}

    known = {("pinch", "bvh", "depth"): 2.0}
    assert hard_reds.changes([row("2.1")], known) == []
    assert hard_reds.changes([row("2.3")], known) == ["pinch, bvh, depth: 2.3, was 2"]
    assert hard_reds.changes([row("nan")], known) == ["pinch, bvh, depth: nan, was 2"]
    assert hard_reds.changes([row("0.9", "holds")], known) == ["pinch, bvh, depth: within its bar, was 2"]
    assert hard_reds.changes([row("2")], {}) == ["pinch, bvh, depth: 2, was within its bar"]
    assert hard_reds.changes([row("0.9", detail="a later run would take 9 s")], known) == []


@pytest.mark.weekly
def test_what_can_hold_does_in_the_long_run(tmp_path):
    check_known(*all_cells(tmp_path / "out", FAST + SLOW, (), "--all", seconds=8 * 3600))


def test_every_backend_has_a_cell_of_every_case(matrix):
    done, folder, asked = matrix
    rows = pd.read_csv(folder / "matrix.csv", keep_default_na=False)
    backends = ["loop" if name == "null" else name for name in asked]
    cells = rows.groupby("case").backend.unique()
    assert all(list(names) == backends for names in cells)
    assert (rows[rows.verdict == "not applicable"].detail.str.len() > 5).all()
    page = (folder / "matrix.md").read_text()
    for case in cells.index:
        assert f"## {case}" in page and case in done.stdout


def test_the_cases_are_told():
    done = call("hard", "--list", "--case", "pinch")
    assert done.returncode == 0 and "Bar:" in done.stdout and "Scene: hard/pinch" in done.stdout


@pytest.mark.parametrize(("arguments", "words"), [
    (["--case", "pinsh"], "did you mean 'pinch'?"),
    (["--backend", "bhv"], "did you mean 'bvh'?"),
    (["--param", "cells=9"], "--backend"),
    (["--backend", "sdf", "--param", "celsl=9"], "cells"),
    (["--seconds", "-1"], "--seconds"),
])
def test_bad_input_is_one_line(arguments, words):
    done = call("hard", *arguments)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and words in done.stderr


def test_a_parameter_of_the_users_is_tried():
    done = call("hard", "--backend", "sdf", "--param", "cells=4", "--case", "soundness", "--case", "thin-plate")
    assert "soundness" in done.stdout and done.returncode in (0, 1)


def test_what_takes_too_long_is_told_in_the_matrix_and_nowhere_else(tmp_path):
    done = call("hard", "--case", "long-run", "--backend", "brute_force", "--out", tmp_path)
    (row,) = pd.read_csv(tmp_path / "matrix.csv", keep_default_na=False).to_dict("records")
    assert done.returncode == 0 and done.stderr == "" and row["verdict"] == "not applicable"
    assert row["detail"].startswith("would take some ")


@pytest.mark.long
def test_the_matrix_and_the_strips_are_drawn(tmp_path):
    arguments = ["--musclebench", PROGRAM, "--out", str(tmp_path / "out"), "--case", "rest", "--case", "pinch",
                 "--case", "soundness", "--backend", "bvh", "--backend", "voxel"]
    assert hard.main(arguments) in (0, 1)
    names = {path.name for path in (tmp_path / "out/figures").iterdir()}
    assert {"matrix.png", "scenes.png"} <= names
    assert source_of(tmp_path / "out", "tools/hard").commit  # which tools/publish notes
    cells, cases = (pd.read_csv(tmp_path / "out/tables" / f"{name}.csv") for name in ("cells", "cases"))
    assert list(cases.case) == ["rest", "pinch", "soundness"] and len(cells) == 6 and cases.notna().iloc[:, :4].all(axis=None)
    frames = pd.DataFrame({"frame": [1, 2, 3], "max_depth_m": [0.0, 0.0, 0.0], "surface_depth_m": [0.0, 2.0, 1.0]})
    assert worst_frame(frames) == 2


def test_what_breaks_is_a_result_where_it_is_published(tmp_path, capsys):
    cell = ["--case", "step-size-unguarded", "--case", "soundness", "--backend", "null", "--backend", "bvh", "--no-pictures"]
    broken = tmp_path / "breaks"  # a program whose matrix has a cell that breaks, whatever is mended
    broken.write_text(f'#!/bin/sh\n{PROGRAM} "$@"\ncode=$?\n'
                      'case "$*" in *soundness*" --out "*) ;; *) exit $code ;; esac\n'
                      'for word; do [ "$last" = --out ] && sed -i s/,holds,/,breaks,/ "$word/matrix.csv"; last=$word; done\nexit 1\n')
    broken.chmod(0o755)
    arguments = ["--musclebench", str(broken), "--out", str(tmp_path / "out"), *cell]
    assert hard.main(arguments) == 1 and "BREAKS" in capsys.readouterr().out
    assert hard.main([*arguments, "--breaks-are-results"]) == 0
    assert "4 of 4 cases are complete already" in capsys.readouterr().out
    done = {path.parent.name: json.loads(path.read_text())["status"] for path in (tmp_path / "out/raw").glob("*/run.json")}
    assert done["soundness-bvh"] == "suspect" and len(done) == 4


def test_cells_run_one_by_one_are_the_matrix_of_the_program(tmp_path):
    cells = ["--case", "rest", "--case", "pinch", "--case", "soundness", "--backend", "bvh", "--backend", "voxel"]
    assert call("hard", "--out", tmp_path / "whole", *cells).returncode in (0, 1)
    assert hard.main(["--musclebench", PROGRAM, "--out", str(tmp_path / "out"), "--no-pictures", *cells]) in (0, 1)
    whole, joined = (pd.read_csv(tmp_path / name / "matrix.csv").drop(columns="seconds") for name in ("whole", "out"))
    assert whole.equals(joined)


def test_cells_of_another_program_are_told_with_the_matrix(tmp_path, capsys):
    arguments = ["--musclebench", PROGRAM, "--out", str(tmp_path / "out"), "--no-pictures", "--no-page", "--case", "pinch",
                 "--backend", "bvh", "--backend", "voxel"]
    assert hard.main(arguments) in (0, 1)
    assert "programs" not in capsys.readouterr().out
    sealed = tmp_path / "out" / "raw" / "pinch-bvh" / "case.json"
    sealed.write_text(json.dumps({**json.loads(sealed.read_text()), "binary_sha256": "0123456789 of another"}))
    assert hard.main([*arguments, "--keep-cases"]) in (0, 1)
    for text in (capsys.readouterr().out, (tmp_path / "out" / "matrix.md").read_text()):
        assert "Cases of 2 programs, whose times and answers may differ: " in text and "(binary 01234567)" in text


@pytest.mark.parametrize(("arguments", "words"), [(["--case", "pinsh"], "did you mean 'pinch'?"), (["--backend", "bhv"], "--backend bhv: not built")])
def test_bad_input_of_the_tool_is_one_line(tmp_path, capsys, arguments, words):
    assert hard.main(["--musclebench", PROGRAM, "--out", str(tmp_path / "out"), *arguments]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1 and words in errors and not (tmp_path / "out").exists()


def test_a_program_that_is_not_there_is_one_line(tmp_path, capsys):
    assert hard.main(["--musclebench", "/no/such", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


WRONG_SCENES = {  # what is known to be red, and why: a seed that holds is taken out of the list
    1031: "a margin of 0.18 m, larger than the scene, throws nodes",
    1043: "a volume that is blown up a hundredfold throws nodes",
}


@pytest.mark.parametrize(("first", "count"), [(1000, 12), pytest.param(1012, 15, marks=pytest.mark.weekly),
                                              pytest.param(1028, 22, marks=pytest.mark.weekly)])
def test_random_scenes_break_nothing_that_is_not_known(tmp_path, first, count):
    """Seeds of which one takes minutes to be made small are left out."""
    done = call("hard", "--fuzz", str(count), "--seed", str(first), *options_of(FAST + SLOW), "--out", tmp_path)
    wrong = {int(line.split()[1].rstrip(":")) for line in done.stdout.splitlines() if line.startswith("seed ")}
    assert wrong == {seed for seed in WRONG_SCENES if first <= seed < first + count}, done.stdout
    assert done.returncode == (1 if wrong else 0) and f"{count} random scenes from seed {first}" in done.stdout
    for seed in wrong:
        assert f"musclebench hard --fuzz 1 --seed {seed}" in done.stdout and (tmp_path / f"seed-{seed}" / "scene.toml").exists()
