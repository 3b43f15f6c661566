"""The list of faults: what each replaces where, and whether it still applies to a tree of the sources."""

import json
import tomllib
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from ..program.cli import Problem

ROOMS = ("core/", "backends/", "bench/", "datasets/", "tools/")
LEAST_FAULTS = 80
MOST_SURVIVORS = 2


class FaultListError(Problem):
    """The list can't be used; one line with file, fault and cure."""


@dataclass(frozen=True)
class Fault:
    """`line` is text that occurs once in `file`; `fault` takes its place."""

    name: str
    file: str
    line: str
    fault: str
    may_survive: str = ""  # why no test can see it; empty: it has to be seen

    @property
    def key(self) -> str:
        """Under which its verdict is kept."""
        return json.dumps([self.file, self.line, self.fault])

    @property
    def is_python(self) -> bool:
        return self.file.endswith(".py")

    def problem(self, root: Path) -> str | None:
        """Why it can't be put into the tree at `root`."""
        if not self.file.startswith(ROOMS):
            return f"{self.file} is not in {', '.join(ROOMS)}"
        path = root / self.file
        if not path.is_file():
            return f"{self.file} is not there any more; name the file that holds the line now"
        if self.line == self.fault or not self.line:
            return "'line' and 'fault' have to be two texts"
        count = path.read_text().count(self.line)
        if count != 1:
            return f"its line stands {count} times in {self.file}, not once: {self.line.strip()!r}"
        return None

    def put_into(self, text: str) -> str:
        return text.replace(self.line, self.fault)


def read_faults(path: Path) -> list[Fault]:
    """Raises FaultListError."""
    try:
        rows = tomllib.loads(path.read_text()).get("fault", [])
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise FaultListError(f"{path}: {error}") from error
    faults = [_fault_of(row, number, path) for number, row in enumerate(rows, 1)]
    names = [fault.name for fault in faults]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise FaultListError(f"{path}: {', '.join(twice)}: every fault needs a name of its own")
    return faults


def _fault_of(row: dict, number: int, path: Path) -> Fault:
    location = f"{path}: fault {row.get('name', number)}"
    unknown = set(row) - set(Fault.__dataclass_fields__)
    if unknown:
        raise FaultListError(f"{location}: {', '.join(sorted(unknown))}: no such key")
    try:
        fault = Fault(**row)
    except TypeError as error:
        raise FaultListError(f"{location}: name, file, line and fault must be given; add the missing key") from error
    if not all(isinstance(value, str) for value in row.values()):
        raise FaultListError(f"{location}: every value must be a text in quotes")
    return fault


def chosen(faults: list[Fault], patterns: list[str] | None, shard: tuple[int, int] | None) -> list[Fault]:
    """Raises Problem where none has such a name."""
    if patterns:
        faults = [fault for fault in faults if any(fnmatch(fault.name, pattern) for pattern in patterns)]
        if not faults:
            raise Problem(f"--only {' '.join(patterns)}: no such fault; --list prints them")
    if shard:
        number, count = shard
        faults = faults[number - 1::count]
    return faults


def problems_of(faults: list[Fault], root: Path) -> list[str]:
    """One line each; empty when every fault applies, makes a program of its own, and the list is as long as it has to be."""
    found: list[str] = []
    first: dict[tuple, str] = {}
    for fault in faults:
        if problem := fault.problem(root):
            found.append(f"{fault.name}: {problem}")
            continue
        made = (fault.file, fault.put_into((root / fault.file).read_text()))
        if first.setdefault(made, fault.name) != fault.name:
            found.append(f"{fault.name}: is {first[made]} once more; remove one")
    if len(faults) < LEAST_FAULTS:
        found.append(f"the list has {len(faults)} faults; it needs {LEAST_FAULTS}")
    excused = [fault.name for fault in faults if fault.may_survive]
    if len(excused) > MOST_SURVIVORS:
        found.append(f"{len(excused)} faults may survive ({', '.join(excused)}); at most {MOST_SURVIVORS} may")
    return found


def stale_keys(faults: list[Fault], seen: Path) -> list[str]:
    """A line for each key of a file of seen faults that no listed fault has; a file that isn't there has none."""
    listed = {fault.key for fault in faults}
    return [f"{seen}: {key}: no such fault is listed; remove it" for key in read_seen(seen) if key not in listed]


def read_seen(path: Path) -> dict[str, str]:
    """The test that saw each fault, by key. Raises FaultListError."""
    try:
        kept = json.loads(path.read_text()) if path.is_file() else {}
    except ValueError as error:
        raise FaultListError(f"{path}: not the JSON that a campaign writes ({error}); remove it") from error
    if not isinstance(kept, dict):
        raise FaultListError(f"{path}: not what a campaign writes; remove it")
    return kept
