"""Commands of tools/ in a tree of their own, with stand-ins for the programs that they call: nothing is installed or built."""

import os
import shutil
import subprocess
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


class CopiedTools:
    """`names`: files of tools/ to copy, as their paths in the project."""

    def __init__(self, folder: Path, *names: str):
        self.root, self.bin = folder / "tree", folder / "bin"
        self.bin.mkdir(parents=True)
        for name in names:
            target = self.root / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(PROJECT / name, target)

    def stand_in(self, name: str, script: str) -> None:
        """A program of this name, which is found before the system's."""
        self.write(self.bin / name, script)

    def write(self, path: Path, script: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        path.write_text(f"#!/bin/bash\n{script}\n")
        path.chmod(0o755)

    def environment(self, **more: str) -> dict[str, str]:
        return os.environ | {"PATH": f"{self.bin}:{os.environ['PATH']}", "LC_ALL": "C"} | more

    def call(self, tool: str, *arguments, **more: str) -> subprocess.CompletedProcess:
        return subprocess.run([self.root / "tools" / tool, *map(str, arguments)], capture_output=True, text=True, check=False,
                              timeout=60, env=self.environment(**more))

    def start(self, tool: str, *arguments, **options) -> subprocess.Popen:
        return subprocess.Popen([self.root / "tools" / tool, *map(str, arguments)], env=self.environment(), text=True, **options)
