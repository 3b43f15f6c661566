"""The study of substeps runs as the others do: one process a case, goes on where it was stopped, any scene."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

import convergence
import fake_registry
import fake_runs
from fake_sweep import swept
from musclebench.cases.case import Folders
from musclebench.convergence.convergence_report import write_report
from musclebench.experiments.selection import usual_backend

PROGRAM = Path(__file__).resolve().parent / "fake_musclebench.py"


@pytest.fixture
def study(tmp_path, monkeypatch, capfd):
    log = tmp_path / "log"

    def run(*more):
        monkeypatch.setenv("FAKE_LOG", str(log))
        log.write_text("")
        code = convergence.main(["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--muscle", "iliacus",
                                 "--substeps", "10,5", "--frames-limit", "12", *more])
        return code, *capfd.readouterr(), sorted(line.split()[0] for line in log.read_text().splitlines())

    return run


def test_complete_runs_are_kept_and_the_table_has_a_row_each(study, tmp_path):
    code, text, errors, called = study()
    assert code == 0, errors
    assert called == ["iliacus-substeps=10", "iliacus-substeps=5"]
    assert "".join((tmp_path / "out" / "tables" / "substeps.csv").read_text()).count("\n") == 3
    assert "synthetic/iliacus | bvh | 5 | ok | 0.000" in text
    assert study()[3] == []
    assert study("--substeps", "5,10,20")[3] == ["iliacus-substeps=20"]


def test_a_scene_of_several_muscles_takes_part(study):
    code, text, errors, called = study("--scene", "synthetic/hip")
    assert code == 0 and "hip-substeps=5" in called and "synthetic/hip | " in text, errors


@pytest.mark.parametrize("arguments, words", [
    (["--substeps", "5,many"], "'5,many' is not like"), (["--backend", "box2d"], "--backend box2d: not built"),
    (["--muscle", "biceps"], "'biceps'"), (["--jobs", "0"], "--jobs 0"),
])
def test_bad_input_is_one_line(study, arguments, words):
    code, _, errors, called = study(*arguments)
    assert code == 2 and errors.count("\n") == 1 and words in errors and called == []


def test_the_time_of_a_frame_stays_the_same(tmp_path):
    for case in swept("convergence", fake_registry.scene("lhdl/iliacus")):
        told = dict(word.split("=") for word in case.arguments(Folders(tmp_path)) if "=" in word)
        assert told["substeps"] == case.at("substeps").value
        assert int(told["substeps"]) * float(told["time_step_s"]) == pytest.approx(3e-3)


def test_the_shell_wrapper_answers_for_help_without_building():
    done = subprocess.run([str(Path(convergence.__file__).with_suffix("")), "--help"], capture_output=True, text=True,
                          timeout=60, check=False)
    assert done.returncode == 0 and "usage: tools/convergence [" in done.stdout


def test_the_usual_backend_is_exact_and_fast():
    registry = fake_registry.registry()
    backend = usual_backend(registry)
    assert backend.is_exact and backend.of_role("clearance_cache")


def test_distances_are_to_the_run_of_the_most_substeps(tmp_path):
    folders = []
    for substeps, shift_m in ((5, 0.002), (20, 0.0)):
        ball = fake_runs.sphere((shift_m, 0, 0), 0.05)
        shot = fake_runs.Snapshot(10, 90.0, ball.vertices_m, 0 * ball.vertices_m[:, 0], 0 * ball.vertices_m[:, 0])
        folder = fake_runs.write_run(tmp_path / f"s{substeps}", "lhdl/iliacus", "bvh", triangles=ball.triangles,
                                     snapshots=[shot], loop={"substeps": substeps})
        folders.append(folder)
    rows = write_report(folders, tmp_path / "tables")[0].rows.set_index("substeps")
    assert rows.loc[5, "rms_mm"] == pytest.approx(2.0) and rows.loc[5, "p99_mm"] == pytest.approx(2.0)
    assert rows.loc[20, "largest_mm"] == 0


def test_the_distance_of_shapes_is_the_root_of_the_mean_square(tmp_path):
    """Of four nodes one is 4 mm off."""
    triangles, folders = np.array([[0, 1, 2], [1, 3, 2]]), []
    for substeps, off_m in ((5, 0.004), (20, 0.0)):
        vertices_m = np.array([[0, 0, off_m], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
        shot = fake_runs.Snapshot(10, 90.0, vertices_m, np.zeros(4), np.zeros(4))
        folders.append(fake_runs.write_run(tmp_path / f"s{substeps}", "lhdl/iliacus", "bvh", triangles=triangles, snapshots=[shot],
                                           loop={"substeps": substeps}))
    row = write_report(folders, tmp_path / "tables")[0].rows.set_index("substeps").loc[5]
    assert (row["rms_mm"], row["p99_mm"], row["largest_mm"]) == pytest.approx((2, 4, 4))
