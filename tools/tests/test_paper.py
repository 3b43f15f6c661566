"""The experiment from end to end, with a stand-in for the program."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas as pd
import pytest

import fake_registry
import paper
from fake_sweep import one_of, swept
from musclebench.cases.case import Folders
from musclebench.cases.experiment import Experiment
from musclebench.cases.pool import Limits, run_cases
from musclebench.page import of_study
from musclebench.pictures import surface_figures, surface_pictures
from musclebench.results import run_folder, snapshots

PROGRAM = Path(__file__).resolve().parent / "fake_musclebench.py"
BY_NUMBERS = ["fig_7_collision_time", "fig_8_memory", "depth_by_frame"]
OF_SURFACES = ["fig_6_iliacus", "muscles_at_full_flexion", "attachments"]
A_MUSCLE = 7  # cases: the paper's four, FCL as advised, the exact run and its floor
CAN_DRAW = shutil.which("Xvfb") or os.environ.get("DISPLAY")


def run_paper(out, *more, log=None, behaviour=""):
    environment = {**os.environ, "FAKE_BEHAVIOUR": behaviour, **({"FAKE_LOG": str(log)} if log else {})}
    command = [sys.executable, paper.__file__, "--musclebench", str(PROGRAM), "--out", str(out), "--frames-limit", "12"]
    return subprocess.run([*command, *more], env=environment, capture_output=True, text=True, timeout=120)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    done = run_paper(folder / "out", log=folder / "log")
    return folder / "out", folder / "log", done


@pytest.fixture
def in_process(tmp_path, monkeypatch, capfd):
    """Runs paper.main with the stand-in on two muscles, without drawing; gives (exit code, standard output, standard
    error, cases that were run)."""
    log = tmp_path / "log"
    monkeypatch.setattr(paper, "draw_in_display", lambda kind, out_dir, names: [])
    monkeypatch.setattr(of_study, "write_page", lambda folders: folders[0] / "report.html")
    monkeypatch.setattr(paper.paper_figures, "draw_figures", lambda runs, paper, folder: [])

    def run(*more, behaviour=""):
        monkeypatch.setenv("FAKE_BEHAVIOUR", behaviour)
        monkeypatch.setenv("FAKE_LOG", str(log))
        log.write_text("")
        always = ["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--frames-limit", "12",
                  "--muscle", "iliacus", "--muscle", "gluteus_medius"]
        code = paper.main([*always, *more])
        return code, *capfd.readouterr(), [line.split()[0] for line in log.read_text().splitlines()]

    return run


@pytest.mark.long
def test_tables_say_whose_the_backends_are(in_process):
    code, text, errors, _ = in_process()
    assert code == 0, errors
    assert "fcl: library of fcl" in text


@pytest.mark.long
def test_what_the_program_lacks_is_left_out_and_said(in_process):
    """The stand-in has the backends of every build and no library."""
    code, text, errors, calls = in_process()
    assert code == 0 and not [call for call in calls if "discregrid" in call], errors
    assert "Left out, as this program lacks them: discregrid; tools/setup --all" in text


@pytest.mark.long
def test_every_case_runs_once_on_a_core_of_its_own(finished):
    _, log, done = finished
    calls = [line.split() for line in log.read_text().splitlines()]
    assert sorted(call[0] for call in calls) == sorted(case.name for case in swept("paper"))
    assert all(len(call) == 2 for call in calls)


@pytest.mark.long
@pytest.mark.skipif(not CAN_DRAW, reason="no display and no Xvfb: surface figures can't be drawn")
def test_everything_is_written_named_and_printed(finished):
    out, _, done = finished
    assert done.returncode == 0, done.stderr
    names = [f"figures/{name}{suffix}" for name in BY_NUMBERS + OF_SURFACES for suffix in (".png", ".svg", ".pdf", ".csv")]
    names += [f"tables/smoothness{suffix}" for suffix in (".csv", ".md", ".tex")]
    names += [f"tables/table_{name}{suffix}" for name in ("1_memory", "2_times") for suffix in (".csv", ".md", ".tex")]
    for name in [*names, "runs.csv"]:
        assert (out / name).stat().st_size > 0, name
        assert str(out / name) in done.stdout
    assert "Table I." in done.stdout and "95 %" in done.stdout
    assert len(pd.read_csv(out / "runs.csv")) == 4 * A_MUSCLE


@pytest.mark.long
@pytest.mark.skipif(not CAN_DRAW, reason="no display and no Xvfb: surface figures can't be drawn")
def test_figures_are_not_blank(finished):
    for name in BY_NUMBERS + OF_SURFACES:
        pixels = matplotlib.image.imread(finished[0] / "figures" / f"{name}.png")[:, :, :3]
        assert pixels.shape[1] > 1000 and pixels.var() > 0.003, name


@pytest.mark.long
@pytest.mark.skipif(not CAN_DRAW, reason="no display and no Xvfb: surface figures can't be drawn")
def test_surfaces_show_muscle_bone_and_depth(finished):
    pixels = matplotlib.image.imread(finished[0] / "figures" / "fig_6_iliacus.png")[:, :-300, :3]
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    assert np.mean((red > 1.4 * green) & (red > 1.4 * blue)) > 0.01  # muscle
    assert np.mean((blue > 1.3 * red) & (blue > 0.3)) > 0.0005  # depth
    assert np.mean((red < 0.95) & (red > blue * 1.08) & (np.abs(red - green) < 0.1)) > 0.01  # bone


@pytest.mark.long
def test_rows_of_figures_hold_the_frames(finished):
    rows = pd.read_csv(finished[0] / "figures" / "fig_7_collision_time.csv")
    assert set(rows["backend"]) == {"voxel", "sdf", "bvh", "fcl", "fcl as advised"} and set(rows["muscle"]) == {"iliacus"}
    assert (rows[rows["backend"] == "sdf"]["collision_ns"] == 3_000_000).all() and len(rows) == 60


def test_complete_cases_are_skipped_until_something_changes(in_process, tmp_path):
    assert len(in_process()[3]) == 2 * A_MUSCLE
    assert in_process()[3] == []
    assert len(in_process("--force")[3]) == 2 * A_MUSCLE
    shutil.rmtree(tmp_path / "out" / "raw" / "iliacus-sdf")
    assert in_process()[3] == ["iliacus-sdf"]
    sealed = tmp_path / "out" / "raw" / "gluteus_medius-fcl" / "case.json"
    sealed.write_text(json.dumps({**json.loads(sealed.read_text()), "binary_sha256": "of another build"}))
    assert in_process()[3] == ["gluteus_medius-fcl"]


def test_a_quick_look_does_not_replace_a_finished_study(in_process, tmp_path):
    assert in_process()[0] == 0
    kept = contents(tmp_path / "out")
    code, _, errors, calls = in_process("--frames-limit", "14")
    assert code == 2 and calls == [] and contents(tmp_path / "out") == kept
    assert re.search(r"paper: \S+out: holds a study of other settings \(frames_limit 12, now 14\).*--out.*--force\n$", errors)
    code, text, errors, calls = in_process("--frames-limit", "14", "--force")
    assert code == 0 and len(calls) == 2 * A_MUSCLE, errors
    assert "squeezed into 14 frames" in text and "squeezed into 14 frames" in (tmp_path / "out/tables/table_2_times.md").read_text()


def contents(folder: Path) -> dict:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.long
def test_another_muscle_adds_to_a_study(tmp_path, in_process):
    assert in_process()[0] == 0
    few = ["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--frames-limit", "12"]
    (tmp_path / "log").write_text("")
    assert paper.main([*few, "--muscle", "adductor_brevis"]) == 0
    calls = [line.split()[0] for line in (tmp_path / "log").read_text().splitlines()]
    assert len(calls) == A_MUSCLE and all(call.startswith("adductor_brevis-") for call in calls)
    assert set(pd.read_csv(tmp_path / "out/runs.csv")["muscle"]) == {"iliacus", "gluteus_medius", "adductor_brevis"}
    planned = json.loads((tmp_path / "out/experiment.json").read_text())["cases"]
    assert len(planned) == 3 * A_MUSCLE
    assert in_process()[3] == []


@pytest.mark.long
def test_cases_of_another_program_are_kept_on_request(in_process, tmp_path):
    assert in_process()[0] == 0
    raw = tmp_path / "out" / "raw"
    for name in ("iliacus-voxel", "iliacus-sdf"):
        sealed = raw / name / "case.json"
        sealed.write_text(json.dumps({**json.loads(sealed.read_text()), "binary_sha256": "0123456789 of another"}))
    shutil.rmtree(raw / "iliacus-fcl")
    code, text, errors, calls = in_process("--keep-cases")
    assert (code, calls) == (0, ["iliacus-fcl"]), errors
    assert "Cases of 2 programs, whose times and answers may differ: " in text and "2 of " in text and "(binary 01234567)" in text
    code, text, _, calls = in_process()
    assert sorted(calls) == ["iliacus-sdf", "iliacus-voxel"] and "programs, whose times" not in text


@pytest.mark.long
def test_a_table_that_the_study_has_no_more_is_removed(in_process, tmp_path):
    out = tmp_path / "out"
    assert in_process()[0] == 0
    noted = json.loads((out / "written.json").read_text())
    assert "tables/table_2_times.csv" in noted
    for name in ("tables/old.csv", "tables/mine.csv", "figures/old.png"):
        (out / name).write_text("x")
    (out / "written.json").write_text(json.dumps([*noted, "tables/old.csv", "figures/old.png", "../log", "raw/iliacus-sdf/run.json"]))
    assert in_process()[0] == 0
    assert not (out / "tables/old.csv").exists() and not (out / "figures/old.png").exists()
    assert (out / "tables/mine.csv").exists() and (out / "raw/iliacus-sdf/run.json").exists() and (tmp_path / "log").exists()


@pytest.mark.long
def test_two_commands_in_one_folder_are_told_apart_to_the_end(in_process, tmp_path, monkeypatch):
    """While tables and figures are made, too."""
    refused = []

    def draw(kind, out_dir, names):
        refused.append(run_paper(out_dir, "--muscle", "iliacus"))
        return []
    monkeypatch.setattr(paper, "draw_in_display", draw)
    assert paper.main(["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), "--frames-limit", "12", "--muscle", "iliacus"]) == 0
    assert refused[0].returncode == 2 and "another run writes there" in refused[0].stderr


def test_failures_become_rows_and_the_others_go_on(in_process, tmp_path):
    behaviour = "iliacus-voxel=crash gluteus_medius-sdf=diverge"
    code, text, errors, _ = in_process(behaviour=behaviour)
    rows = pd.read_csv(tmp_path / "out" / "runs.csv").set_index(["muscle", "configuration"])
    assert code == 1 and len(rows) == 2 * A_MUSCLE and (rows["status"] == "ok").sum() == 2 * A_MUSCLE - 2
    assert rows.loc[("iliacus", "voxel"), "status"] == "failed"
    assert "key 'x': no such thing" in rows.loc[("iliacus", "voxel"), "status_detail"]
    assert rows.loc[("gluteus_medius", "sdf"), "status"] == "diverged"
    assert "synthetic/iliacus with voxel: failed, exit code 2" in errors
    again = in_process()
    assert again[0] == 0 and sorted(again[3]) == ["gluteus_medius-sdf", "iliacus-voxel"]


def test_a_case_that_hangs_is_stopped_and_said_so(tmp_path, monkeypatch):
    monkeypatch.setenv("FAKE_BEHAVIOUR", "iliacus-sdf=hang")
    case = one_of("paper", fake_registry.scene("synthetic/iliacus", 12), "sdf")
    assert run_cases([case], Experiment(PROGRAM, Folders(tmp_path)), Limits([0], 1.0)) == {case: "timeout"}
    assert run_folder.read_run(tmp_path / "raw" / case.name).record["status_detail"].startswith("stopped after")


@pytest.mark.long
def test_an_interrupt_ends_the_children_and_leaves_no_half_folder(tmp_path):
    environment = {**os.environ, "FAKE_BEHAVIOUR": " ".join(f"{case.name}=hang" for case in swept("paper")),
                   "FAKE_LOG": str(tmp_path / "log")}
    command = [sys.executable, paper.__file__, "--musclebench", str(PROGRAM), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 30
    while not list(tmp_path.glob("out/raw/.*/run")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130 and "interrupted" in errors
    assert list((tmp_path / "out" / "raw").iterdir()) == []
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout
    assert str(tmp_path) not in listed


@pytest.mark.parametrize("arguments, words", [
    (["--musclebench", "/no/such/program"], "no such program"),
    (["--musclebench", str(PROGRAM), "--data", "/no/such/data"], "lhdl.json"),
    (["--musclebench", str(PROGRAM), "--jobs", "0"], "--jobs 0"),
    (["--musclebench", str(PROGRAM), "--frames-limit", "-3"], "--frames-limit -3"),
    (["--musclebench", str(PROGRAM), "--out", "/proc/here"], "/proc/here"),
    (["--musclebench", str(PROGRAM), "--jobs", "two"], "--jobs: invalid int value: 'two'"),
])
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, capsys):
    assert paper.main(arguments) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1 and words in errors


def test_moments_are_the_rest_the_half_and_the_full_angle():
    shots = [snapshots.Snapshot(f, a, None, []) for f, a in ((0, 0.0), (40, 23.0), (79, 45.3), (157, 90.0))]
    chosen = surface_figures.choose_moments(shots)
    assert (chosen.rest.frame, chosen.half.frame, chosen.full.frame) == (0, 79, 157)
    assert surface_figures.choose_moments([]) is None


@pytest.mark.parametrize("angles", [(0.0, -23.0, -45.3, -90.0), (20.0, -3.0, -25.3, -70.0)])
def test_full_flexion_is_the_largest_turn_whichever_way(angles):
    shots = [snapshots.Snapshot(f, a, None, []) for f, a in zip((0, 40, 79, 157), angles)]
    chosen = surface_figures.choose_moments(shots)
    assert (chosen.rest.frame, chosen.half.frame, chosen.full.frame) == (0, 79, 157)


@pytest.mark.parametrize("angle_deg, text", [(45.29, "45.3°"), (46.0, "46°"), (-0.001, "0°")])
def test_a_title_has_the_angle_of_its_frame(angle_deg, text):
    assert surface_figures._degrees(angle_deg) == text


def test_depth_colours_begin_where_nodes_are_inside():
    colours = surface_pictures.depth_colours(np.array([-1.0, 0.01, 0.05, 4.0, 40.0]), 4.0)
    assert np.array_equal(colours[0], surface_pictures.MUSCLE_COLOUR) and np.array_equal(colours[0], colours[1])
    assert colours[2][2] > colours[2][0] and np.array_equal(colours[3], colours[4])


def test_the_depth_scale_leaves_out_the_control_without_collision():
    def moments(depth_mm):
        mesh = type("Mesh", (), {"extra": {"depth_m": np.array([depth_mm / 1e3])}})()
        return surface_figures.Moments(*[snapshots.Snapshot(0, 0.0, mesh, [])] * 3)

    assert surface_figures.depth_scale_mm({("iliacus", "null"): moments(30), ("iliacus", "sdf"): moments(2.4)}) == 3
    assert surface_figures.depth_scale_mm({"null": moments(30), "sdf": moments(0.1)}) == 1
    assert surface_figures.depth_scale_mm({"voxel": moments(14)}) == surface_figures.DEEPEST_SHOWN_MM


@pytest.mark.long
@pytest.mark.skipif(not CAN_DRAW, reason="no display and no Xvfb")
def test_a_kill_while_surfaces_are_drawn_leaves_nobody_at_work(tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, paper.__file__, "--musclebench", str(PROGRAM), "--out", str(out), "--frames-limit", "12",
               "--muscle", "iliacus"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def started_from(parent) -> set[int]:
        lines = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True).stdout.splitlines()[1:]
        return {int(line.split()[0]) for line in lines if line.split()[1] == str(parent)
                and ("draw_pictures.py" in line or "Xvfb" in line)}

    deadline = time.monotonic() + 60
    while len(drawing := started_from(process.pid)) < 2:
        assert time.monotonic() < deadline and process.poll() is None, "it never drew"
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait(20)
    while any(Path(f"/proc/{pid}/stat").exists() and Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
              for pid in drawing):
        assert time.monotonic() < deadline, "the drawing lives on"
        time.sleep(0.05)
