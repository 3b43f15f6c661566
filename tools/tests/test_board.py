"""Bundles and the board: what comes back, what is refused, and what the board says of each row."""

import copy
import hashlib
import json
import re
import shutil
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

import fake_registry
from musclebench.board import site
from musclebench.board.bundle import FORMAT, HEADER, LONG_AGO, ROWS, SHAPES, Bundle, bundle_bytes, write_bundle
from musclebench.board.columns import COLUMNS, NAMES
from musclebench.board.hard_cases import hard_cases
from musclebench.board.made import bundle_of
from musclebench.board.reading import read_bundle
from musclebench.board.recompute import recompute
from musclebench.board.standing import board_rows
from musclebench.program.cli import Problem
from musclebench.program.registry import Registry, SceneEntry
from musclebench.publish.measured import SOURCE

PROJECT = Path(__file__).resolve().parents[2]
MEASURED = PROJECT / "reports" / "measured"
PUBLISHED = MEASURED / "accuracy-synthetic"
QUESTIONS, ANSWERS, OTHERS = "0123456789abcdef", "00000000000000aa", "00000000000000bb"
RANK = PROJECT / "tools" / "page" / "rank.js"


@pytest.fixture(scope="module")
def published() -> Bundle:
    return bundle_of(PUBLISHED)


def made(published: Bundle, setting: str = "bvh", **values) -> Bundle:
    """Of one setting that answered and held what it declares."""
    rows = published.rows[published.rows["configuration"] == setting].copy()
    told = {"queries_hash": QUESTIONS, "contact_hash": ANSWERS, "missed_mm": 0.0, "false_mm": 0.0, "declared_missed_mm": 0.1,
            "declared_false_mm": 0.1, "stride": 1} | values
    for name, value in told.items():
        rows[name] = value
    return replace(published, rows=rows)


def measured_on(bundle: Bundle, date: str, cpu: str = "A") -> Bundle:
    return replace(bundle, header=bundle.header | {"measured": date, "machine": {"cpu": cpu, "cores": 2}})


# What comes back

def test_a_published_study_comes_back_from_its_bundle(published, tmp_path):
    write_bundle(published, tmp_path / "a.zip")
    back = read_bundle(tmp_path / "a.zip")
    assert len(back.rows) > 50 and back.machine == published.machine
    for column in COLUMNS:
        before, after = published.rows[column.name].reset_index(drop=True), back.rows[column.name]
        if column.kind in ("number", "count"):
            pd.testing.assert_series_equal(before.astype(float), after.astype(float), check_names=False, rtol=1e-12)
        else:
            assert before.fillna("").tolist() == after.tolist(), column.name


def test_the_figures_are_those_of_the_study(published):
    study = pd.read_csv(PUBLISHED / "study.csv", keep_default_na=False, na_values=[""])
    asked, driving = (study[(study["mode"] == mode) & (study["configuration"] == "sdf 64")].iloc[0] for mode in ("replay", "arms"))
    row = published.rows[published.rows["configuration"] == "sdf 64"].iloc[0]
    assert row["time_ms"] == asked["collision_ms"] and row["own_ms"] == driving["collision_ms"]
    assert row["offset_mm"] == pytest.approx(1e3 * asked["p99_offset_m"]) and row["missed_mm"] == pytest.approx(1e3 * asked["max_missed_depth_m"])
    arms = pd.read_csv(PUBLISHED / "arm_errors.csv")
    assert row["arm_mm"] == arms.loc[arms["configuration"].isin(["sdf 64", "sdf 64 *"]), "arm_rms_mm"].iloc[0]


def test_the_same_results_make_the_same_bytes(published):
    assert bundle_bytes(published) == bundle_bytes(bundle_of(PUBLISHED))


def test_a_backend_of_others_needs_a_licence_and_a_source(tmp_path):
    shutil.copytree(PUBLISHED, tmp_path / "accuracy-mine")
    told = json.loads((tmp_path / "accuracy-mine" / SOURCE).read_text())
    told["implementations"]["vtk"] = "an example"
    (tmp_path / "accuracy-mine" / SOURCE).write_text(json.dumps(told))
    with pytest.raises(Problem, match="--licence vtk=MIT --source vtk=URL@COMMIT"):
        bundle_of(tmp_path / "accuracy-mine")
    about = bundle_of(tmp_path / "accuracy-mine", {"vtk": "BSD-2-Clause"}, {"vtk": "https://example.org/vtk@1a2b"}).header["backends"]["vtk"]
    assert about == {"implementation": "an example", "source": "https://example.org/vtk@1a2b", "licence": "BSD-2-Clause"}
    with pytest.raises(Problem, match="no backend and no scene .* is called so"):
        bundle_of(tmp_path / "accuracy-mine", {"vtq": "MIT"})


# What strangers may send

def packed(path: Path, bundle: Bundle, header=lambda told: told, rows=lambda text: text, more: dict | None = None, is_honest: bool = True) -> Path:
    """With the header and the rows changed; `is_honest`: its hashes are those of what it holds."""
    write_bundle(bundle, path)
    with zipfile.ZipFile(path) as file:
        parts = {name: file.read(name) for name in file.namelist()}
    parts[ROWS] = rows(parts[ROWS].decode()).encode()
    told = honest(bundle, parts) if is_honest else json.loads(parts[HEADER])
    parts[HEADER] = json.dumps(header(copy.deepcopy(told))).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in {**parts, **(more or {})}.items():
            file.writestr(zipfile.ZipInfo(name, LONG_AGO), data, zipfile.ZIP_DEFLATED)
    return path


def honest(bundle: Bundle, parts: dict) -> dict:
    return bundle.header | {"format": FORMAT, "files": {name: hashlib.sha256(data).hexdigest() for name, data in parts.items() if name != HEADER}}


def cell(name: str, value: str):
    """Changes a cell of the first row."""
    def change(text: str) -> str:
        lines = text.splitlines(keepends=True)
        row = pd.read_csv(pd.io.common.StringIO(lines[0] + lines[1]), keep_default_na=False, dtype=str)
        row[name] = value
        return lines[0] + row.to_csv(index=False).splitlines(keepends=True)[1] + "".join(lines[2:])

    return change


def test_what_is_packed_by_hand_is_read(published, tmp_path):
    assert len(read_bundle(packed(tmp_path / "a.zip", published)).rows) == len(published.rows)


@pytest.mark.parametrize(("rows", "words"), [
    (cell("time_ms", "nan"), "time_ms: 'nan' is no number"), (cell("time_ms", "inf"), "is no number"), (cell("time_ms", "-1"), "is no number"),
    (cell("time_ms", "0"), "is no number"), (cell("time_ms_low", "1e9"), "outside its interval"), (cell("structure_bytes", "1e300"), "is no count"),
    (cell("threads", "1.5"), "is no count"), (cell("threads", ""), "lacks threads"), (cell("configuration", "<script>alert(1)</script>"), "is no name"),
    (cell("backend", "../../etc"), "is no name"), (cell("backend", "unknown"), "does not tell of unknown"), (cell("contact_hash", "0x1"), "is no hash"),
    (cell("status", "splendid"), "is no status"), (cell("is_default", "yes"), "is no flag"), (cell("parameters", "[1]"), "is no text"),
    (cell("detail", "a\x1b[31m"), "is no text"), (cell("spoken", "a" * 501), "is no text"), (lambda text: text.splitlines()[0] + "\n", "no row"),
    (lambda text: text.replace("time_ms,", "time_s,", 1), "other columns"), (lambda text: text + text.splitlines()[1] + "\n", "twice"),
    (lambda text: text + "a,b\n", "2 cells"), (lambda text: text + 5000 * (text.splitlines()[1] + "\n"), "more than 5000 rows"),
])
def test_a_row_that_is_not_one_is_refused(published, tmp_path, rows, words):
    with pytest.raises(Problem, match=re.escape(words)) as problem:
        read_bundle(packed(tmp_path / "a.zip", published, rows=rows))
    assert "\n" not in str(problem.value) and str(problem.value).startswith(str(tmp_path / "a.zip"))


def without(*keys: str):
    def change(told: dict) -> dict:
        inner = told
        for key in keys[:-1]:
            inner = inner[key]
        del inner[keys[-1]]
        return told

    return change


@pytest.mark.parametrize(("header", "words"), [
    (without("machine", "cpu"), "lacks machine.cpu"), (without("build", "flags"), "lacks build.flags"), (without("commit"), "lacks commit"),
    (without("backends", "bvh", "licence"), "lacks backends.bvh.licence"), (without("scenes", "synthetic/iliacus", "licence"), "licence"),
    (without("backends", "vtk"), "does not tell of vtk"), (lambda told: told | {"format": 9}, "format 9"), (lambda told: told | {"measured": "soon"}, "is no date"),
    (lambda told: told | {"title": "a\u202eb"}, "control characters"), (lambda told: told | {"state": [1]}, "table 'state'"), (lambda told: [told], "not a table"),
    (lambda told: told | {"state": {"load": float("nan")}}, "no number"), (lambda told: told | {"more": "x" * 300_000}, "more than 0.2 MB"),
])
def test_a_header_that_lacks_something_is_refused(published, tmp_path, header, words):
    with pytest.raises(Problem, match=re.escape(words)) as problem:
        read_bundle(packed(tmp_path / "a.zip", published, header=header))
    assert "\n" not in str(problem.value)


def test_forged_rows_are_refused(published, tmp_path):
    with pytest.raises(Problem, match="sha256"):
        read_bundle(packed(tmp_path / "a.zip", published, rows=cell("time_ms", "1e-3"), is_honest=False))


@pytest.mark.parametrize(("more", "words"), [
    ({"../outside": b""}, "only bundle.json"), ({"/etc/passwd": b""}, "only bundle.json"), ({"rows.csv/": b""}, "only bundle.json"),
    ({ROWS: b"0" * 200_000_000}, "more than 5 MB"), ({SHAPES: b"[" * 100_000}, "sha256"),
])
def test_files_that_do_not_belong_there_are_refused(published, tmp_path, more, words):
    with pytest.raises(Problem, match=re.escape(words)):
        read_bundle(packed(tmp_path / "a.zip", published, more=more))


def test_a_zip_that_lies_about_its_sizes_is_refused(published, tmp_path):
    path = packed(tmp_path / "a.zip", published, more={ROWS: b"0" * 200_000_000})
    path.write_bytes(path.read_bytes().replace((200_000_000).to_bytes(4, "little"), (1000).to_bytes(4, "little")))
    with pytest.raises(Problem):
        read_bundle(path)


@pytest.mark.parametrize("damage", [lambda data: b"", lambda data: b"hello", lambda data: data[:-100], lambda data: data[:2000] + b"\0" + data[2001:]])
def test_what_is_no_zip_is_refused(published, tmp_path, damage):
    path = packed(tmp_path / "a.zip", published)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(Problem) as problem:
        read_bundle(path)
    assert "\n" not in str(problem.value)


def test_a_file_in_the_zip_twice_is_refused(published, tmp_path):
    path = packed(tmp_path / "a.zip", published)
    with zipfile.ZipFile(path, "a") as file, pytest.warns(UserWarning):
        file.writestr(ROWS, "again")
    with pytest.raises(Problem, match="twice"):
        read_bundle(path)


# What the board says

def test_the_same_answers_are_verified_and_others_refuted(published):
    told, same, other = (made(published, contact_hash=answer) for answer in (ANSWERS, ANSWERS, OTHERS))
    assert board_rows([told])["standing"].tolist() == ["claimed"]
    assert board_rows([told], [same.rows])["standing"].tolist() == ["verified"]
    refuted = board_rows([told], [other.rows]).iloc[0]
    assert refuted["standing"] == "refuted" and "not those" in refuted["why_not"]
    asked_else = made(published, contact_hash=OTHERS, queries_hash="f" * 16)
    assert board_rows([told], [asked_else.rows])["standing"].tolist() == ["claimed"]
    assert board_rows([made(published, contact_hash="")])["standing"].tolist() == ["claimed, no hash"]


@pytest.mark.parametrize(("values", "bound", "division"), [
    ({}, "held", "closed"), ({"missed_mm": 0.2}, "broken", "open"), ({"false_mm": 0.2}, "broken", "open"), ({"declared_missed_mm": None}, "none declared", "open"),
    ({"missed_mm": None}, "not judged", "open"), ({"declared_false_mm": None, "missed_mm": 0.2}, "broken", "open"), ({"scene": "my.toml"}, "held", "open"),
])
def test_a_bound_is_the_backends_own_word(published, values, bound, division):
    bundle = made(published, **values)
    row = board_rows([replace(bundle, header=bundle.header | {"scenes": {"my.toml": {"licence": "x"}, **bundle.header["scenes"]}})]).iloc[0]
    assert (row["bound"], row["division"]) == (bound, division) and (row["why_not"] != "") == (bound == "broken")


def test_older_questions_are_grey_and_one_machine_has_one_row(published):
    old = measured_on(made(published, queries_hash="f" * 16), "2026-01-01")
    new = measured_on(made(published), "2026-02-01")
    other = measured_on(made(published), "2026-01-15", "B")
    rows = board_rows([new, old, other])
    assert rows["is_old"].tolist() == [False, True, False] and rows["is_replaced"].tolist() == [False, True, False]
    assert "measured anew" in rows["why_not"][1] and rows["division"].tolist() == ["closed", "open", "closed"]


def test_what_did_not_answer_and_the_control_can_not_win(published):
    assert board_rows([made(published, status="timeout", detail="too long")])["why_not"].tolist() == ["timeout: too long"]
    assert "no collision" in board_rows([made(published, is_control=True)])["why_not"][0]
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
    (out / "run.json").write_text(json.dumps({"queries_hash": "%s", "contact_hash": "%s"}))
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
    found = recompute([*bundles, strange, elsewhere], program, registry, None, 10.0, lambda text: None)
    assert set(found["configuration"]) == {"bvh", "sdf 32"} and set(found["contact_hash"]) == {ANSWERS}
    asked, told = (tmp_path / "asked.txt").read_text(), capsys.readouterr().err
    assert "/etc" not in asked and "--param cells=32" in asked
    assert "structures is not one that a stranger may set" in told and "fcl is not built here" in told and "my.toml is not known here" in told


def registry_of() -> Registry:
    """Of a program without FCL."""
    known = fake_registry.registry()
    return replace(known, backends=tuple(one for one in known.backends if one.name != "fcl"), scenes=(SceneEntry("synthetic/iliacus"),))


# The site

@pytest.fixture
def no_script(monkeypatch):
    monkeypatch.setattr(site, "page_script", lambda entry: "// none")


def test_the_projects_own_board_is_whole(published, tmp_path, no_script):
    hard = hard_cases(MEASURED / "hard-synthetic")
    rows = site.write_site([published], [], hard, tmp_path / "board")
    assert len(rows) == len(published.rows) and {path.name for path in (tmp_path / "board").iterdir()} > {"index.html", "board.js", "style.css", "board.csv"}
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
    header["backends"]["mine"] = {"implementation": "<b>mine</b>, MIT", "source": "javascript:alert(1)", "licence": "MIT", "title": "'><script>", "colour": "red;}"}
    site.write_site([replace(bundle, header=header, rows=bundle.rows.assign(backend="mine"))], [], [], tmp_path / "board")
    for path in (tmp_path / "board").rglob("*.html"):
        text = path.read_text()
        assert "<script>alert" not in text and "<img" not in text and "<b>mine" not in text and "red;}" not in text, path
        assert 'href="javascript' not in text


def test_names_that_look_alike_have_pages_of_their_own():
    assert site._paths("scenes", ["a/b", "a b", "a-b", "..", "A-B"]) == {
        "a/b": "scenes/a-b.html", "a b": "scenes/a-b.2.html", "a-b": "scenes/a-b.3.html", "..": "scenes/unnamed.html", "A-B": "scenes/A-B.4.html"}


def test_only_a_board_is_replaced(published, tmp_path, no_script, monkeypatch):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(Problem, match="is no board"):
        site.write_site([published], [], [], tmp_path / "mine")
    site.write_site([published], [], [], tmp_path / "board")
    (tmp_path / "board" / "old.html").write_text("old")
    site.write_site([published], [], [], tmp_path / "board")
    assert not (tmp_path / "board" / "old.html").exists()
    monkeypatch.setattr(site, "LARGEST_BYTES", 1000)
    with pytest.raises(Problem, match="more than"):
        site.write_site([published], [], [], tmp_path / "board")
    assert (tmp_path / "board" / "index.html").is_file() and (tmp_path / "mine" / "notes.txt").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"mine", "board"}


# The ranking, as the browser computes it

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


def row(configuration: str, time_ms: float, offset_mm: float | None, **values) -> dict:
    return {"scene": "s", "machine": "m", "backend": configuration.split()[0], "configuration": configuration, "division": "open", "why_not": None,
            "time_ms": time_ms, "time_ms_low": 0.9 * time_ms, "time_ms_high": 1.1 * time_ms, "own_ms": None, "offset_mm": offset_mm, "build_s": 1.0,
            "ridge_mm": None, "arm_mm": None, "arm_floor_mm": None} | values


def test_the_cheapest_setting_that_holds_the_error_is_first():
    rows = [row("grid 64", 1.0, 0.09), row("grid 16", 0.5, 0.4), row("tree", 2.0, 0.0), row("grid 128", 1.5, 0.01), row("other", 0.1, 5.0),
            row("wrong", 0.01, 0.0, why_not="errs by more than it declares"), row("unknown", 0.01, None), row("else", 0.1, 0.0, machine="another")]
    found = ranked(rows)
    assert [one["configuration"] for one in found["ranked"]] == ["grid 64", "tree"] and found["ranked"][1]["times"] == 2
    assert found["front"] == ["other", "grid 16", "grid 64", "grid 128", "tree"]
    why = {one["backend"]: one["why"] for one in found["unable"]}
    assert why == {"other": "its most accurate setting is off by 5", "wrong": "errs by more than it declares", "unknown": "its error is not known"}
    assert [one["configuration"] for one in ranked(rows, at=0.5)["ranked"]] == ["grid 16", "tree"]
    assert ranked(rows, division="closed")["ranked"] == []


def test_a_build_pays_after_so_many_frames():
    rows = [row("slow", 10.0, 0.0, build_s=0.1), row("fast", 1.0, 0.0, build_s=1.0), row("loser", 12.0, 0.0, build_s=2.0), row("unknown", 20.0, 0.0, build_s=None)]
    pays = {one["backend"]: one["pays_after"] for one in ranked(rows)["ranked"]}
    assert pays == {"slow": 0, "fast": 100, "loser": "never", "unknown": None}  # 0.9 s later, 9 ms a frame faster


def test_hard_contacts_and_other_errors_have_columns_and_times_of_their_own():
    rows = [row("grid", 1.0, 0.01, ridge_mm=0.5, own_ms=3.0, own_ms_low=2.0, own_ms_high=4.0, arm_mm=0.01, arm_floor_mm=0.2), row("tree", 2.0, 0.0, ridge_mm=0.0)]
    assert [one["backend"] for one in ranked(rows, contacts="ridge")["ranked"]] == ["tree"]
    arm = ranked(rows, error="arm", contacts="ridge", at=0.1)
    assert arm["ranked"] == [] and arm["column"] == "arm_mm"  # nobody is better than rounding
    assert [(one["backend"], one["time_ms"], one["error"]) for one in ranked(rows, error="arm", at=0.2)["ranked"]] == [("grid", 3.0, 0.2)]


def test_times_whose_intervals_overlap_are_said_to():
    found = ranked([row("first", 1.0, 0.0), row("second", 1.1, 0.0), row("third", 3.0, 0.0)])["ranked"]
    assert [one["is_tied"] for one in found] == [False, True, False]


def test_every_column_has_its_help():
    assert len(NAMES) == len(set(NAMES)) and all(column.help for column in COLUMNS)
