"""A copy of the sources that faults are put into, so that nobody's work is touched."""

import hashlib
import shutil
import subprocess
from pathlib import Path


def source_files(root: Path) -> list[str]:
    """What git knows of and what it would: all but ignored files."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            capture_output=True, check=True).stdout.decode()
    return sorted(name for name in set(listed.split("\0")) if name and (root / name).is_file())


def refresh(root: Path, tree: Path) -> str:
    """Makes `tree` the same as the sources at `root`, touching only what differs; the hash of all of it."""
    names = source_files(root)
    whole = hashlib.sha256()
    for name in names:
        content = (root / name).read_bytes()
        whole.update(f"{name}\0{len(content)}\0".encode() + content)
        copy = tree / name
        if not copy.is_file() or copy.read_bytes() != content:
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(root / name, copy)
            shutil.copymode(root / name, copy)
    wanted = {tree / name for name in names}
    for path in [path for path in tree.rglob("*") if path.is_file() and path not in wanted]:
        path.unlink()
    return whole.hexdigest()
