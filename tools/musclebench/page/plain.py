"""What a page without its program shows in place of charts: the pictures that a study drew."""

import base64
from dataclasses import dataclass
from pathlib import Path

from .parts import Section
from .written import caption_of

MOST_CSV_BYTES = 500_000  # of the rows that a page without a program carries, which are not packed


@dataclass(frozen=True)
class Picture:
    name: str
    title: str
    words: list[str]
    data: str  # PNG


def pictures_of(sections: list[Section], most_bytes: int) -> dict[str, tuple[list[Picture], int]]:
    """By section: the pictures in its folder, as long as they fit, and how many others there are."""
    shown: dict[str, tuple[list[Picture], int]] = {}
    seen: set[Path] = set()  # two sections may be of one folder
    for section in sections:
        files = [path for path in sorted(section.folder.glob("figures/**/*.png")) if path not in seen]
        seen.update(files)
        fitting = []
        for path in files:
            data = base64.b64encode(path.read_bytes()).decode()
            if len(data) <= most_bytes:
                most_bytes -= len(data)
                title, *words = caption_of(path.parent, path.stem)
                fitting.append(Picture(path.stem, title, words, data))
        shown[section.name] = fitting, len(files) - len(fitting)
    return shown


def linked_rows(csv: str) -> str:
    """A link's target; empty where the rows are too many."""
    data = csv.encode()
    return f"data:text/csv;base64,{base64.b64encode(data).decode()}" if len(data) <= MOST_CSV_BYTES else ""
