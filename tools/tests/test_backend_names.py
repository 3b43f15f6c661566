"""No file outside a backend's own folder, the table of backends and the paper's own experiment names a backend; nor do
the tests' stand-ins, which ask the registry's fixture for the backend of a role. Exempt are tests: those of the paper's
experiment, whose backends are the paper's, and those that need one concrete backend, its parameters or its numbers."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
ROOMS = ("core", "backends", "bench", "datasets", "tools", "cmake")
SUFFIXES = {".cpp", ".hpp", ".in", ".txt", ".cmake", ".py", ".sh", ".toml", ".js", ".j2", ""}
TABLE = Path("backends/CMakeLists.txt")
# Faults and golden states are made for one backend each; the list of public headers has those of two.
MADE_FOR_ONE = {Path("tools/mutants.toml"), Path("cmake/public_headers.txt")}
OUTSIDE = "outside"  # each folder in it is a backend's own, too
# Where a library's name means the library, not the backend of that name.
OF_LIBRARY = {Path("tools/import.py"): "vtk", Path("bench/experiments/speed.toml"): "embree",
              Path("bench/micro/embree_benchmark.cpp"): "embree",
              Path("cmake/check_includes.py"): "embree", Path("tools/musclebench/options/report.py"): "vtk",
              Path("tools/population.py"): "vtk",
              Path("tools/musclebench/pictures/in_display.py"): "vtk",
              Path("tools/musclebench/program/optional_packages.py"): "vtk"}


def backend_names() -> list[str]:
    return sorted(study.parent.name for study in (ROOT / "backends").glob("*/study.toml"))


def is_of_the_paper(path: Path) -> bool:
    return "paper" in path.parts or path.name.startswith("paper_") or path.name == "paper.toml"


def is_cache(path: Path) -> bool:
    return any(part == "__pycache__" or part.startswith(".") for part in path.parts)


def product_files(names: list[str]) -> list[Path]:
    files = [ROOT / "CMakeLists.txt"] + [path for room in ROOMS for path in sorted((ROOT / room).rglob("*"))]
    found = []
    for path in files:
        inside = path.relative_to(ROOT)
        of_backend = inside.parts[0] == "backends" and inside.parts[1] in {*names, OUTSIDE}
        skipped = of_backend or "tests" in inside.parts or is_cache(inside) or is_of_the_paper(inside)
        if path.is_file() and path.suffix in SUFFIXES and not skipped and inside not in {TABLE, *MADE_FOR_ONE}:
            found.append(path)
    return found


def stand_ins() -> list[Path]:
    return sorted((ROOT / "tools/tests").glob("fake_*.py"))


def naming(names: list[str]) -> re.Pattern[str]:
    """A name in quotes, alone or before parameters; as the value of an option; as a folder of backends."""
    word = "|".join(map(re.escape, names))
    return re.compile(rf"""(?P<quote>["'`])(?:{word})(?:(?P=quote)|[ ,:]\s*\w+\s*=)|[\w\]]=(?:{word})\b(?![(.])|backends/(?:{word})/""")


def naming_lines(text: str, pattern: re.Pattern[str]) -> list[str]:
    return [f"{number}: {line.strip()}" for number, line in enumerate(text.splitlines(), 1) if pattern.search(line)]


def test_neither_product_code_nor_stand_ins_name_a_backend():
    names = backend_names()
    files = product_files(names)
    assert len(names) > 3 and len(files) > 300 and len(stand_ins()) > 3
    named = []
    for path in files + stand_ins():
        inside = path.relative_to(ROOT)
        pattern = naming([name for name in names if name != OF_LIBRARY.get(inside)])
        named += [f"{inside}:{line}" for line in naming_lines(path.read_text(encoding="utf-8", errors="replace"), pattern)]
    assert not named, "\n".join(named)


@pytest.mark.parametrize(("line", "is_naming"), [
    ('entry = find_backend("grid");', True),
    ("such as femur=grid, or for muscles", True),
    ('/// As one would type it: "grid cells=64".', True),
    ("`backend=grid|tree`", True),
    ('#include "backends/grid/kernel.hpp"', True),
    ('#include "core/grid/shape.hpp"', False),
    ("const Shape shape = grid.shape();", False),
    ("return ask(shape=grid.shape())", False),
    ("/// A grid over the bone's box.", False),
])
def test_what_counts_as_a_name(line, is_naming):
    assert bool(naming_lines(line, naming(["grid", "tree"]))) is is_naming
