"""A folder that a tool makes as a whole: it takes the place of an older one when it is complete, and of nothing else."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .cli import Problem


@contextmanager
def whole_folder(out: Path, mark: str, kind: str, force: bool = True) -> Iterator[Path]:
    """A new folder beside `out`, which becomes `out` where the block ends without an exception. The file `mark` in it then tells that it
    is a folder of this `kind`, and which files it has: JSON, with whatever the block wrote there. Raises Problem where `out` is there
    and has a file that no such tool wrote, or is there and `force` is not given; nothing was changed then."""
    out = out.resolve()
    if out.exists():
        if strange := _strange_file(out, mark, kind):
            raise Problem(f"--out {out}: is there already and is no {kind} alone ({strange} is none of its files); name a new folder")
        if not force:
            raise Problem(f"--out {out}: is there already; name another folder or add --force")
    out.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    try:
        yield folder
        _write_mark(folder, mark, kind)
        folder.chmod(0o755)
        old = folder.with_name(f"{folder.name}.old")
        if out.exists():
            out.rename(old)
        folder.rename(out)
        shutil.rmtree(old, ignore_errors=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _write_mark(folder: Path, mark: str, kind: str) -> None:
    path = folder / mark
    told = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    files = sorted({mark, *(str(one.relative_to(folder)) for one in folder.rglob("*") if one.is_file())})
    path.write_text(json.dumps({_key(kind): 1} | told | {"files": files}, indent=1) + "\n", encoding="utf-8")


def _strange_file(folder: Path, mark: str, kind: str) -> str:
    """The first that no such tool has written; empty where all of the folder is its own."""
    try:
        told = json.loads((folder / mark).read_text(encoding="utf-8"))
        own = set(told["files"]) if told[_key(kind)] == 1 else set()
    except (OSError, ValueError, TypeError, KeyError):
        own = set()
    found = [str(path.relative_to(folder)) for path in sorted(folder.rglob("*")) if not path.is_dir()] if folder.is_dir() else [folder.name]
    return next((name for name in found if name not in own), "" if own else "an empty folder")


def _key(kind: str) -> str:
    return f"musclebench_{kind}"
