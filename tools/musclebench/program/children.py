"""Processes that end with the one that started them, however that ends, and a display for those that draw."""

import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from .cli import Problem

# A command in front of another: the kernel kills it when its parent is gone, even by kill -9.
ENDS_WITH_PARENT = ["setpriv", "--pdeathsig", "KILL"]
GRACE_SECONDS = 5.0
INTERRUPTS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def started(command: list[str], **options) -> Iterator[subprocess.Popen]:
    """In a session of its own, so that an interrupt of the terminal reaches this process only; ended on leaving."""
    process = subprocess.Popen([*ENDS_WITH_PARENT, *command], start_new_session=True, **options)
    try:
        yield process
    finally:
        end(process)


def end(process: subprocess.Popen) -> None:
    """Politely first."""
    for ask in (process.terminate, process.kill):
        if process.poll() is None:
            ask()
            try:
                process.wait(GRACE_SECONDS)
            except subprocess.TimeoutExpired:
                continue


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Interrupts wait until the block is done: what it starts is known to who ends it. (Blocked signals would stay blocked
    in a child.) Only the main thread is interrupted."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    usual = {number: signal.signal(number, lambda number, _: held.append(number)) for number in INTERRUPTS}
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler or signal.SIG_DFL)
        for number in held[:1]:
            signal.raise_signal(number)


@contextmanager
def display() -> Iterator[dict[str, str]]:
    """The environment of processes that draw: a virtual display, or the one that there is."""
    if shutil.which("Xvfb"):
        # Not xvfb-run: a kill of that script leaves its server and the drawing alive.
        numbers, told = os.pipe()
        command = ["Xvfb", "-displayfd", str(told), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"]
        with started(command, pass_fds=(told,), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            os.close(told)
            with os.fdopen(numbers) as lines:
                number = lines.readline().strip()
            if not number:
                raise Problem("Xvfb gives no display")
            yield {**os.environ, "DISPLAY": f":{number}"}
    elif os.environ.get("DISPLAY"):
        yield dict(os.environ)
    else:
        raise Problem("there is no display and no Xvfb; install the package xvfb")
