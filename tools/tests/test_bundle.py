"""Bundles: what comes back, and what is refused."""

import copy
import hashlib
import json
import re
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

import bundle as bundle_tool
from musclebench.board import reading
from musclebench.board.bundle import FORMAT, HEADER, LONG_AGO, ROWS, SHAPES, Bundle, bundle_bytes, write_bundle
from musclebench.board.columns import COLUMNS, NAMES
from musclebench.board.made import LICENCE, bundle_of
from musclebench.board.packing import pack
from musclebench.board.reading import read_bundle
from musclebench.program.cli import Problem
from musclebench.publish.measured import SOURCE
from published_bundle import PUBLISHED


@pytest.fixture(scope="module")
def published() -> Bundle:
    return bundle_of(PUBLISHED)


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
    (cell("status", "splendid"), "is no status"), (cell("is_disturbed", "yes"), "is no flag"), (cell("time_ms", "1_0"), "is no number"),
    (cell("time_ms", " 1"), "is no number"), (cell("parameters", "[1]"), "is no text"),
    (cell("parameters", '{"cells": "1\\u0000"}'), "is no text"), (cell("parameters", '{"cells": 16}'), "is no text"),
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
    (without("backends", "vtk"), "does not tell of vtk"), (lambda told: told | {"format": 9}, "format 9"),
    (lambda told: told | {"measured": "soon"}, "is no date"),
    (lambda told: told | {"measured": "2999-01-01"}, "is no date of the past"),
    (lambda told: told | {"title": "a\u202eb"}, "control characters"), (lambda told: told | {"title": "a\ud800"}, "control characters"),
    (lambda told: told | {"x" * 200: 1}, "a key of more than 160"), (lambda told: told | {"state": {"load": 1e300}}, "is no number"),
    (lambda told: told | {"state": [1]}, "table 'state'"),
    (lambda told: [told], "not a table"),
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


def shapes_of(published, tmp_path, **run) -> Path:
    shapes = {"synthetic/iliacus": {"scenes": [{"muscle": "iliacus", "runs": [run]}], "meshes": {}}}
    write_bundle(replace(published, shapes=shapes), tmp_path / "a.zip")
    return tmp_path / "a.zip"


def test_shapes_hold_no_markup_and_no_bomb(published, tmp_path, monkeypatch):
    assert read_bundle(shapes_of(published, tmp_path, frames=[0, 1])).shapes
    with pytest.raises(Problem, match="holds markup"):
        read_bundle(shapes_of(published, tmp_path, frames=["<img src=x onerror=alert(1)>"]))
    monkeypatch.setattr(reading, "MOST_LEAVES", 1000)
    with pytest.raises(Problem, match="more than 1000 values"):
        read_bundle(shapes_of(published, tmp_path, frames=[0] * 1000))
    with pytest.raises(Problem, match="more than 4 MB"):
        read_bundle(shapes_of(published, tmp_path, frames=[0] * 400_000))


def test_an_own_scene_goes_by_its_name(tmp_path):
    shutil.copytree(PUBLISHED, tmp_path / "mine")
    study = (tmp_path / "mine" / "study.csv").read_text()
    (tmp_path / "mine" / "study.csv").write_text(study.replace("synthetic/iliacus", "/somewhere/my hip.toml"))
    bundle = bundle_of(tmp_path / "mine")
    assert set(bundle.rows["scene"]) == {"my hip"} and bundle.header["scenes"] == {"my hip": {"licence": "not told"}}
    (tmp_path / "mine" / "study.csv").write_text(study.replace("synthetic/iliacus", "h\u00fcft.toml"))
    with pytest.raises(Problem, match="is no name that a bundle can hold"):
        bundle_of(tmp_path / "mine")
    (tmp_path / "mine" / "study.csv").write_text(study.replace("collision_ms,", "collision_s,", 1))
    with pytest.raises(Problem, match="lacks the column collision_ms"):
        bundle_of(tmp_path / "mine")


def test_a_zip_that_lies_about_its_sizes_is_refused(published, tmp_path):
    path = packed(tmp_path / "a.zip", published, more={ROWS: b"0" * 200_000_000})
    path.write_bytes(path.read_bytes().replace((200_000_000).to_bytes(4, "little"), (1000).to_bytes(4, "little")))
    with pytest.raises(Problem):
        read_bundle(path)


@pytest.mark.parametrize("damage", [lambda data: b"", lambda data: b"hello", lambda data: data[:-100]])
def test_what_is_no_zip_is_refused(published, tmp_path, damage):
    path = packed(tmp_path / "a.zip", published)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(Problem) as problem:
        read_bundle(path)
    assert "\n" not in str(problem.value)


def test_a_byte_that_is_wrong_anywhere_changes_no_row(published, tmp_path):
    """It is refused in one line, or is in what says nothing, such as a time of the zip."""
    data = packed(tmp_path / "a.zip", published).read_bytes()
    rows, refused = read_bundle(tmp_path / "a.zip").rows, 0
    for at in range(0, len(data), 41):
        (tmp_path / "a.zip").write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1:])
        try:
            pd.testing.assert_frame_equal(read_bundle(tmp_path / "a.zip").rows, rows)
        except Problem as problem:
            refused += 1
            assert "\n" not in str(problem)
    assert refused > 100


def test_a_file_in_the_zip_twice_is_refused(published, tmp_path):
    path = packed(tmp_path / "a.zip", published)
    with zipfile.ZipFile(path, "a") as file, pytest.warns(UserWarning):
        file.writestr(ROWS, "again")
    with pytest.raises(Problem, match="twice"):
        read_bundle(path)


# The tool

def test_a_bundle_is_made_and_checked(published, tmp_path, capsys):
    out = tmp_path / "mine.zip"
    assert bundle_tool.main([str(PUBLISHED), "--out", str(out)]) == 0 and out.read_bytes() == bundle_bytes(published)
    assert bundle_tool.main(["--check", str(out)]) == 0 and capsys.readouterr().out.count("10 backends on synthetic/iliacus") == 2
    assert bundle_tool.main(["--columns"]) == 0 and "surface offset" in capsys.readouterr().out
    out.write_text("no zip")
    assert bundle_tool.main([str(PUBLISHED), "--out", str(out)]) == 2 and out.read_text() == "no zip" and "is no bundle" in capsys.readouterr().err
    for wrong in (["--check", str(out)], [str(tmp_path / "nothing")], [], ["--check", str(out), "--out", "b.zip"], [str(PUBLISHED), "--out", "b.tar"],
                  [str(tmp_path)]):
        assert bundle_tool.main(wrong) == 2 and len(capsys.readouterr().err.splitlines()) == 1


def test_a_bundle_is_named_after_its_folder(tmp_path):
    shutil.copytree(PUBLISHED, tmp_path / "lab-v1.0")
    assert pack(tmp_path / "lab-v1.0")[0] == tmp_path / "lab-v1.0.zip"


@pytest.mark.parametrize(("text", "licence"), [
    ("mine 1.0, MIT", "MIT"), ("x 2, Apache-2.0", "Apache-2.0"), ("y 3, GPL-3.0-or-later (so is a program)", "GPL-3.0-or-later"),
    ("GCC 12 build", None), ("1 by J. SMITH", None), ("a method 2, CCD", None), ("fast 1 LIMITED", None),
])
def test_a_licence_is_a_whole_word(text, licence):
    found = LICENCE.search(text)
    assert (found[0] if found else None) == licence


def test_every_column_has_its_help():
    assert len(NAMES) == len(set(NAMES)) and all(column.help for column in COLUMNS)
