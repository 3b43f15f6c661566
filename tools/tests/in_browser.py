"""Runs a script of Playwright that opens a page in a headless browser, and returns the JSON that it tells."""

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from musclebench.page import bundle
from musclebench.program.cli import Problem

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")


def told_by(script: str, make: Callable[[], list[Path | str]]) -> dict:
    """`script`: in this folder. `make`: writes what is opened and returns the script's arguments, after the libraries and the browser.
    Skips the test without a browser or without the libraries."""
    if not BROWSER:
        pytest.skip("chromium is missing (tools/setup chromium): the page is not opened")
    try:
        libraries, arguments = bundle.installed(with_tests=True), make()
    except Problem as problem:
        pytest.skip(f"the page is not opened: {problem}")
    words = ["node", Path(__file__).with_name(script), libraries, BROWSER, *arguments]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])
