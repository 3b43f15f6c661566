"""Results that the pages quote: tables with full precision and where they come from, in reports/measured."""

import json
import shutil
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from pathlib import Path

import pandas as pd

from ..program.cli import Problem
from ..program.fingerprint import write_whole
from ..program.registry import FILE_NAME as REGISTRY, whose
from ..results.disturbance import disturbed
from ..results.records import inner
from ..results.run_folder import implementations_in
from .published_tables import TABLES

SOURCE = "source.json"
KEPT = {"before_ruler-lhdl"}  # what was said before the surface offset was the error; nothing measures it again
ONE_PUBLICATION = ("commit", "machine", "build", "results_schema")  # the same in all studies of one


@dataclass(frozen=True)
class Source:
    """Where the results of a study come from."""

    command: str
    commit: str
    machine: str
    build: str
    date: str
    results_schema: int
    disturbed: int = 0  # runs during which the machine was busy with something else
    unit: str = ""  # the configuration by whose time others are divided
    implementations: dict[str, str] = field(default_factory=dict)  # by backend: whose code it is
    publication: str = ""  # when tools/publish was started that took it over; the same for all that it took over

    def words(self) -> str:
        text = (f"`{self.command}`, commit {self.commit}, {self.machine}, {self.build}, {self.date}, "
                f"results schema {self.results_schema}.")
        busy = f" In {self.disturbed} runs the machine was busy with something else." if self.disturbed else ""
        told = f" {whose(self.implementations)}" if self.implementations else ""
        return f"<sub>{text}{busy}{told}</sub>"

    def short_words(self) -> str:
        """Under a picture, which tells the machine itself."""
        return f"<sub>`{self.command}`, commit {self.commit[:7]}, {self.date}</sub>"


class Measured:
    """Tables by name, such as `paper-lhdl/table_2_times`."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._tables: dict[str, pd.DataFrame] = {}

    @property
    def studies(self) -> list[str]:
        return sorted(path.parent.name for path in self.folder.glob(f"*/{SOURCE}"))

    def has(self, study: str) -> bool:
        return (self.folder / study / SOURCE).is_file()

    def source(self, study: str) -> Source:
        path = self.folder / study / SOURCE
        try:
            return Source(**json.loads(path.read_text()))
        except (OSError, ValueError, TypeError) as problem:
            raise Problem(f"{path}: not the source of a study ({problem}); tools/publish writes it") from None

    def table(self, name: str) -> pd.DataFrame:
        if name not in self._tables:
            path = self.folder / f"{name}.csv"
            try:  # the word null may be a name
                self._tables[name] = pd.read_csv(path, keep_default_na=False, na_values=[""])
            except (OSError, ValueError) as problem:
                raise Problem(f"{path}: can't be read ({problem}); tools/publish writes it") from None
        return self._tables[name]


def adopt(study: str, out_dir: Path, target: Path, command: str, publication: str = "",
          other: Source | None = None) -> Source:
    """Takes the tables of a finished study over into `target`, with the source that its runs name. Raises Problem, and
    takes nothing over, where commit or machine are not those of `other`, a study of the same publication."""
    kind = next((kind for kind in TABLES if study.startswith(f"{kind}-")), None)
    if kind is None:
        raise Problem(f"{study} is no study; there are {', '.join(TABLES)}, each with its data set")
    source = replace(source_of(out_dir, command), unit=_unit(out_dir / "study.csv"), publication=publication)
    if other is not None and (differing := _differing(source, other)):
        raise Problem(f"{study} was measured with another {differing} than {other.command}; remove {out_dir} and run "
                      "tools/publish again")
    target.mkdir(parents=True, exist_ok=True)
    for pattern in TABLES[kind]:
        for path in out_dir.glob(pattern):
            shutil.copyfile(path, target / path.name)
    write_whole(target / SOURCE, json.dumps(vars(source), indent=1) + "\n")
    return source


def _differing(source: Source, other: Source) -> str:
    """The first of what studies of one publication share, with both values; empty where all are the same."""
    ours, theirs = vars(source), vars(other)
    return next((f"{key.replace('_', ' ')} ({ours[key]}, not {theirs[key]})" for key in ONE_PUBLICATION
                 if ours[key] != theirs[key]), "")


def source_of(out_dir: Path, command: str) -> Source:
    """Of the complete runs in the folder, which must be of one commit and machine."""
    named = {path.parent.name: _record(path) for path in sorted((out_dir / "raw").rglob("run.json"))
             if not any(part.startswith(".") for part in path.relative_to(out_dir).parts)}
    every = list(named.values())
    named = {name: record for name, record in named.items() if record.get("build")}
    records = list(named.values())
    if not records:
        raise Problem(f"{out_dir}: holds no complete run; run the study again")
    return Source(
        command, _one(records, out_dir, "commit", "build", "git"), _one(records, out_dir, "machine", "machine", "cpu"),
        _one(records, out_dir, "compiler", "build", "compiler"),
        datetime.now(timezone.utc).date().isoformat(), int(_one(records, out_dir, "schema", "schema_version")),
        len(disturbed(named)), implementations=implementations_in(records) | _asked_implementations(out_dir, every))


def _asked_implementations(out_dir: Path, records: list[dict]) -> dict[str, str]:
    """Of the backends of cells of hard cases, which leave no word of it themselves."""
    asked = {record["case"].get("backend") for record in records if record.get("case", {}).get("mode") == "hard"}
    registry = out_dir / REGISTRY
    known = json.loads(registry.read_text())["backends"] if asked and registry.is_file() else []
    return {one["name"]: one["implementation"] for one in known if one["name"] in asked and one.get("implementation")}


def _unit(study_csv: Path) -> str:
    """What takes exactly its own time."""
    if not study_csv.is_file():
        return ""
    rows = pd.read_csv(study_csv, keep_default_na=False, na_values=[""])
    return next(iter(rows.loc[rows["times_unit"] == 1.0, "configuration"]), "") if "times_unit" in rows else ""


def _record(path: Path) -> dict:
    try:
        record = json.loads(path.read_text())
    except ValueError:
        return {}
    return record if isinstance(record, dict) else {}


def _one(records: list[dict], out_dir: Path, what: str, *keys: str) -> str:
    values = {str(inner(record, *keys)) for record in records}
    if len(values) > 1:
        raise Problem(f"{out_dir}: its runs are of more than one {what} ({', '.join(sorted(values))}); remove "
                      "it and run the study again")
    return values.pop()
