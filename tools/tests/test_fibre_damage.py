"""A run whose tables of fibres were cut is not complete."""

import fake_runs
import pytest

from musclebench.results.damage import damage


@pytest.fixture
def folder(tmp_path):
    folder = fake_runs.write_run(tmp_path / "run", "synthetic/iliacus", "bvh", 5)
    fake_runs.add_fibres(folder, "iliacus", [1, 1.1, 1.2, 1.3, 1.4, 1.5])
    return folder


def test_a_whole_one_has_no_damage(folder):
    assert damage(folder) == ""


@pytest.mark.parametrize("table", ["fibres.csv", "fibre_lengths.csv"])
def test_a_cut_one_is_told(folder, table):
    lines = (folder / table).read_text().splitlines(keepends=True)
    (folder / table).write_text("".join(lines[:-1]))
    assert damage(folder) == f"{table} has 5 of 6 rows"
    (folder / table).unlink()
    assert table in damage(folder)
