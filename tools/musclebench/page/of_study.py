"""The page that a study makes at its end."""

import sys
from pathlib import Path

from ..program.cli import Problem
from ..results.run_folder import ResultProblem
from . import FILE_NAME
from .page_file import write_page


def page_of(study: str, out_dir: Path, options) -> list[Path]:
    """Says what it left out where the page can't be made: figures and tables are complete without it."""
    if options.no_page:
        return []
    try:
        return [write_page([out_dir])]
    except (Problem, ResultProblem) as problem:
        print(f"{study}: left out {out_dir / FILE_NAME}, the page with charts and runs in 3D: {problem}", file=sys.stderr)
        return []
