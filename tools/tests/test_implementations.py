"""Every table says whose implementation a row is."""

import json

import fake_runs
from musclebench.program.registry import read_registry, whose
from musclebench.publish.measured import Source, source_of
from musclebench.results import run_folder
from musclebench.tables.table_formats import Column, Table, as_latex, as_markdown
from program import PROGRAM, call, needs_program

import pandas as pd

WHOSE = {"voxel": "this project", "bvh": "this project", "fcl": "FCL 0.7.0", "old": ""}
TOLD = "Whose code? voxel, bvh: this project. fcl: FCL 0.7.0."


def test_backends_of_one_implementation_stand_together():
    assert whose(WHOSE) == TOLD
    assert whose({}) == whose({"old": ""}) == ""


def test_a_table_says_it_in_every_form():
    table = Table("one", "What it shows.", [Column("backend", "backend")], pd.DataFrame({"backend": ["fcl"]}), ["backend"])
    assert as_markdown(table.with_sentence(TOLD)).startswith(f"What it shows. {TOLD}\n")
    assert TOLD in as_latex(table.with_sentence(TOLD))
    assert table.with_sentence("").caption == table.caption


def test_a_page_says_whose_the_measured_backends_are():
    source = Source("tools/paper", "abc", "A processor", "GNU", "2026-01-01", 2)
    assert "Whose code?" not in source.words(), "measured before runs told"
    told = Source(**(json.loads(json.dumps(vars(source))) | {"implementations": WHOSE})).words()
    assert told.endswith(f"{TOLD}</sub>")


def test_runs_tell_and_those_of_an_older_program_do_not():
    records = [fake_runs.run_record("a/b", "voxel", 4), fake_runs.run_record("a/b", "fcl", 4), {"case": {}}]
    assert run_folder.implementations_in(records) == {"voxel": "library of voxel", "fcl": "library of fcl"}


def test_cells_of_hard_cases_take_theirs_from_the_registry(tmp_path):
    """They are no runs, and say whose nothing is; a scene that was drawn is one backend's."""
    fake_runs.write_run(tmp_path / "raw" / "scenes" / "pinch", "hard/pinch", "bvh")
    for backend in ("bvh", "fcl", "mine"):
        cell = tmp_path / "raw" / f"pinch-{backend}" / "run.json"
        cell.parent.mkdir()
        cell.write_text(json.dumps({"case": {"mode": "hard", "backend": backend}}))
    known = [{"name": name, "implementation": told} for name, told in {"fcl": "FCL 0.7.0", "sdf": "not asked", "mine": ""}.items()]
    (tmp_path / "registry.json").write_text(json.dumps({"backends": known}))
    assert source_of(tmp_path, "tools/hard").implementations == {"bvh": "library of bvh", "fcl": "FCL 0.7.0"}


@needs_program
def test_the_program_lists_an_implementation_of_every_backend():
    for backend in read_registry(PROGRAM).backends:
        assert backend.implementation
        assert f"implementation           {backend.implementation}\n" in call("list").stdout


@needs_program
def test_a_run_tells_whose_all_its_backends_are(tmp_path):
    done = call("run", "synthetic/iliacus", "--backend", "sdf", "--param", "cells=8", "--for", "femur=bvh", "--frames", "1",
                "--no-referee", "--out", tmp_path / "run")
    assert done.returncode in (0, 3), done.stderr
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    assert set(record["implementations"]) == {"sdf", "bvh"}
    assert "Discregrid" in record["implementations"]["sdf"]
