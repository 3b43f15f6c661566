"""The page's program, made of its sources and of libraries from npm, whose versions are locked."""

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from ..program.cli import Problem
from ..program.fingerprint import write_whole

PROJECT = Path(__file__).resolve().parents[3]
SOURCES = PROJECT / "tools" / "page"
BUILT = PROJECT / "build" / "page"
LOCKED = ("package.json", "package-lock.json")
INSTALL_SECONDS, BUNDLE_SECONDS = 600, 120
KEPT_BUNDLES = 4
IMPATIENT = ("--fetch-retries=1", "--fetch-timeout=30000")  # without a network it shall say so soon


PAGE, BOARD, SHAPES = "main.js", "board.js", "shapes.js"  # what a script begins with


def page_script(sources: Path = SOURCES, built: Path = BUILT, entry: str = PAGE) -> str:
    """As one script without imports; made again when a source or a version changes. Raises Problem where npm is missing or
    the libraries can't be had."""
    made = script_file(sources, built, entry)
    if not made.is_file():
        libraries = installed(sources, built)
        built.mkdir(parents=True, exist_ok=True)
        write_whole(made, _bundled(sources / entry, libraries))
        for old in sorted(built.glob(f"{_kind(entry)}-*.js"), key=os.path.getmtime)[:-KEPT_BUNDLES]:
            old.unlink()
    return made.read_text(encoding="utf-8")


def is_built(sources: Path = SOURCES, built: Path = BUILT) -> bool:
    """Of the sources as they are: then a page needs no npm."""
    return script_file(sources, built).is_file()


def script_file(sources: Path, built: Path, entry: str = PAGE) -> Path:
    return built / f"{_kind(entry)}-{_digest([*sorted(sources.glob('*.js')), *(sources / name for name in LOCKED)])}.js"


def _kind(entry: str) -> str:
    return "page" if entry == PAGE else entry.removesuffix(".js")


def installed(sources: Path = SOURCES, built: Path = BUILT, with_tests: bool = False) -> Path:
    """The folder node_modules with the versions of package-lock.json; `with_tests`: what only tests need, too."""
    if not shutil.which("npm") or not shutil.which("node"):
        raise Problem("npm is missing; the page needs JavaScript libraries. Install npm with tools/setup npm nodejs")
    kind = "tests" if with_tests else "page"
    home = built / f"{kind}-{_digest([sources / name for name in LOCKED])}"
    if not home.is_dir():
        built.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".installing-", dir=built) as folder:
            for name in LOCKED:
                shutil.copy(sources / name, folder)
            words = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--prefer-offline", *IMPATIENT,
                     *([] if with_tests else ["--omit=dev"])]
            _run(words, INSTALL_SECONDS, "'npm ci' cannot install the libraries of tools/page/package-lock.json", Path(folder))
            try:
                os.rename(folder, home)
            except OSError:
                if not home.is_dir():  # else another process was first
                    raise
            Path(folder).mkdir(exist_ok=True)
    return home / "node_modules"


def _bundled(entry: Path, libraries: Path) -> str:
    words = [str(libraries / ".bin" / "esbuild"), str(entry), "--bundle", "--minify", "--format=iife", "--target=es2022",
             "--legal-comments=inline", "--charset=utf8"]
    done = _run(words, BUNDLE_SECONDS, "esbuild cannot bundle the page's scripts", entry.parent, {"NODE_PATH": str(libraries)})
    return done.replace("</script", "<\\/script")


def _run(words: list[str], seconds: float, failed: str, folder: Path, more: dict | None = None) -> str:
    try:
        done = subprocess.run(words, cwd=folder, env=os.environ | (more or {}), capture_output=True, text=True, check=False,
                              timeout=seconds)
    except (OSError, subprocess.TimeoutExpired) as problem:
        raise Problem(f"{failed} ({problem})") from None
    if done.returncode != 0:
        lines = [line for line in done.stderr.strip().splitlines() if line.strip()]
        raise Problem(f"{failed} ({lines[0] if lines else f'exit code {done.returncode}'})")
    return done.stdout


def _digest(files: list[Path]) -> str:
    found = hashlib.sha256()
    for path in files:
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()[:16]
