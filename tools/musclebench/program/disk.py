"""A full disk ends an experiment: what is complete stays, what is half-written goes."""

import errno
import shutil
from pathlib import Path

# What musclebench and the system's libraries say; a program that met a full disk has removed its files again, so that
# free space measured afterwards proves nothing.
FULL_DISK_WORDS = ("disk full", "No space left on device", "quota exceeded")


class DiskFull(Exception):
    """One line with location, problem and cure."""

    def __init__(self, folder: Path):
        super().__init__(f"{folder}: the disk is full; complete cases are kept, make room and start again")


def says_disk_full(message: str) -> bool:
    return any(words.lower() in message.lower() for words in FULL_DISK_WORDS)


def is_disk_full(problem: OSError) -> bool:
    return problem.errno in (errno.ENOSPC, errno.EDQUOT)


def free_bytes(folder: Path) -> int:
    """On the disk that holds the folder or will hold it."""
    while not folder.exists():
        folder = folder.parent
    return shutil.disk_usage(folder).free
