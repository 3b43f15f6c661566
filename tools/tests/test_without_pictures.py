"""Without matplotlib or VTK everything but pictures is made, and a line says what is left out."""

import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

import fake_page
import report
from copied_tools import PROJECT
from musclebench.page import page_file

TOOLS = PROJECT / "tools"
MATPLOTLIB, VTK = ("matplotlib",), ("vtk", "vtkmodules")
INSTALLS = {MATPLOTLIB: "python3-matplotlib", VTK: "python3-vtk9"}
# Importing what is there takes longer than all that is tested, so that what lacks the same packages shares a process.
RUN_ALL = """import io, json, sys, traceback
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
hidden, paths, folder, scripts = json.load(sys.stdin)
sys.modules.update(dict.fromkeys(hidden))
sys.path[:0] = paths
told = {}
for name, script in scripts.items():
    out, code = Path(folder) / name, 0
    out.mkdir()
    with redirect_stdout(io.StringIO()) as output, redirect_stderr(io.StringIO()) as errors:
        try:
            exec(script, {"out": out, "sys": sys, "__name__": name})
        except SystemExit as ended:
            code = ended.code
        except Exception:
            code = traceback.format_exc()
    told[name] = code, output.getvalue(), errors.getvalue()
json.dump(told, sys.stdout)
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
fake_study.write_muscles(out, fake_study.SCENES[:1])
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
SCRIPTS = {
    MATPLOTLIB: {"paper": PAPER, "accuracy": ACCURACY, "drawn": DRAWN, "space": SPACE, "diagrams": DIAGRAMS},
    VTK: {"export": PAGE.replace("*WORDS", '"--export", "vtk"'), "accuracy": ACCURACY, "drawn": DRAWN, "space": SPACE},
    MATPLOTLIB + VTK: {"page": PAGE.replace("*WORDS", "")},
}


@dataclass(frozen=True)
class Done:
    code: int | str  # or the traceback
    output: str
    errors: str
    folder: Path

    @property
    def left_out(self) -> list[str]:
        return [line for line in self.errors.splitlines() if line.startswith("left out ")]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What a script did where packages are hidden."""
    known: dict[tuple, dict[str, Done]] = {}

    def of(hidden: tuple[str, ...], name: str) -> Done:
        if hidden not in known:
            folder = tmp_path_factory.mktemp("without")
            asked = json.dumps([hidden, [str(TOOLS), str(TOOLS / "tests")], str(folder), SCRIPTS[hidden]])
            ended = subprocess.run([sys.executable, "-c", RUN_ALL], input=asked, capture_output=True, text=True, check=False, timeout=300,
                                   env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"})
            assert ended.returncode == 0, ended.stderr
            known[hidden] = {one: Done(*told, folder / one) for one, told in json.loads(ended.stdout).items()}
        return known[hidden][name]

    return of


def test_the_papers_tables_are_written_without_matplotlib(done):
    paper = done(MATPLOTLIB, "paper")
    assert paper.code == 0
    assert paper.left_out == ["left out the figures: Python lacks matplotlib (tools/setup installs python3-matplotlib)"]
    assert ".csv" in paper.output and ".png" not in paper.output and paper.output.endswith(" 2\n")


def test_the_page_is_the_same_without_both(done, tmp_path, monkeypatch):
    without = done(MATPLOTLIB + VTK, "page")
    assert (without.code, without.errors) == (0, "")
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    assert report.main([str(fake_page.write_paper(tmp_path / "page"))]) == 0
    pages = [re.sub(r"Made \S+ \S+ UTC", "", (folder / "report.html").read_text()) for folder in (without.folder, tmp_path / "page")]
    assert pages[0] == pages[1]


@pytest.mark.long
def test_an_export_wants_vtk_and_says_so_in_one_line(done):
    export = done(VTK, "export")
    assert (export.code, export.errors) == (2, "report: Python lacks vtk (tools/setup installs python3-vtk9)\n")


def test_the_accuracy_study_leaves_out_figures(done):
    accuracy = done(MATPLOTLIB, "accuracy")
    assert accuracy.code == 0
    assert accuracy.left_out == ["left out the figures: Python lacks matplotlib (tools/setup installs python3-matplotlib)"]
    assert ".csv" in accuracy.output and ".png" not in accuracy.output


def test_the_accuracy_study_leaves_out_hausdorff_distances(done):
    accuracy = done(VTK, "accuracy")
    assert accuracy.code == 0
    assert accuracy.left_out == ["left out Hausdorff distances of shapes: Python lacks vtkmodules (tools/setup installs python3-vtk9)"]
    assert ".png" in accuracy.output


def test_diagrams_want_matplotlib_and_say_so_in_one_line(done):
    diagrams = done(MATPLOTLIB, "diagrams")
    assert (diagrams.code, diagrams.errors) == \
        (2, "draw_diagrams: Python lacks matplotlib (tools/setup installs python3-matplotlib)\n")
    assert not (diagrams.folder / "pictures").exists()


@pytest.mark.parametrize("hidden", [MATPLOTLIB, VTK])
def test_pictures_in_space_are_no_failure(done, hidden):
    space, drawn = done(hidden, "space"), done(hidden, "drawn")
    assert space.code == 0 and len(space.left_out) == 1 and space.errors.count("\n") == 1
    assert (drawn.code, drawn.errors) == (2, f"draw_pictures: Python lacks {hidden[0]} (tools/setup installs {INSTALLS[hidden]})\n")
