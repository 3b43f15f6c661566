"""A version of the project: which files have its number, and what changed since the last one."""

import re
from dataclasses import dataclass
from pathlib import Path

from ..program.cli import Problem

CHANGES = "CHANGELOG.md"
UNRELEASED = "## Unreleased"
# The number in each file. CMake's is the one that the program prints.
NUMBERS = {"CMakeLists.txt": r"(project\(musclebench VERSION )([\d.]+)", "tools/pyproject.toml": r'(^version = ")([\d.]+)',
           "CITATION.cff": r"(^version: )([\d.]+)"}


@dataclass(frozen=True)
class Release:
    last: str
    notes: str  # as Markdown, without a heading
    texts: dict[str, str]  # by file, as they will be


def _parts(version: str) -> tuple[int, ...]:
    return tuple(map(int, version.split(".")))


def _numbered(project: Path, name: str, version: str, last: str) -> str:
    text = (project / name).read_text()
    found = re.findall(NUMBERS[name], text, re.MULTILINE)
    if [number for _, number in found] != [last]:
        raise Problem(f"{name}: has not once the version {last}, which CMakeLists.txt has; make them equal")
    return re.sub(NUMBERS[name], rf"\g<1>{version}", text, flags=re.MULTILINE)


def _dated(text: str, date: str) -> str:
    """When a citation's version came out."""
    text = re.sub(r"^date-released:.*\n", "", text, flags=re.MULTILINE)
    return re.sub(r"(^version: .*\n)", rf"\g<1>date-released: {date}\n", text, flags=re.MULTILINE)


def prepare(project: Path, version: str, date: str) -> Release:
    found = re.search(NUMBERS["CMakeLists.txt"], (project / "CMakeLists.txt").read_text())
    if not found:
        raise Problem("CMakeLists.txt: has no project(musclebench VERSION ...)")
    last = found[2]
    if _parts(version) <= _parts(last):
        raise Problem(f"VERSION {version}: is not above {last}, the last one")
    changes = (project / CHANGES).read_text()
    head, heading, rest = changes.partition(f"{UNRELEASED}\n")
    notes, next_heading, older = rest.partition("\n## ")
    if not heading or not notes.strip():
        raise Problem(f"{CHANGES}: nothing stands under '{UNRELEASED}'; write what changed since {last}")
    texts = {name: _numbered(project, name, version, last) for name in NUMBERS}
    texts["CITATION.cff"] = _dated(texts["CITATION.cff"], date)
    texts[CHANGES] = f"{head}{UNRELEASED}\n\n## {version} ({date})\n{notes}{next_heading}{older}"
    return Release(last, notes.strip(), texts)
