"""Writes the page of folders of results."""

import time
from pathlib import Path

from ..program.cli import Problem
from ..program.fingerprint import write_whole
from .bundle import page_script
from .html import page_html
from .sections import sections_of

FILE_NAME = "report.html"
MEGABYTE = 1e6


def write_page(folders: list[Path], out: Path | None = None) -> Path:
    """Into the first folder unless told. Raises Problem where the page can't be made, ResultProblem for damaged results."""
    started = time.monotonic()
    for folder in folders:
        if not folder.is_dir():
            raise Problem(f"{folder}: no such folder of results")
    out = out or folders[0] / FILE_NAME
    script = page_script()
    text = page_html(sections_of(folders), [folder.absolute() for folder in folders], script)
    write_whole(out, text)
    print(f"{out}: {len(text.encode()) / MEGABYTE:.1f} MB, made in {time.monotonic() - started:.0f} s")
    return out
