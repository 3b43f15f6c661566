"""The folder of an experiment's results, used by one process at a time."""

import fcntl
import shutil
from contextlib import contextmanager
from pathlib import Path

LOCK_NAME = ".lock"


class FolderInUse(Exception):
    """One line with location, problem and cure."""


@contextmanager
def claimed(out_dir: Path, *result_dirs: str):
    """Makes the folder and those of the results in it, keeps other processes out, and removes what a killed experiment
    left half-written: its hidden folders."""
    for name in result_dirs:
        (out_dir / name).mkdir(parents=True, exist_ok=True)
    # The lock goes with the process, however that ends.
    with open(out_dir / LOCK_NAME, "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FolderInUse(f"{out_dir}: another run writes there; wait for it or choose another --out") from None
        for name in result_dirs:
            for leftover in (out_dir / name).glob(".*"):
                shutil.rmtree(leftover, ignore_errors=True)
        yield out_dir
