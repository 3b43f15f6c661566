"""A run that other work disturbed says so, below every table of times and in Fig. 7."""

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fake_study import REPLAYED, SCENES, replays_of, write_muscles
from musclebench.accuracy import report
from musclebench.effects.effect_runs import MeasuredSet
from musclebench.figures import paper_figures
from musclebench.paper import published
from musclebench.program import machine_state
from musclebench.program.machine_state import last_core, reading, told_between
from musclebench.results import disturbance, run_folder
from musclebench.tables import paper_tables

QUIET = {"machine": {"cores": 2}, "wall_ns": 10e9,
         "machine_state": {"involuntary_context_switches": 20, "load_average_1m": {"before": 1.1, "after": 1.0},
                           "cpu_mhz": {"before": 2500.0, "after": 2500.0}}}


def state(**changes) -> dict:
    return QUIET | {"machine_state": QUIET["machine_state"] | changes}


def test_what_a_time_depends_on_is_read_where_the_system_tells(tmp_path, monkeypatch):
    monkeypatch.setattr(machine_state, "CPU_FOLDER", tmp_path)
    unknown = machine_state.settings_of(1)
    assert (unknown["core"], unknown["turbo"], unknown["smt"], unknown["governor"]) == (1, None, None, None)
    for name, text in (("smt/active", "1"), ("intel_pstate/no_turbo", "1"), ("cpu1/cpufreq/scaling_governor", "powersave")):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(f"{text}\n")
    told = machine_state.settings_of(1)
    assert (told["turbo"], told["smt"], told["governor"]) == (False, True, "powersave")
    (tmp_path / "cpufreq").mkdir()
    (tmp_path / "cpufreq/boost").write_text("1\n")
    assert machine_state.settings_of(1)["turbo"] is True


def note_state(folder, **changes) -> None:
    record = json.loads((folder / "run.json").read_text())
    told = state(**changes)
    (folder / "run.json").write_text(json.dumps(record | {key: told[key] for key in ("machine_state", "wall_ns")}))


@pytest.mark.parametrize("record, words", [
    (QUIET, ""), ({}, ""), ({"machine_state": None}, ""),
    (state(involuntary_context_switches=3000), "interrupted 300 times a second"),
    (state(involuntary_context_switches=4) | {"wall_ns": 1e7}, ""),
    (state(involuntary_context_switches=5) | {"wall_ns": 1e7}, "interrupted 500 times a second"),
    (state(load_average_1m={"before": 0.5, "after": 4.0}), "load 4.0 on 2 cores"),
    (state(cpu_mhz={"before": 1200.0, "after": None}), "clock 1200 MHz, usually 2500"),
])
def test_a_run_is_disturbed_by_switches_load_or_a_slow_clock(record, words):
    assert disturbance.disturbance(record, 2500.0) == words


def test_frames_in_which_the_process_waited_are_in_no_mean_of_an_effect():
    frames = pd.DataFrame({"frame": range(1, 41), "warm_up": 0, "frame_ns": 2e6, "detect_ns": 1e6, "update_ns": 0.0, "respond_ns": 0.0,
                           "bending_ns": 5e5})
    frames.loc[frames["frame"] == 20, ["frame_ns", "detect_ns", "bending_ns"]] *= 50
    one = MeasuredSet("scene", "muscle", None, [run_folder.Run(Path("run"), {"status": "ok"}, frames)])
    assert (one.mean_frame_ms, one.collision_ms, one.effect_ms("bending")) == pytest.approx((2, 1, 0.5))


def test_the_usual_clock_is_that_of_most_runs():
    runs = {"a": state(), "b": state(), "c": state(cpu_mhz={"before": 2500.0, "after": 1000.0})}
    assert disturbance.disturbed(runs) == {"c": "clock 1000 MHz, usually 2500"}


def test_switches_between_two_readings_are_those_of_the_child_that_ended():
    before = reading(last_core())
    subprocess.run(["sleep", "0.01"], check=True)
    told = told_between(before, reading(last_core()))
    assert told["machine_state"]["voluntary_context_switches"] >= 1 and told["wall_ns"] > 1e7
    assert set(told["machine_state"]) == {"involuntary_context_switches", "voluntary_context_switches",
                                          "load_average_1m", "cpu_mhz", "governor"}
    assert told["machine_state"]["load_average_1m"]["after"] >= 0


def test_frames_in_which_the_process_waited_are_told_from_slow_ones():
    times = pd.Series(np.linspace(1e6, 3e6, 100))
    times[[20, 21, 70]] += 4e6  # slices of a scheduler
    assert list(times.index[disturbance.waits(times)]) == [20, 21, 70]
    assert not disturbance.waits(pd.Series(np.linspace(1e8, 3e8, 100))).any()


def test_the_paper_marks_busy_runs_and_says_so(fake_raw):
    note_state(fake_raw / "iliacus-sdf", involuntary_context_switches=5000)
    runs = run_folder.read_runs(fake_raw)
    rows = paper_tables.time_table(runs, published.read_published()).rows.set_index(["muscle", "backend"])
    assert rows.loc[("iliacus", "sdf"), "status"] == "ok *" and rows.loc[("iliacus", "voxel"), "status"] == "ok"
    line = disturbance.note(paper_tables.disturbed_runs(runs), len(runs))
    assert "busy in 1 of 16 runs" in line and "iliacus-sdf (interrupted 500 times a second)" in line


def test_fig_7_leaves_waiting_out_of_its_lines(fake_raw, tmp_path):
    folder = fake_raw / "iliacus-voxel"
    frames = pd.read_csv(folder / "frames.csv")
    frames.loc[10, "detect_ns"] += 8_000_000
    frames.to_csv(folder / "frames.csv", index=False)
    files = paper_figures.draw_figures(run_folder.read_runs(fake_raw), published.read_published(), tmp_path)
    drawing = next(path for path in files if path.name == "fig_7_collision_time.svg").read_text()
    assert "crosses: 1 frame in which the process waited" in " ".join(re.sub("<[^>]+>", " ", drawing).split())


@pytest.mark.long
def test_the_study_marks_busy_cases_and_says_so(tmp_path):
    study = tmp_path
    write_muscles(study, with_own_runs=True)
    note_state(study / "raw" / "iliacus-sdf 64-r0", load_average_1m={"before": 7.0, "after": 7.0})
    report.write_report(study)
    text = (study / "tables" / "price_list.txt").read_text()
    assert "sdf 64 *" in text and f"busy in 1 of {3 * len(SCENES) * len(REPLAYED)} runs" in text
    assert sum(aggregate.is_disturbed for aggregate in replays_of(study)) == 1
