"""tools/nightly: three nights of a stand-in with a slowdown on the third; answers, cells and counters that change; what
goes wrong; and nights drawn from noise that was recorded."""

import csv
import json
import sqlite3
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import nightly
from musclebench.comparison import interleaved
from musclebench.history import simulation
from musclebench.history.detection import ALL_CASES, WINDOW, counter_findings, gone_findings, new_ones, step_findings
from musclebench.history.history import Finding, opened
from musclebench.history.nights import measures_of
from musclebench.history.one_night import keep_program, kept_program
from musclebench.history.simulation import REPETITIONS
from musclebench.program.fingerprint import file_digest
from test_compare import SCENE, program
from test_verdicts import drawn


@pytest.fixture(scope="module", autouse=True)
def nothing_is_counted():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(interleaved, "why_not_by_callgrind", lambda: "left out of this test")
        yield


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    """A night a call."""
    class Clock:
        now_ = pd.Timestamp("2026-01-01", tz="UTC")

        @classmethod
        def now(cls, _):
            cls.now_ += pd.Timedelta(days=1)
            return cls.now_.to_pydatetime()
    monkeypatch.setattr(nightly, "datetime", Clock)
    return Clock


def run(folder: Path, one: str, *more) -> int:
    return nightly.main(["--out", str(folder / "out"), "--musclebench", one, "--repetitions", "8", "--scene", SCENE, *more])


def findings(folder: Path) -> list[Finding]:
    with opened(folder / "out" / "history.sqlite", is_written=False) as history:
        return history.findings()


def test_three_nights_with_a_slowdown_on_the_third(tmp_path, capsys):
    first, two = program(tmp_path, "a", git="aaa"), ("--backend", "tree", "--backend", "grid", "--no-hard")
    assert [run(tmp_path, first, "--repetitions", "1", *two) for _ in range(2)] == [0, 0]
    assert "nothing changed" in capsys.readouterr().out
    assert run(tmp_path, program(tmp_path, "b", git="bbb", slower={"tree": 1.1}), *two) == 1
    text = capsys.readouterr().out
    assert "| resting_contact-tree | collision_ns | 2026-01-04T00:00:00Z | " in text and " us | 1.1" in text
    assert "Commits between 2026-01-03T00:00:00Z (aaa) and 2026-01-04T00:00:00Z (bbb)" in text
    found = findings(tmp_path)
    assert {one.case for one in found} == {"resting_contact-tree"}
    assert {one.found_by for one in found} == {"beside the last night's program"}
    assert next(one for one in found if one.metric == "collision_ns").ratio == pytest.approx(1.1, abs=0.02)
    # What other tools read of the three nights.
    out = tmp_path / "out"
    rows = list(csv.DictReader((out / "otava" / "resting_contact-tree.csv").open()))
    assert [row["commit"] for row in rows] == ["aaa", "aaa", "bbb"] and float(rows[2]["collision_ns"]) > 1e5
    told = (out / "otava" / "otava.yaml").read_text()
    assert "type: csv" in told and "time_column: time" in told and "attributes: [commit]" in told
    metric = json.loads((out / "bencher.json").read_text())["resting_contact-tree"]["collision_ns"]
    assert metric["lower_value"] <= metric["value"] <= metric["upper_value"]
    # The same change is not new again.
    assert nightly.main(["--out", str(out), "--report-only"]) == 0
    assert "### Reported before" in capsys.readouterr().out


QUICK = ("--repetitions", "1", "--no-hard", "--backend", "tree")


def first_line(capsys) -> str:
    """Of the last report."""
    return [line for line in capsys.readouterr().out.splitlines() if line.startswith("## Night")][-1]


def test_a_backend_that_vanished_is_in_the_first_line(tmp_path, capsys):
    one = program(tmp_path, "a")
    assert run(tmp_path, one, "--repetitions", "1", "--backend", "tree", "--backend", "grid") == 0
    assert "vanished" not in first_line(capsys)
    assert run(tmp_path, one, *QUICK) == 1  # without the matrix, which is no case that vanished
    assert "1 case vanished (resting_contact-grid)" in first_line(capsys)
    assert run(tmp_path, one, *QUICK) == 0
    assert run(tmp_path, one, "--repetitions", "1", "--backend", "grid") == 1
    assert "1 case vanished (resting_contact-tree)" in first_line(capsys)


def test_a_cell_of_the_matrix_that_vanished_is_told(tmp_path, capsys):
    table = nights({"hard/thin/a": [0, 0], "hard/thin/b": [0], "c-counted": [0], "c": [np.nan, 0]})
    table = table[table["value"].notna()]
    assert [one.case for one in gone_findings(table)] == ["hard/thin/b"]
    assert gone_findings(table[~((table["case"] == "hard/thin/a") & (table["night"] == 2))]) == []  # the matrix was not run
    assert gone_findings(table[table["night"] == 1]) == []


@pytest.mark.long
def test_a_night_stamped_in_the_future_does_not_blind_later_ones(tmp_path, capsys, clock):
    a, b, c = (program(tmp_path, name, hash={"tree": name}) for name in "abc")
    assert run(tmp_path, a, *QUICK) == 0
    clock.now_ = pd.Timestamp("2099-01-01", tz="UTC")
    assert run(tmp_path, a, *QUICK) == 0
    assert "it is stamped after now" in first_line(capsys)
    clock.now_ = pd.Timestamp("2026-01-05", tz="UTC")
    for later, changed, words in ((b, 1, "the clock ran backwards: the night before is stamped 2099-01-02T00:00:00Z"), (b, 0, "nothing changed"),
                                  (c, 1, "1 figure changed")):
        assert run(tmp_path, later, *QUICK) == changed
        line = first_line(capsys)
        assert words in line and ("2099" in line) is ("2099" in words)
    assert [(one.before, one.after) for one in findings(tmp_path)] == [("a", "b"), ("b", "c")]


def test_a_night_too_small_to_show_anything_says_so(tmp_path, capsys):
    for few, words in (("6", "6 repetitions can't show a slower or faster time the same night, 7 can"), ("7", "nothing changed")):
        assert run(tmp_path, program(tmp_path, "a"), "--backend", "tree", "--no-hard", "--repetitions", few) == 0
        line = first_line(capsys)
        assert words in line and ("can't" in line) is ("can't" in words)


def test_answers_and_cells_that_change_are_found_the_same_night(tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a"), "--repetitions", "1") == 0
    assert run(tmp_path, program(tmp_path, "b", hash={"grid": "99"}, depth={"tree": 0.0010000001}, cells={"plain": "breaks"}),
               "--repetitions", "1") == 1
    assert {(one.case, one.metric, one.before, one.after) for one in findings(tmp_path)} == {
        ("resting_contact-grid", "state_hash", "0123", "99"), ("resting_contact-tree", "p99_depth_m", "0.001", "0.0010000001"),
        ("hard/thin-plate/plain", "verdict", "holds", "breaks"),
    }


def test_another_program_of_the_last_night_runs_beside_tonights_and_the_same_does_not(tmp_path):
    first, second = Path(program(tmp_path, "a")), Path(program(tmp_path, "b"))
    keep_program(first, tmp_path)
    kept = kept_program(file_digest(first), second, tmp_path)
    assert kept is not None and kept.read_text() == first.read_text()
    assert kept_program(file_digest(first), first, tmp_path) is None
    keep_program(second, tmp_path)  # that of the night before goes
    assert kept_program(file_digest(first), second, tmp_path) is None


def test_when_time_is_up_five_repetitions_are_whole_and_the_rest_is_left_out(tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a"), "--backend", "tree", "--minutes", "1e-6", "--no-hard") == 0
    assert "5 of 8 repetitions: time was up" in capsys.readouterr().out
    runs = {path.name for path in (tmp_path / "out").glob("nights/*/after/raw/*")}
    assert runs == {"resting_contact-tree-judged", *(f"resting_contact-tree-r{number}" for number in range(5))}


def test_a_matrix_that_takes_too_long_is_left_out(tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a", hard_seconds=60), "--backend", "tree", "--repetitions", "1",
               "--hard-seconds", "0.1") == 0
    assert "the matrix of hard cases took longer than 0.1 s" in capsys.readouterr().out


def test_a_night_whose_history_was_locked_is_added_later(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("musclebench.history.history.WAIT_SECONDS", 0.1)
    one = program(tmp_path, "a")
    assert run(tmp_path, one, "--repetitions", "1", "--no-hard", "--backend", "tree") == 0
    other = sqlite3.connect(tmp_path / "out" / "history.sqlite", isolation_level=None)
    measure = nightly.measure_night

    def locked_meanwhile(*arguments):
        night = measure(*arguments)
        other.execute("BEGIN IMMEDIATE")
        return night
    monkeypatch.setattr(nightly, "measure_night", locked_meanwhile)
    capsys.readouterr()
    assert run(tmp_path, one, "--repetitions", "1", "--no-hard", "--backend", "tree") == 2
    assert "another process writes it" in capsys.readouterr().err
    other.close()
    last = sorted((tmp_path / "out" / "nights").iterdir())[-1]
    assert nightly.main(["--out", str(tmp_path / "out"), "--append", str(last)]) == 0
    assert nightly.main(["--out", str(tmp_path / "out"), "--append", str(last)]) == 2
    assert "has the night" in capsys.readouterr().err
    with opened(tmp_path / "out" / "history.sqlite") as history:
        assert len(history.nights()) == 2


@pytest.mark.parametrize(("prepare", "words"), [
    (lambda path: path.write_text("no history\n" * 100), "no SQLite file"),
    (lambda path: sqlite3.connect(path).executescript("CREATE TABLE a (b)"), "a database of something else"),
])
def test_what_is_no_history_is_told_before_anything_is_measured(prepare, words, tmp_path, capsys):
    (tmp_path / "out").mkdir()
    prepare(tmp_path / "out" / "history.sqlite")
    assert run(tmp_path, program(tmp_path, "a")) == 2
    captured = capsys.readouterr()
    assert words in captured.err and not list((tmp_path / "out").glob("nights/*/*"))


def test_a_build_without_optimisation_and_a_folder_without_a_night_are_refused(tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a", type="Debug"), "--repetitions", "1", "--no-hard") == 2
    assert "times of a build of type Debug say nothing" in capsys.readouterr().err
    assert not list((tmp_path / "out").glob("nights/*/*"))  # before anything was measured
    assert nightly.main(["--out", str(tmp_path / "out"), "--append", str(tmp_path)]) == 2
    assert "no measured night" in capsys.readouterr().err


def nights(values: dict[str, np.ndarray], metric: str = "frame_ns", kind: str = "time") -> pd.DataFrame:
    rows = [{"night": night, "case": case, "metric": metric, "kind": kind, "unit": "", "value": value, "quartile": value, "text": None,
             "variation": 0.0} for case, series in values.items() for night, value in enumerate(series, 1)]
    return pd.DataFrame(rows).sort_values("night", kind="stable")


def noisy(seed: int, count: int = 20) -> np.ndarray:
    return 1e6 * np.exp(np.random.default_rng(seed).normal(0, 0.005, count))


def test_a_night_is_its_lower_quartile():
    """Other work on the machine only adds time, and adds less to it."""
    (measure,) = [one for one in measures_of(drawn({"a": np.array([1.0, 2.0, 3.0, 4.0, 50.0, 60.0, 70.0, 80.0])}))
                  if one.metric == "frame_ns"]
    assert (measure.quartile, measure.value, measure.runs) == (2.0, 27.0, 8)


def test_the_newest_nights_are_looked_at():
    """A change long ago, and one among the last nights."""
    values = noisy(3, WINDOW + 30) * np.where(np.arange(WINDOW + 30) < 10, 2.0, 1.0)
    values[-8:] *= 1.2
    assert [one.changed_in for one in step_findings(nights({"a": values}))] == [WINDOW + 30 - 8 + 1]


def test_what_all_cases_share_is_told_apart_from_a_cases_own():
    steps = {name: noisy(seed) for seed, name in enumerate("abcde")}
    steps["c"][15:] *= 1.1
    for series in steps.values():
        series *= np.exp(0.05 * np.sin(np.arange(20)))  # a machine of good and bad nights
    (found,) = step_findings(nights(steps))
    assert (found.case, found.changed_in) == ("c", 16) and found.low < 1.1 < found.high
    slower = {name: noisy(seed) * np.repeat([1, 1.2], 10) for seed, name in enumerate("abcde")}
    assert {(one.case, one.changed_in) for one in step_findings(nights(slower))} == {(ALL_CASES, 11)}


def test_a_metric_that_a_night_lacks_is_looked_at_where_it_is():
    table = nights({"a": noisy(1) * np.repeat([1, 1.2], 10), "b": noisy(2)})
    gappy = table[~((table["case"] == "a") & table["night"].isin([3, 20]))]
    assert [(one.case, one.changed_in) for one in step_findings(gappy)] == [("a", 11)]
    assert [one.case for one in step_findings(gappy[(gappy["case"] != "b") | (gappy["night"] < 5)])] == ["a"]


def test_a_step_is_reported_once_although_its_place_moves():
    known = [Finding("a", "frame_ns", 10, "change point", "", "")]
    again, another = (Finding("a", "frame_ns", night, "change point", "", "") for night in (11, 15))
    the_same_night = Finding("a", "frame_ns", 11, "counted", "", "")
    assert new_ones([again, another, the_same_night], known, list(range(1, 20))) == [another, the_same_night]


@pytest.mark.parametrize(("last", "variation", "is_found"), [
    (1.02e6, 0.0, True), (1.02e6, np.nan, True), (1.002e6, 0.0, False), (1.02e6, 0.01, False),
])
def test_a_counter_that_does_not_vary_is_found_the_same_night(last, variation, is_found):
    table = nights({"a": [1e6, 1e6, last]}, "instructions", "counter").assign(variation=variation)
    assert bool(counter_findings(table)) is is_found


@pytest.mark.long
def test_recorded_noise_alarms_in_no_month_and_a_slowdown_is_found_in_three_nights():
    noise = simulation.read_noise()
    assert len(noise.times) >= 10 and len(noise.slowed_cases) >= 8
    rates = simulation.simulate(noise, trials=3, nights=30, slowdown=1.1, since=16)
    assert rates.false_alarms == 0 and rates.found_within(3) >= 2
    false_alarms, found, wrong = simulation.compared(noise, trials=4, slowdown=1.1)
    assert false_alarms == 0 and found >= 3 and wrong == 0


def test_noise_is_recorded_as_it_is_read(tmp_path):
    """A program that ran as two; the loop without collision has none to slow."""
    cases = {"a": 1000.0, "loop": 2000.0}
    sides = [drawn({case: np.full(REPETITIONS, factor * value) for case, value in cases.items()}) for factor in (1.0, 1.1)]
    for samples in (samples for side in sides for samples in side.cases.values()):
        for number, sample in enumerate(samples):
            share = 0.5 if sample.run.folder.name.startswith("a") else 0.0
            sample.run.frames = pd.DataFrame({"frame": range(1, 9), "warm_up": 0, "frame_ns": 1e6 + number,
                                              "collision_ns": share * (1e6 + number)})
            sample.values["cpu_ns"] = 7.0
    simulation.noise_rows(*sides).to_csv(tmp_path / "noise.csv", index=False)
    noise = simulation.read_noise(tmp_path / "noise.csv")
    assert noise.collision_shares == {"a": 0.5, "loop": 0.0} and noise.slowed_cases == ["a"]
    assert noise.times["a", "frame_ns"].shape == (REPETITIONS, 2) and noise.times["a", "frame_ns"][3] == pytest.approx([1000003] * 2, abs=1)
    assert ("loop", "collision_ns") not in noise.times
    assert [noise.factor("a", metric, 1.1) for metric in ("collision_ns", "cpu_ns", "build_ns")] == pytest.approx([1.1, 1.05, 1.0])
