"""Pictures in space are drawn by a process of its own, which has a display."""

import subprocess
import sys
from pathlib import Path

from ..program.children import display, started
from ..program.cli import Problem
from ..program.optional_packages import require

DRAWING = Path(__file__).resolve().parents[2] / "draw_pictures.py"


def draw_in_display(kind: str, out_dir: Path, names: list[str]) -> list[Path]:
    """`kind`: surfaces or fibres, of the runs in out_dir/raw. Raises Problem where they can't be drawn."""
    require("matplotlib", "vtk")
    command = [sys.executable, str(DRAWING), kind, str(out_dir), *names]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    files = []
    with display() as environment, started(command, env=environment, **pipes) as process:
        for line in process.stdout:
            word, _, text = line.rstrip().partition(" ")
            if word == "file":
                files.append(Path(text))
            elif word == "drawing" and sys.stderr.isatty():
                print(f"\rdrawing {text}\x1b[K", end="", file=sys.stderr, flush=True)
        errors = process.communicate()[1]
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    if process.returncode != 0:
        reason = errors.strip().splitlines()[-1] if errors.strip() else f"exit code {process.returncode}"
        raise Problem(f"pictures of {kind}: {reason}")
    return files
