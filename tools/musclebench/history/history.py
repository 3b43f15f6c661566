"""The history of measured nights: one SQLite file, one row a case, metric and night.

A night is one transaction in a write-ahead log: it is there whole or not at all, whenever the process is killed."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from datetime import datetime, timezone
from pathlib import Path

import pandas as pd

from ..program.cli import Problem

SCHEMA = 1
APPLICATION = 0x6D627368  # 'mbsh': no other SQLite file has it
WAIT_SECONDS = 5.0  # for another process that writes
STARTED = "%Y-%m-%dT%H:%M:%SZ"
TABLES = """
CREATE TABLE night (
  id INTEGER PRIMARY KEY, started TEXT NOT NULL UNIQUE, git TEXT NOT NULL, program_sha256 TEXT NOT NULL,
  machine TEXT NOT NULL, compiler TEXT NOT NULL, busy_runs INTEGER NOT NULL, runs INTEGER NOT NULL);
CREATE TABLE measure (
  night INTEGER NOT NULL REFERENCES night(id), case_name TEXT NOT NULL, metric TEXT NOT NULL, kind TEXT NOT NULL,
  unit TEXT NOT NULL, value REAL, text TEXT, low REAL, high REAL, quartile REAL, runs INTEGER, variation REAL,
  PRIMARY KEY (night, case_name, metric)) WITHOUT ROWID;
CREATE TABLE finding (
  night INTEGER NOT NULL REFERENCES night(id), case_name TEXT NOT NULL, metric TEXT NOT NULL,
  changed_in INTEGER NOT NULL REFERENCES night(id), found_by TEXT NOT NULL, before TEXT NOT NULL, after TEXT NOT NULL,
  ratio REAL, low REAL, high REAL, chance REAL,
  PRIMARY KEY (night, case_name, metric, changed_in)) WITHOUT ROWID;
"""


@dataclass(frozen=True)
class Night:
    started: str  # UTC, as in 2026-11-26T01:30:00Z
    git: str
    program_sha256: str
    machine: str  # CPU and number of cores; only nights of one are a series
    compiler: str
    busy_runs: int = 0  # during which the machine was busy with something else
    runs: int = 0
    id: int = 0


@dataclass(frozen=True)
class Measure:
    case: str
    metric: str
    kind: str
    unit: str
    value: float | None = None  # median over the runs
    text: str | None = None  # of an answer that has to be the same
    low: float | None = None  # 95 % interval of the median
    high: float | None = None
    quartile: float | None = None  # the lower one: other work on the machine only adds time, and adds less to it
    runs: int | None = None
    variation: float | None = None  # standard deviation over mean, from run to run


@dataclass(frozen=True)
class Finding:
    """Something changed: in which night, by how much, how sure."""

    case: str
    metric: str
    changed_in: int  # id of the first night that has it
    found_by: str
    before: str
    after: str
    ratio: float | None = None  # after over before
    low: float | None = None
    high: float | None = None
    chance: float | None = None


class History:
    """Open in `opened`."""

    def __init__(self, connection: sqlite3.Connection):
        self._connection = connection

    def append(self, night: Night, measures: list[Measure]) -> int:
        """The night's id. Nobody else sees it before the history is closed."""
        cursor = self._connection.execute(
            "INSERT INTO night (started, git, program_sha256, machine, compiler, busy_runs, runs) VALUES (?, ?, ?, ?, ?, ?, ?)",
            astuple(night)[:7])
        self._connection.executemany("INSERT INTO measure VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                                     [(cursor.lastrowid, *astuple(measure)) for measure in measures])
        return cursor.lastrowid

    def note(self, night: int, findings: list[Finding]) -> None:
        """What was reported after that night."""
        self._connection.executemany("INSERT INTO finding VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                                     [(night, *astuple(finding)) for finding in findings])

    def nights(self, machine: str | None = None) -> list[Night]:
        """The oldest first."""
        rows = self._connection.execute(
            "SELECT started, git, program_sha256, machine, compiler, busy_runs, runs, id FROM night "
            "WHERE machine = coalesce(?, machine) ORDER BY id", (machine,)).fetchall()
        return in_order([Night(*row) for row in rows], now())

    def has(self, started: str) -> bool:
        return bool(self._connection.execute("SELECT 1 FROM night WHERE started = ?", (started,)).fetchone())

    def measures(self, machine: str) -> pd.DataFrame:
        """Columns night (id), case, metric, kind, unit, value, text, low, high, quartile, runs, variation; the oldest night
        first."""
        rows = self._connection.execute(
            "SELECT night, case_name, metric, kind, unit, value, text, low, high, quartile, measure.runs, variation FROM measure "
            "JOIN night ON night.id = measure.night WHERE machine = ? ORDER BY case_name, metric", (machine,))
        table = pd.DataFrame(rows.fetchall(), columns=["night", "case", "metric", "kind", "unit", "value", "text", "low", "high",
                                                       "quartile", "runs", "variation"])
        order = {night.id: number for number, night in enumerate(self.nights(machine))}
        table = table.sort_values("night", kind="stable", key=lambda ids: ids.map(order), ignore_index=True)
        return table.astype(dict.fromkeys(("value", "low", "high", "quartile", "variation"), float))  # unknown is NaN

    def findings(self) -> list[Finding]:
        rows = self._connection.execute("SELECT case_name, metric, changed_in, found_by, before, after, ratio, low, high, "
                                        "chance FROM finding ORDER BY night, case_name, metric")
        return [Finding(*row) for row in rows.fetchall()]


def now() -> str:
    return datetime.now(timezone.utc).strftime(STARTED)


def in_order(nights: list[Night], moment: str) -> list[Night]:
    """The oldest first. `nights`: as they were added, which may be later than they were measured. The clock was wrong where a
    night is stamped after the present `moment`: such a night stays in front of the one that was added next."""
    keys: list[str] = []
    for night in reversed(nights):
        was_wrong = keys and night.started > moment
        keys.append(min(night.started, keys[-1]) if was_wrong else night.started)
    return [night for _, _, night in sorted(zip(reversed(keys), range(len(nights)), nights), key=lambda one: one[:2])]


@contextmanager
def opened(path: Path, is_written: bool = True) -> Iterator[History]:
    """Made where there is none. What was appended and not committed is gone after an exception."""
    connection = None
    try:
        if not is_written and not (path.is_file() and path.stat().st_size):
            raise Problem(f"{path}: {'empty' if path.is_file() else 'no such history'}; tools/nightly makes one")
        path.parent.mkdir(parents=True, exist_ok=True)
        connection = sqlite3.connect(path, timeout=WAIT_SECONDS, isolation_level=None)
        _prepare(connection, path)
        connection.execute("BEGIN IMMEDIATE" if is_written else "BEGIN")
        yield History(connection)
        connection.execute("COMMIT")
    except sqlite3.DatabaseError as problem:
        raise Problem(f"{path}: {_cure(problem)}") from None
    finally:
        if connection is not None:
            connection.close()  # rolls back what is not committed


def _prepare(connection: sqlite3.Connection, path: Path) -> None:
    schema, = connection.execute("PRAGMA user_version").fetchone()
    application, = connection.execute("PRAGMA application_id").fetchone()
    tables, = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    if tables and application != APPLICATION:
        raise Problem(f"{path}: a database of something else; name another file with --history")
    if schema > SCHEMA:
        raise Problem(f"{path}: a history of schema {schema}, these tools read up to {SCHEMA}; use newer tools, or another "
                      "--history")
    damage = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if damage != "ok":
        raise Problem(f"{path}: damaged ({damage}); restore it from a copy, or begin a new one with --history")
    if not tables:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.executescript(f"BEGIN IMMEDIATE; {TABLES} PRAGMA application_id = {APPLICATION}; "
                                 f"PRAGMA user_version = {SCHEMA}; COMMIT;")
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA foreign_keys = ON")


def _cure(problem: sqlite3.DatabaseError) -> str:
    words = str(problem)
    if "locked" in words or "busy" in words:
        return "another process writes it; try again when that has ended (--append FOLDER takes what was measured)"
    if "not a database" in words:
        return "no SQLite file; name another one with --history"
    if "malformed" in words or "disk image" in words:
        return f"damaged ({words}); restore it from a copy, or begin a new one with --history"
    return words
