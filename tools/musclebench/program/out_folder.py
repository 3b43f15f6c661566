"""The folder of an experiment's results, used by one process at a time."""

import fcntl
import shutil
from contextlib import ExitStack, contextmanager
from pathlib import Path

LOCK_NAME = ".lock"


class FolderInUse(Exception):
    """One line with location, problem and cure."""


class _Command:
    """Folders that the command of this process holds until it ends, its tables and figures written."""

    def __init__(self):
        self.stack: ExitStack | None = None
        self.folders: set[Path] = set()


_COMMAND = _Command()


@contextmanager
def holding_folders():
    """While a command runs: what `claimed_by_command` claims is its own until then."""
    with ExitStack() as stack:
        _COMMAND.stack, _COMMAND.folders = stack, set()
        try:
            yield
        finally:
            _COMMAND.stack, _COMMAND.folders = None, set()


@contextmanager
def claimed_by_command(out_dir: Path, *result_dirs: str):
    """As `claimed`, but until the command ends, where there is one."""
    if _COMMAND.stack is None:
        with claimed(out_dir, *result_dirs):
            yield out_dir
        return
    if out_dir not in _COMMAND.folders:
        _COMMAND.stack.enter_context(claimed(out_dir, *result_dirs))
        _COMMAND.folders.add(out_dir)
    yield out_dir


@contextmanager
def claimed(out_dir: Path, *result_dirs: str):
    """Makes the folder and those of the results in it, keeps other processes out, and removes what a killed experiment
    left half-written: its hidden folders."""
    for name in ("", *result_dirs):
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
