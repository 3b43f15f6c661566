"""The Python tests of a scratch tree: which of them a module reaches, and whether they pass."""

import ast
import os
import re
import subprocess
import sys
import time
from functools import cached_property
from pathlib import Path

from .scratch_build import ProgramRun

TOOLS, TESTS = "tools", "tools/tests"
FAILED_TEST = re.compile(r"^(?:FAILED|ERROR) \S+?::(.+?)(?: - .*)?$", re.MULTILINE)
NO_TESTS = 5  # exit code of pytest where every test is left out


class PythonTests:
    """Test modules by their paths in the tree. Tests of the program skip: it is not there for them."""

    def __init__(self, tree: Path):
        self._tree = tree

    def reached_by(self, file: str) -> list[str]:
        """Test modules that import `file`, or what imports it: those that share words with its name first, then those that
        need the fewest steps."""
        steps, front = {file: 0}, [file]
        while front:
            found = {importer for imported in front for importer in self._importers.get(imported, ())} - steps.keys()
            steps |= dict.fromkeys(found, steps[front[0]] + 1)
            front = list(found)
        tests = [source for source in steps if source.startswith(f"{TESTS}/test_")]
        return sorted(tests, key=lambda test: (-len(_words(test) & _words(file)), steps[test], test))

    def run(self, test: str, timeout_s: float) -> ProgramRun:
        """One run that ends at the first failure."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("MUSCLEBENCH_")}
        start = time.monotonic()
        command = [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "--tb=no", "-rfE", test]
        try:
            done = subprocess.run(command, cwd=self._tree, env=environment, capture_output=True, text=True, errors="replace",
                                  timeout=timeout_s, check=False)
        except subprocess.TimeoutExpired:
            return ProgramRun(False, time.monotonic() - start, f"no end within {timeout_s:.0f} s")
        failed = FAILED_TEST.search(done.stdout)
        passed = done.returncode in (0, NO_TESTS)
        return ProgramRun(passed, time.monotonic() - start, "" if passed else failed[1] if failed else f"exit code {done.returncode}")

    @cached_property
    def _importers(self) -> dict[str, set[str]]:
        """{file: files that import it}"""
        found: dict[str, set[str]] = {}
        for path in (self._tree / TOOLS).rglob("*.py"):
            source = str(path.relative_to(self._tree))
            for imported in self._imports(source):
                found.setdefault(imported, set()).add(source)
        return found

    def _imports(self, source: str) -> set[str]:
        """Files of the tree, the packages' own among them."""
        try:
            parsed = ast.parse((self._tree / source).read_text())
        except SyntaxError:
            return set()
        found = set()
        for node in ast.walk(parsed):
            if isinstance(node, ast.Import):
                found |= {file for alias in node.names if (file := self._file_of(alias.name.split("."), source))}
            elif isinstance(node, ast.ImportFrom):
                base = list(Path(source).parts[1:-node.level]) if node.level else []
                module = base + (node.module.split(".") if node.module else [])
                found |= {file for alias in node.names
                          if (file := self._file_of([*module, alias.name], source) or self._file_of(module, source))}
        return found

    def _file_of(self, module: list[str], source: str) -> str | None:
        """tools/ and tools/tests/ are on the path."""
        for folder in (TOOLS, TESTS):
            path = "/".join([folder, *module])
            for file in (f"{path}.py", f"{path}/__init__.py"):
                if file != source and (self._tree / file).is_file():
                    return file
        return None


def _words(file: str) -> set[str]:
    """Of its name and its folder's."""
    path = Path(file)
    return set(f"{path.parent.name}_{path.stem}".split("_")) - {"test", "tests"}
