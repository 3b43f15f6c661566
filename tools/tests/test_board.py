"""The board: what it says of each row, what is computed again, and the site."""

import copy
import re
from dataclasses import replace

import pandas as pd
import pytest

import board as board_tool
import fake_registry
from musclebench.board import site
from musclebench.board.bundle import Bundle, write_bundle
from musclebench.board.hard_cases import hard_cases
from musclebench.board.looks import looks_of
from musclebench.board.made import bundle_of
from musclebench.board.recompute import Limits, recompute
from musclebench.board.standing import board_rows, machines_of
from musclebench.board.summary import as_summary
from musclebench.program.cli import Problem
from musclebench.program.registry import Registry, SceneEntry
from published_bundle import ANSWERS, MEASURED, OTHERS, PUBLISHED, QUESTIONS, made


@pytest.fixture(scope="module")
def published() -> Bundle:
    return bundle_of(PUBLISHED)


def measured_on(bundle: Bundle, date: str, cpu: str = "A") -> Bundle:
    return replace(bundle, header=bundle.header | {"measured": date, "machine": {"cpu": cpu, "cores": 2}})


# What the board says

def test_the_same_answers_are_verified_and_others_refuted(published):
    told, same, other = (made(published, contact_hash=answer) for answer in (ANSWERS, ANSWERS, OTHERS))
    commit = published.header["commit"]
    assert board_rows([told])["standing"].tolist() == ["claimed"]
    assert board_rows([told], [same.rows])["standing"].tolist() == ["verified"]
    refuted = board_rows([told], [other.rows], commit).iloc[0]
    assert refuted["standing"] == "refuted" and "not those" in refuted["why_not"]
    assert board_rows([told], [other.rows], "another")["standing"].tolist() == ["claimed, other version"]
    asked_else = made(published, contact_hash=OTHERS, queries_hash="f" * 16)
    assert board_rows([told], [asked_else.rows], commit)["standing"].tolist() == ["claimed"]
    assert board_rows([made(published, contact_hash="")])["standing"].tolist() == ["claimed, no hash"]


@pytest.mark.parametrize(("claim", "words"), [
    ({"offset_mm": 0.5}, "offset_mm is 0 here, not 0.5"), ({"missed_mm": 0.05}, "missed_mm is 0"), ({"declared_missed_mm": 9.0}, "declared_missed_mm is 0.1"),
    ({"configuration": "bvh 512"}, "its parameters are those of 'bvh'"), ({"true_contacts": 9}, "true_contacts is 5000 here"),
])
def test_errors_and_names_of_verified_rows_were_computed_here(published, claim, words):
    here, bundle = made(published, offset_mm=0.0, spoken="exact tree").rows, made(published, **({"offset_mm": 0.0} | claim))
    for commit, standing in ((published.header["commit"], "refuted"), ("another", "claimed, other version")):
        row = board_rows([bundle], [here], commit).iloc[0]
        assert row["standing"] == standing and words in row["why_not"] and row["division"] == "open"


def test_what_is_computed_here_takes_the_place_of_what_is_claimed(published):
    """Empty cells hide nothing, and words are this program's."""
    here = made(published, missed_mm=0.2, spoken="exact tree").rows
    row = board_rows([made(published, missed_mm=None, declared_missed_mm=None, spoken="splendid")], [here]).iloc[0]
    assert (row["standing"], row["bound"], row["spoken"], row["why_not"]) == ("verified", "broken", "exact tree", "errs by more than it declares")


def test_other_parameters_are_other_answers(published):
    ours, theirs = made(published, parameters='{"cells": "16"}'), made(published, contact_hash=OTHERS)
    rows = board_rows([ours, theirs], [ours.rows], published.header["commit"])
    assert rows["standing"].tolist() == ["verified", "claimed"]


@pytest.mark.parametrize(("values", "bound", "division"), [
    ({}, "held", "closed"), ({"missed_mm": 0.2}, "broken", "open"), ({"false_mm": 0.2}, "broken", "open"),
    ({"declared_missed_mm": None}, "none declared", "open"),
    ({"missed_mm": None}, "not judged", "open"), ({"true_contacts": 99}, "not judged", "open"), ({"stride": 4}, "held", "open"),
    ({"declared_missed_mm": 1e4}, "held", "open"), ({"missed_mm": None, "false_mm": 50}, "broken", "open"), ({"scene": "lhdl/mine"}, "held", "open"),
    ({"declared_false_mm": None, "missed_mm": 0.2}, "broken", "open"), ({"scene": "my.toml"}, "held", "open"),
])
def test_a_bound_is_the_backends_own_word(published, values, bound, division):
    bundle = made(published, **values)
    row = board_rows([bundle]).iloc[0]
    assert (row["bound"], row["division"]) == (bound, division) and (row["why_not"] != "") == (bound == "broken")


def test_other_questions_are_grey_whatever_their_date(published):
    ours, strange = measured_on(made(published), "2026-01-01"), measured_on(made(published, queries_hash="f" * 16), "2026-02-01", "B")
    assert board_rows([ours, strange])["is_old"].tolist() == [False, True] and board_rows([strange, ours])["is_old"].tolist() == [False, True]
    assert board_rows([strange, ours], [ours.rows])["is_old"].tolist() == [True, False]
    before = Bundle(published.header, published.rows.assign(queries_hash="", contact_hash=""))
    assert not board_rows([ours, before])["is_old"].any()  # of before there were hashes: nobody knows what was asked
    rows = board_rows([ours, strange])
    assert rows["division"].tolist() == ["closed", "open"] and rows["why_not"].tolist() == ["", "it answers other questions than the scene asks now"]


def test_a_bundle_changes_no_row_of_another(published):
    """Also not one of the same name and machine."""
    rows = board_rows([made(published), made(published, time_ms=1e-4)])
    assert rows["machine"].nunique() == 2 and rows["why_not"].tolist() == ["", ""]
    assert machines_of([published, published, published])[2] == f"{published.machine} (3)"


def test_threads_are_another_question(published):
    assert "several threads" in board_rows([made(published, threads=2)])["why_not"][0]


def test_what_did_not_answer_and_the_control_can_not_win(published):
    assert board_rows([made(published, status="timeout", detail="too long")])["why_not"].tolist() == ["timeout: too long"]
    assert board_rows([made(published, verdict="wrong: 9 % missed")])["why_not"].tolist() == ["wrong: 9 % missed"]


# What is computed here

PROGRAM = """#!/usr/bin/env python3
import json, pathlib, sys
words = sys.argv[1:]
out = pathlib.Path(words[words.index("--out") + 1])
if words[0] == "record":
    out.write_text("steps")
else:
    out.mkdir(exist_ok=True)
    (out / "run.json").write_text(json.dumps({"queries_hash": "%s", "contact_hash": "%s", "accuracy": {"max_missed_depth_m": 1e-3}}))
    (out.parent.parent / "asked.txt").open("a").write(" ".join(words) + "\\n")
"""


def test_a_stranger_sets_no_paths(published, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    program = tmp_path / "program"
    program.write_text(PROGRAM % (QUESTIONS, ANSWERS))
    program.chmod(0o755)
    registry = registry_of()
    bundles = [made(published, name) for name in ("bvh", "sdf 32", "fcl OBB")]
    strange = made(published, "sdf 32", parameters='{"structures": "/etc"}', configuration="sdf strange")
    elsewhere = made(published, scene="my.toml")
    found = recompute([*bundles, strange, elsewhere], program, registry, None, Limits(10.0, 60.0), lambda text: None)
    assert set(found["configuration"]) == {"bvh", "sdf 32"} and set(found["contact_hash"]) == {ANSWERS}
    asked, told = (tmp_path / "asked.txt").read_text(), capsys.readouterr().err
    assert "/etc" not in asked and "--param cells=32" in asked
    assert "structures is not one that a stranger may set" in told and "fcl is not built here" in told and "my.toml is not a scene" in told
    assert set(found["missed_mm"]) == {1.0} and found["offset_mm"].isna().all()


def registry_of() -> Registry:
    """Of a program without FCL."""
    known = fake_registry.registry()
    return replace(known, backends=tuple(one for one in known.backends if one.name != "fcl"), scenes=(SceneEntry("synthetic/iliacus"),))


def test_an_offset_at_the_end_of_the_search_is_none(published):
    def told(**values):
        return board_rows([made(published, offset_mm=5.0, sites=200, ridge_mm=7.0, flat_mm=4.0, **values)]).iloc[0]

    known, few, many = told(open_sites=0), told(open_sites=2), told(open_sites=3)
    assert known[["offset_mm", "ridge_mm", "flat_mm"]].tolist() == [5.0, 7.0, 4.0] and not known["is_open"]
    assert few[["offset_mm", "flat_mm"]].tolist() == [5.0, 4.0] and pd.isna(few["ridge_mm"]) and not few["is_open"]
    assert many[["offset_mm", "ridge_mm", "flat_mm"]].isna().all() and many["is_open"]


# The site

@pytest.fixture
def no_script(monkeypatch):
    monkeypatch.setattr(site, "page_script", lambda entry: "// none")


def test_the_projects_own_board_is_whole(published, tmp_path, no_script):
    hard = hard_cases(MEASURED / "hard-synthetic")
    rows = site.write_site([published], hard, tmp_path / "board")
    names = {path.name for path in (tmp_path / "board").iterdir()}
    assert len(rows) == len(published.rows) and names > {"index.html", "board.js", "style.css", "board.csv", "board.json"}
    assert (tmp_path / "board" / "backends" / "bvh.html").is_file() and len(list((tmp_path / "board" / "hard").iterdir())) == len(hard) > 50
    assert {path.stem for path in (tmp_path / "board" / "libraries").iterdir()} >= {"FCL-0.7.0", "VTK-9.1.0"}
    pages = {path: path.read_text() for path in (tmp_path / "board").rglob("*.html")}
    for path, text in pages.items():
        assert not re.search(r'(?:src|href)="(?:https?:)?//', text), path
        for link in re.findall(r'href="([^"#]+)"', text):
            assert (path.parent / link).resolve().is_file(), f"{path}: {link}"
    assert sum(path.stat().st_size for path in (tmp_path / "board").rglob("*") if path.is_file()) < site.LARGEST_BYTES


def test_what_a_stranger_writes_stays_text(published, tmp_path, no_script):
    bundle = made(published, spoken="<script>alert(1)</script>", detail='"><img src=x onerror=alert(1)>', status="suspect")
    header = copy.deepcopy(bundle.header)
    header["backends"]["mine"] = {"implementation": "<b>mine</b>, MIT", "source": "javascript:alert(1)", "licence": "MIT",
                                  "title": "'><script>", "colour": "red;}"}
    site.write_site([replace(bundle, header=header, rows=bundle.rows.assign(backend="mine"))], [], tmp_path / "board")
    for path in (tmp_path / "board").rglob("*.html"):
        text = path.read_text()
        assert "<script>alert" not in text and "<img" not in text and "<b>mine" not in text and "red;}" not in text, path
        assert 'href="javascript' not in text


def test_a_pull_request_shows_what_it_brings_as_plain_words(published):
    bundle = made(published, spoken="[free](https://x) <b> a|b", offset_mm=0.25, status="failed", detail="@all\n# look")
    text = as_summary(board_rows([bundle, published]), machines_of([bundle, published])[:1])
    heading, _, told, _, titles, _, row = text.strip().split("\n")
    assert heading.startswith("### accuracy\\-synthetic\\: ") and heading.endswith("12.2.0") and told.startswith("1 settings: 1 claimed.")
    cells = re.split(r"(?<!\\) *\| *", row.strip("| "))
    assert len(cells) == titles.count(" | ") + 1 and "0.2500" in cells and "claimed" in cells
    assert cells[1] == r"\[free\]\(https\://x\) \<b\> a\|b" and cells[-1] == r"failed\: \@all \# look"


def test_a_strange_backend_has_a_colour_of_its_own(published):
    header = copy.deepcopy(published.header)
    for name, colour in (("mine", "#56B4E9"), ("yours", "#56B4E9"), ("theirs", "red")):
        header["backends"][name] = {"implementation": "x 1, MIT", "source": "x 1", "licence": "MIT", "colour": colour}
    looks = looks_of([replace(published, header=header)])
    colours = {look["colour"].upper() for look in looks.values()}
    assert len(colours) == len(looks) and all(re.fullmatch("#[0-9A-F]{6}", colour) for colour in colours)


def test_names_that_look_alike_have_pages_of_their_own():
    assert site._paths("scenes", ["a/b", "a b", "a-b", "..", "A-B"]) == {
        "a/b": "scenes/a-b.html", "a b": "scenes/a-b.2.html", "a-b": "scenes/a-b.3.html", "..": "scenes/unnamed.html", "A-B": "scenes/A-B.4.html"}


def test_only_a_board_is_replaced(published, tmp_path, no_script, monkeypatch):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(Problem, match="is no board alone"):
        site.write_site([published], [], tmp_path / "mine")
    site.write_site([published], [], tmp_path / "board")
    (tmp_path / "board" / "scenes" / "mine.html").write_text("mine")
    with pytest.raises(Problem, match="scenes/mine.html is none of its files"):
        site.write_site([published], [], tmp_path / "board")
    (tmp_path / "board" / "scenes" / "mine.html").unlink()
    site.write_site([made(published)], [], tmp_path / "board")
    assert not (tmp_path / "board" / "backends" / "vtk.html").exists()
    monkeypatch.setattr(site, "LARGEST_BYTES", 1000)
    with pytest.raises(Problem, match="more than"):
        site.write_site([published], [], tmp_path / "board")
    assert (tmp_path / "board" / "index.html").is_file() and (tmp_path / "mine" / "notes.txt").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"mine", "board"}


# The tool

def test_the_board_takes_folders_and_tells_what_is_refuted(published, tmp_path, no_script, monkeypatch, capsys):
    for name in ("bundles", "none", "ours", "ours/raw"):
        (tmp_path / name).mkdir()
    write_bundle(made(published), tmp_path / "bundles" / "theirs.zip")
    words = [str(PUBLISHED), str(tmp_path / "bundles"), str(tmp_path / "none"), "--out", str(tmp_path / "board")]
    assert board_tool.main(words) == 0 and f"{len(published.rows) + 1} settings" in capsys.readouterr().out
    of_folder = board_tool.bundle_of
    monkeypatch.setattr(board_tool, "bundle_of", lambda path: made(published, contact_hash=OTHERS) if path == tmp_path / "ours" else of_folder(path))
    (tmp_path / "ours" / "study.csv").write_text("")
    assert board_tool.main([*words, "--recomputed", str(tmp_path / "ours")]) == board_tool.CODE_REFUTED
    told = capsys.readouterr()
    assert told.err == "refuted: bvh on synthetic/iliacus, of accuracy-synthetic: its answers are not those that it gives here\n" and "1 refuted" in told.out
    asked = []
    monkeypatch.setattr(board_tool, "recompute", lambda bundles, *rest: asked.append(len(bundles)) or published.rows.head(0))
    monkeypatch.setattr(board_tool, "read_registry", lambda program: fake_registry.registry())
    summary = tmp_path / "summary.md"
    for which, count in (([], 2), ([str(tmp_path / "bundles" / "theirs.zip")], 1)):
        assert board_tool.main([*words, "--musclebench", "/bin/true", "--summary", str(summary), "--recompute", *which]) == 0 and asked.pop() == count
    assert summary.read_text().count("### accuracy") == 3 and "| synthetic/iliacus | exact tree |" in summary.read_text()
    for wrong in ([str(tmp_path / "none")], [*words, "--recompute", str(tmp_path / "nothing.zip")],
                  [*words, "--summary", str(tmp_path / "nowhere" / "summary.md")],
                  [*words, "--recomputed", str(tmp_path / "bundles" / "theirs.zip")], [str(tmp_path / "nothing")]):
        assert board_tool.main([*wrong, "--out", str(tmp_path / "other")]) == 2 and len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "other").exists()
