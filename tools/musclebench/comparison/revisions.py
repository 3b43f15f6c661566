"""Programs of git revisions, each built once in a scratch folder of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from ..program.cli import Problem

BUILD_OPTIONS = ("-DMUSCLEBENCH_WITH_TESTS=OFF", "-DMUSCLEBENCH_WITH_MICRO=OFF")
COMMIT_LETTERS = 12


def commit_of(revision: str, repository: Path) -> str | None:
    """None where it is no revision of the repository."""
    done = _git(repository, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    return done.stdout.strip()[:COMMIT_LETTERS] if done.returncode == 0 else None


def program_of(commit: str, repository: Path, scratch: Path) -> Path:
    """Builds it where that was not done yet. Checked out by a clone, so that the repository's own files stay as they are."""
    folder = scratch / commit
    program = folder / "build" / "release" / "bench" / "musclebench"
    if os.access(program, os.X_OK):
        return program
    print(f"Building {commit} in {folder} (some four minutes on two cores) ...", file=sys.stderr, flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    scratch.mkdir(parents=True, exist_ok=True)
    for words in (("clone", "--quiet", "--shared", "--no-checkout", str(repository), str(folder)),
                  ("-C", str(folder), "checkout", "--quiet", "--detach", commit)):
        done = _git(repository, *words)
        if done.returncode != 0:
            raise Problem(f"{folder}: can't check out {commit} ({(done.stderr.strip().splitlines() or ['no message'])[-1]})")
    try:
        built = subprocess.run([str(folder / "tools" / "build"), "release", *BUILD_OPTIONS], capture_output=True, text=True,
                               check=False)
    except OSError as problem:
        raise Problem(f"{folder}: {commit} has no working tools/build ({problem.strerror}); name a newer commit") from None
    if built.returncode != 0 or not os.access(program, os.X_OK):
        raise Problem(f"{folder}: {commit} does not build ({(built.stderr.strip().splitlines() or ['no message'])[-1]})")
    return program


def commits_between(first: str, last: str, repository: Path, most: int = 20) -> list[str]:
    """'HASH SUBJECT' of those after the first, up to the last, the newest first; empty where git does not know both."""
    first, last = (text.removesuffix("-dirty").removesuffix("+") for text in (first, last))
    done = _git(repository, "log", "--oneline", "--no-decorate", f"--max-count={most}", "--end-of-options", f"{first}..{last}")
    return done.stdout.splitlines() if done.returncode == 0 else []


def _git(repository: Path, *words: str) -> subprocess.CompletedProcess:
    return subprocess.run(["git", "-C", str(repository), *words], capture_output=True, text=True, check=False)
