"""Cores that runs on one machine share out among themselves, so that no two measure on the same one."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TextIO


@contextmanager
def own_cores(wanted: list[int]) -> Iterator[list[int]]:
    """As many as are wanted: these where no other run of this user has them, else others that are free. Where too few are
    free, wanted ones are shared, and the runs' own readings of the machine tell."""
    others = [core for core in sorted(os.sched_getaffinity(0)) if core not in wanted]
    found: list[int] = []
    with ExitStack() as locks:
        for core in [*wanted, *others]:
            if len(found) < len(wanted) and (lock := _lock_of(core)) is not None:
                locks.callback(lock.close)
                found.append(core)
        shared = [core for core in wanted if core not in found]
        yield found + shared[: len(wanted) - len(found)]


def _lock_of(core: int) -> TextIO | None:
    """None where another run has it. The lock goes with the process, however that ends."""
    folder = Path(tempfile.gettempdir()) / f"musclebench-cores-{os.getuid()}"
    try:
        folder.mkdir(exist_ok=True)
        file = open(folder / f"core-{core}", "w")
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    return file
