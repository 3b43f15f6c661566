"""Writes the page of folders of results."""

import sys
import time
from pathlib import Path

from ..program.cli import Problem
from ..program.fingerprint import write_whole
from . import FILE_NAME
from .bundle import page_script
from .html import page_html, plain_html
from .parts import Section
from .plain import pictures_of
from .sections import sections_of
from .views import Views, fit_together

LARGEST_BYTES = 9_900_000
MEGABYTE = 1e6


def write_page(folders: list[Path], out: Path | None = None) -> Path:
    """Into the first folder, or beside a history that is the first, unless told. Says what it left out because it can't be read;
    without npm that is all that needs a program. Raises Problem where there is nothing to show."""
    started = time.monotonic()
    for folder in folders:
        if not folder.exists():
            raise Problem(f"{folder}: no such folder of results")
    first = folders[0] if folders[0].is_dir() else folders[0].parent
    out = out or first / FILE_NAME
    sections, places = sections_of(folders), [folder.absolute() for folder in folders]
    for section in sections:
        if section.is_left_out:
            print(f"report: left out {section.problems[0]}", file=sys.stderr)
    try:
        text = small_page(sections, places, page_script())
    except Problem as problem:
        print(f"report: left out charts and runs in space, so that the page is plain: {problem}", file=sys.stderr)
        text = plain_page(sections, places, str(problem))
    write_whole(out, text)
    print(f"{out}: {len(text.encode()) / MEGABYTE:.1f} MB, made in {time.monotonic() - started:.0f} s")
    return out


def plain_page(sections: list[Section], folders: list[Path], why: str) -> str:
    """With as many pictures as fit."""
    room = LARGEST_BYTES - len(plain_html(sections, folders, why, {}).encode())
    return plain_html(sections, folders, why, pictures_of(sections, room))


def small_page(sections: list[Section], folders: list[Path], script: str) -> str:
    """With as many moments of runs in space as fit."""
    text = page_html(sections, folders, script)
    views = [part for section in sections for part in section.parts if isinstance(part, Views) and part.scenes]
    more = len(text.encode()) - LARGEST_BYTES
    if more <= 0 or not views:
        return text
    fit_together(views, more)
    return page_html(sections, folders, script)
