"""The history of nights: what was appended is there, whole, whatever happens; what is no history is refused."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from musclebench.history.history import Finding, Measure, Night, in_order, opened
from musclebench.program.cli import Problem

TOOLS = Path(__file__).resolve().parent.parent
MACHINE = "A processor, 2 cores"


def night(number: int, machine: str = MACHINE) -> Night:
    return Night(f"2026-01-01T{number // 60:02}:{number % 60:02}:00Z", f"commit{number}", "digest", machine, "cc")


MEASURES = [Measure("ball-tree", "frame_ns", "time", "ns", 5.0, None, 4.0, 6.0, 4.5, 10, 0.01),
            Measure("ball-tree", "state_hash", "exact", "", text="0123")]


def append(path: Path, *nights: Night) -> None:
    with opened(path) as history:
        for one in nights:
            history.append(one, MEASURES)


def test_what_was_appended_is_read_in_order_of_time_and_by_machine(tmp_path):
    append(tmp_path / "h", night(2), night(1), night(3, "Another"))
    with opened(tmp_path / "h", is_written=False) as history:
        assert [one.git for one in history.nights(MACHINE)] == ["commit1", "commit2"] and len(history.nights()) == 3
        rows = history.measures(MACHINE)
        assert list(rows["night"]) == [2, 2, 1, 1] and set(rows["text"].dropna()) == {"0123"}
        assert rows.loc[0, ["value", "low", "high", "quartile", "runs", "variation"]].tolist() == [5.0, 4.0, 6.0, 4.5, 10, 0.01]
        assert history.has(night(1).started) and not history.has(night(9).started)


def test_nights_of_a_wrong_clock_stay_where_they_were_added(tmp_path):
    """Two were stamped after now, and then one long before the others; one was added late."""
    def stamped(*moments: str) -> list[str]:
        nights = [Night(moment, "", "", MACHINE, "cc", id=number) for number, moment in enumerate(moments)]
        return [one.started for one in in_order(nights, "2026-06-01")]

    assert stamped("2026-01-01", "2099-01-02", "2098-01-01", "2026-01-04") == ["2026-01-01", "2099-01-02", "2098-01-01", "2026-01-04"]
    assert stamped("2026-01-01", "2026-01-03", "2026-01-02") == ["2026-01-01", "2026-01-02", "2026-01-03"]
    assert stamped("2026-01-01", "2099-01-01") == ["2026-01-01", "2099-01-01"]
    assert stamped("2026-07-01", "2026-07-02", "1970-01-01") == ["2026-07-01", "2026-07-02", "1970-01-01"]
    assert stamped("2026-01-01", "2099-01-01", "2026-01-05", "2026-01-04") == ["2026-01-01", "2026-01-04", "2099-01-01", "2026-01-05"]


def test_findings_are_kept(tmp_path):
    found = Finding("ball-tree", "frame_ns", 1, "change point", "1 us", "2 us", 2.0, 1.9, 2.1, 1e-6)
    with opened(tmp_path / "h") as history:
        history.note(history.append(night(1), MEASURES), [found])
    with opened(tmp_path / "h") as history:
        assert history.findings() == [found]


def test_the_same_night_twice_is_refused_and_nothing_of_it_stays(tmp_path):
    append(tmp_path / "h", night(1))
    with pytest.raises(Problem, match="UNIQUE"):
        append(tmp_path / "h", night(2), night(1))
    with opened(tmp_path / "h") as history:
        assert len(history.nights()) == 1


WRITER = """
import sys; sys.path.insert(0, {tools!r}); sys.path.insert(0, {tests!r})
from test_history import *
print('begun', flush=True)
for number in range({first}, {first} + 1000):
    with opened(Path({path!r})) as history:
        history.append(night(number), [Measure(f'case{{i}}', 'frame_ns', 'time', 'ns', float(i)) for i in range(300)])
"""


def test_killed_at_any_moment_it_has_whole_nights_only(tmp_path):
    path, last = tmp_path / "h", 0
    for round_ in range(5):
        code = WRITER.format(tools=str(TOOLS), tests=str(TOOLS / "tests"), first=last + 1, path=str(path))
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as writer:
            writer.stdout.readline()
            time.sleep(0.013 + 0.037 * round_)
            os.kill(writer.pid, signal.SIGKILL)
        with opened(path) as history:
            nights = [one.git for one in history.nights()]
            assert nights == [f"commit{number}" for number in range(1, len(nights) + 1)]
            assert len(history.measures(MACHINE)) == 300 * len(nights)
            assert len(nights) >= last
            last = len(nights)
    assert last > 0


def test_one_from_the_future_is_refused(tmp_path):
    append(tmp_path / "h", night(1))
    with sqlite3.connect(tmp_path / "h") as connection:
        connection.execute("PRAGMA user_version = 7")
    with pytest.raises(Problem, match="h: a history of schema 7, these tools read up to 1"):
        append(tmp_path / "h", night(2))


def test_a_database_of_something_else_is_left_alone(tmp_path):
    with sqlite3.connect(tmp_path / "h") as connection:
        connection.execute("CREATE TABLE birds (name)")
    with pytest.raises(Problem, match="a database of something else"):
        append(tmp_path / "h", night(1))


def test_what_is_no_database_is_refused(tmp_path):
    (tmp_path / "h").write_text("not SQLite at all, but long enough to have a header of its own\n" * 30)
    with pytest.raises(Problem, match="no SQLite file"):
        append(tmp_path / "h", night(1))


def test_a_truncated_one_is_refused(tmp_path):
    append(tmp_path / "h", *map(night, range(1, 40)))
    whole = (tmp_path / "h").read_bytes()
    for size in (len(whole) // 2, len(whole) - 4096, 5000, 50):
        (tmp_path / "h").write_bytes(whole[:size])
        with pytest.raises(Problem, match="h: (damaged|no SQLite file)"):
            append(tmp_path / "h", night(50))


def test_one_that_another_process_writes_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("musclebench.history.history.WAIT_SECONDS", 0.1)
    append(tmp_path / "h", night(1))
    with opened(tmp_path / "h"):
        with pytest.raises(Problem, match="another process writes it"):
            append(tmp_path / "h", night(2))


def test_reading_makes_no_history(tmp_path):
    with pytest.raises(Problem, match="no such history"):
        with opened(tmp_path / "h", is_written=False):
            pass
    assert not (tmp_path / "h").exists()
    (tmp_path / "empty").touch()
    with pytest.raises(Problem, match="empty"):
        with opened(tmp_path / "empty", is_written=False):
            pass
    assert (tmp_path / "empty").stat().st_size == 0
