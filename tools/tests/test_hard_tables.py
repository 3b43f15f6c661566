"""What a page shows of the hard cases, from rows as `musclebench hard` writes them."""

import io

import pandas as pd
import pytest

import fake_runs
import publish
from musclebench.hard import hard_tables
from musclebench.hard.causes import Cause
from musclebench.hard.cells import cases_of, cells_of
from musclebench.program.cli import Problem
from musclebench.publish.blocks import block
from musclebench.publish.measured import TABLES, Measured, adopt

MATRIX = """case,backend,verdict,figure,value,bar,unit,detail,seconds,scene
scale,null,not applicable,,,,,"finds no contacts",0.001,
scale,voxel,holds,"other bits",0,0,points,"",0.1,
scale,sdf,breaks,"a change, over the diagonal",8.76e-09,1e-09,,"",0.1,
scale,sdf,breaks,"other bits",2,0,points,"",0.1,
pinch,null,not applicable,,,,,"finds no contacts",0.001,hard/pinch
pinch,voxel,not applicable,,,,,"finds no contacts",0.001,hard/pinch
pinch,sdf,refused,"largest move",1.5444,0.001,mm,"suspect: off | by 105 %",0.2,hard/pinch
pinch,sdf,refused,"by order",0.5,1,,"suspect: off | by 105 %",0.2,hard/pinch
rest,null,breaks,"a depth",0.5,10,,"",0.1,
rest,null,breaks,"farthest node",nan,10,,"",0.1,
rest,voxel,breaks,,,,,"crashed (signal 11)",0.1,
rest,sdf,holds,"drift",1e-10,1e-9,,"",0.1,
"""
LISTED = """scale
  The same ball.
  Tolerances hide.
  Bar: the same bits; 1e-9.
pinch
  Two bones close.
  No place is outside of both.
  Bar: no node moves.
  Sane figures left out: the bones overlap.
  Scene: hard/pinch
"""


@pytest.fixture
def rows() -> pd.DataFrame:
    return pd.read_csv(io.StringIO(MATRIX), keep_default_na=False)


@pytest.fixture
def published(rows, tmp_path) -> Measured:
    """Of a study whose tables tools/publish has taken over."""
    out = tmp_path / "out"
    fake_runs.write_run(out / "raw" / "pinch", "hard/pinch", "fcl")
    (out / "tables").mkdir()
    cells_of(rows).to_csv(out / "tables" / "cells.csv", index=False)
    cases_of(LISTED).to_csv(out / "tables" / "cases.csv", index=False)
    adopt("hard-synthetic", out, tmp_path / "measured" / "hard-synthetic", "tools/hard")
    return Measured(tmp_path / "measured")


def test_a_cell_shows_the_figure_farthest_beyond_its_bar(rows):
    cells = cells_of(rows).set_index(["case", "backend"])
    assert len(cells) == 9 and list(cells.index[:3]) == [("scale", "null"), ("scale", "voxel"), ("scale", "sdf")]
    assert cells.loc[("scale", "sdf"), "figure"] == "a change, over the diagonal"  # 8.8 bars; a count of 2 is 3
    assert cells.loc[("pinch", "sdf"), "value"] == 1.5444
    assert cells.loc[("rest", "null"), "figure"] == "farthest node"  # no number is the worst


def test_cases_are_read_as_they_are_listed():
    cases = cases_of(LISTED).set_index("case")
    assert list(cases.loc["pinch"]) == ["Two bones close.", "No place is outside of both.", "no node moves", "the bones overlap", "hard/pinch"]
    assert cases.loc["scale", "bar"] == "the same bits; 1e-9" and cases.loc["scale", "scene"] == ""
    for other in ("", LISTED + "rest\n  Nothing moves.\n", LISTED.replace("Bar", "Limit")):
        with pytest.raises(Problem, match="--list"):
            cases_of(other)


def test_the_matrix_links_to_its_cases(published):
    text, told = block(published, "hard_matrix hard-synthetic"), block(published, "hard_cases hard-synthetic")
    assert "| case | null | voxel | sdf |" in text and "| [scale](hard_cases/cases.md#scale) | - | holds | **BREAKS** |" in text
    assert "| [pinch](hard_cases/cases.md#pinch) | - | - | refused |" in text and "commit abc1234" in text
    assert "2 hold, 3 break, 1 refused, 3 not applicable." in text
    assert "### scale\n\nThe same ball. Tolerances hide. **Bar:** the same bits; 1e-9." in told
    assert "### pinch\n\n" in told and "**Sane figures left out:** the bones overlap." in told and "Scene: `hard/pinch`." in told


def test_what_is_beyond_its_bar_stands_with_it(published):
    lines = block(published, "hard_beyond hard-synthetic").splitlines()
    assert "| [scale](cases.md#scale) | sdf | **BREAKS** | a change, over the diagonal | 8.76e-09 | 1e-09 | - |" in lines
    assert "| [pinch](cases.md#pinch) | sdf | refused | largest move | 1.54 mm | 0.001 mm | suspect: off / by 105 % |" in lines
    assert "| [rest](cases.md#rest) | null | **BREAKS** | farthest node | no number | 10 | - |" in lines
    assert "| [rest](cases.md#rest) | voxel | **BREAKS** | - | - | - | crashed (signal 11) |" in lines
    assert sum(line.startswith("| [") for line in lines) == 4
    assert "Every cell holds." in block(published, "hard_beyond hard-synthetic verdict=holds")


def test_what_one_backend_does_not_hold_and_another_one_does(published):
    lines = block(published, "not_held hard-synthetic sdf voxel").splitlines()
    assert [line for line in lines if line.startswith("| [")] == [
        "| [scale](../hard_cases/cases.md#scale) | sdf | **BREAKS** | a change, over the diagonal | 8.76e-09 | 1e-09 | - |",
        "| [pinch](../hard_cases/cases.md#pinch) | sdf | refused | largest move | 1.54 mm | 0.001 mm | suspect: off / by 105 % |"]
    assert "| [rest](../hard_cases/cases.md#rest) | null | **BREAKS** |" in block(published, "not_held hard-synthetic null sdf")
    assert "It holds all cases that can be asked of it" in block(published, "not_held hard-synthetic sdf sdf")
    with pytest.raises(Problem, match="no backend 'tree'; there are null, voxel, sdf"):
        block(published, "not_held hard-synthetic sdf tree")


def test_verdicts_are_counted_by_backend(published):
    lines = block(published, "hard_counts hard-synthetic").splitlines()
    assert lines[0] == "| backend | holds | breaks | refused | not applicable |" and lines[2] == "| null | 0 | 1 | 0 | 2 |"


def test_causes_are_told_of_what_breaks_only(published, monkeypatch):
    told = [Cause("Late.", {"pinch": ["sdf"]}), Cause("Deep.", {"rest": ["null", "voxel"], "scale": ["voxel"]})]
    monkeypatch.setattr(hard_tables, "read_causes", lambda: told)
    rows = [line for line in block(published, "hard_causes hard-synthetic").splitlines() if "Late" in line or "Deep" in line]
    assert rows == ["| Deep. | 2 | [rest](hard_cases/cases.md#rest) |"]


def test_reasons_not_to_ask_are_shared(published):
    text = block(published, "hard_unasked hard-synthetic")
    assert "| null | finds no contacts | all but rest |" in text
    assert "| voxel | finds no contacts | pinch |" in text
    alone = block(published, "hard_unasked hard-synthetic case=pinch")
    assert "| null, voxel | finds no contacts | all |" in alone


def test_hard_cases_are_published_once_and_with_what_breaks(tmp_path):
    """Their scenes are made by code, so data don't matter; that a cell breaks is no failure of the study."""
    options = publish.parse_arguments(["--data", str(tmp_path), "--only", "hard"])
    steps = publish.steps_of(options)
    assert [step.name for step in steps] == ["hard-synthetic"] and "--breaks-are-results" in steps[0].arguments
    assert "--data" not in steps[0].command(options.musclebench, tmp_path)
    assert TABLES["hard"] == ("tables/cells.csv", "tables/cases.csv")
