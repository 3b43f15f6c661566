"""Without matplotlib or VTK everything but pictures is made, and a line says what is left out."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from copied_tools import PROJECT

TOOLS = PROJECT / "tools"
BEGIN = """import sys
sys.modules.update(dict.fromkeys({hidden}))
sys.path[:0] = [{tools!r}, {tests!r}]
from pathlib import Path
out = Path({out!r})
"""
PAPER = """import paper, fake_page, fake_registry
from musclebench.figures import looks
looks.know(fake_registry.registry())
fake_page.write_paper(out)
runs, tables, files = paper.write_report(out, [path.name for path in (out / "raw").iterdir()])
print(*sorted({path.suffix for path in files}), len(tables))
"""
PAGE = """import report, fake_page
from musclebench.page import page_file
page_file.page_script = lambda: ""
sys.exit(report.main([str(fake_page.write_paper(out)), *WORDS]))
"""
ACCURACY = """import accuracy, fake_study
fake_study.write_two_muscles(out)
files = accuracy.write_report(out)
print(*sorted({path.suffix for path in files}))
"""
DRAWN = """import draw_pictures, fake_page
sys.exit(draw_pictures.main(["surfaces", str(fake_page.write_paper(out)), "iliacus-voxel"]))
"""
SPACE = """from musclebench.pictures.in_display import draw_in_display
from musclebench.program.optional_packages import left_out_without
with left_out_without("the pictures in space"):
    draw_in_display("surfaces", out, ["none"])
"""
DIAGRAMS = """import runpy, draw_diagrams
sys.argv = ["draw_diagrams.py", str(out / "pictures")]
runpy.run_path(draw_diagrams.__file__, run_name="__main__")
"""
MATPLOTLIB, VTK = ("matplotlib",), ("vtk", "vtkmodules")


def run(script: str, hidden: tuple[str, ...], out: Path) -> subprocess.CompletedProcess:
    out.mkdir(exist_ok=True)
    begin = BEGIN.format(hidden=repr(hidden), tools=str(TOOLS), tests=str(TOOLS / "tests"), out=str(out))
    return subprocess.run([sys.executable, "-c", begin + script], capture_output=True, text=True, check=False, timeout=100,
                          env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"})


def left_out(done: subprocess.CompletedProcess) -> list[str]:
    return [line for line in done.stderr.splitlines() if line.startswith("left out ")]


def test_the_papers_tables_are_written_without_matplotlib(tmp_path):
    done = run(PAPER, MATPLOTLIB, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert left_out(done) == ["left out the figures: Python lacks matplotlib (tools/setup installs python3-matplotlib)"]
    assert ".csv" in done.stdout and ".png" not in done.stdout and done.stdout.endswith(" 2\n")


def test_the_page_is_the_same_without_both(tmp_path):
    pages = []
    for hidden in ((), MATPLOTLIB + VTK):
        done = run(PAGE.replace("*WORDS", ""), hidden, tmp_path / "out")
        assert (done.returncode, done.stderr) == (0, "")
        pages.append((tmp_path / "out" / "report.html").read_text())
        for path in sorted((tmp_path / "out").rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
    assert pages[0] == pages[1]


def test_an_export_wants_vtk_and_says_so_in_one_line(tmp_path):
    done = run(PAGE.replace("*WORDS", '"--export", "vtk"'), VTK, tmp_path / "out")
    assert (done.returncode, done.stderr) == (2, "report: Python lacks vtk (tools/setup installs python3-vtk9)\n")


def test_the_accuracy_study_leaves_out_figures(tmp_path):
    done = run(ACCURACY, MATPLOTLIB, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert left_out(done) == ["left out the figures: Python lacks matplotlib (tools/setup installs python3-matplotlib)"]
    assert ".csv" in done.stdout and ".png" not in done.stdout


def test_the_accuracy_study_leaves_out_hausdorff_distances(tmp_path):
    done = run(ACCURACY, VTK, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert left_out(done) == ["left out Hausdorff distances of shapes: Python lacks vtkmodules (tools/setup installs python3-vtk9)"]
    assert ".png" in done.stdout


def test_diagrams_want_matplotlib_and_say_so_in_one_line(tmp_path):
    done = run(DIAGRAMS, MATPLOTLIB, tmp_path / "out")
    assert (done.returncode, done.stderr) == (2, "draw_diagrams: Python lacks matplotlib (tools/setup installs python3-matplotlib)\n")
    assert not (tmp_path / "out" / "pictures").exists()


@pytest.mark.parametrize("hidden", [MATPLOTLIB, VTK])
def test_pictures_in_space_are_no_failure(tmp_path, hidden):
    done = run(SPACE, hidden, tmp_path / "out")
    assert done.returncode == 0 and len(left_out(done)) == 1 and done.stderr.count("\n") == 1
    done = run(DRAWN, hidden, tmp_path / "drawn")
    assert done.returncode == 2 and done.stderr == f"draw_pictures: Python lacks {hidden[0]} (tools/setup installs " \
        f"{'python3-matplotlib' if hidden == MATPLOTLIB else 'python3-vtk9'})\n"
