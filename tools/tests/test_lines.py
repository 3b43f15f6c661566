"""Lines are counted by room, without blank lines, comments and docstrings, as they are committed."""

import shutil
import subprocess
from pathlib import Path

import pytest

TOOL = Path(__file__).resolve().parent.parent / "lines"
SOURCES = {
    "core/mesh/shapes.cpp": "// why\n\nint three() {\n  /* a comment\n     of two lines */\n  return 3;  // three\n}\n",
    "core/mesh/tests/shapes_test.cpp": "int main() {}\n",
    "bench/absent_test.cpp": "int main() {}\n",
    "tools/draw.py": '"""What it does."""\n\n# why\ndef draw():\n    """How."""\n    text = """of\ntwo lines"""\n    return text\n',
    "README.md": "Not counted.\n",
}


@pytest.fixture
def project(tmp_path):
    for name, text in SOURCES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    shutil.copy(TOOL, tmp_path / "tools/lines")
    who = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], [*who, "commit", "-qm", "First"], ["tag", "first"]):
        subprocess.run(["git", "-C", str(tmp_path), *words], check=True)
    (tmp_path / "core/mesh/shapes.cpp").write_text("int three() { return 3; }\n")
    subprocess.run(["git", "-C", str(tmp_path), *who, "commit", "-qam", "Second"], check=True)
    (tmp_path / "core/mesh/shapes.cpp").write_text("\n".join(["int x;"] * 99))
    return tmp_path


def lines(project, *revisions):
    return subprocess.run([str(project / "tools/lines"), *revisions], capture_output=True, text=True, check=False)


def test_counts_what_runs_by_kind_and_room(project):
    done = lines(project, "first", "HEAD")
    assert done.returncode == 0, done.stderr
    for row in ("| C++ | 3 | 1 |", "| C++ tests | 2 | 2 |", "| Python | 4 | 4 |", "| Python tests | 0 | 0 |", "| all | 9 | 7 |",
                "| core/mesh | 4 | 2 |", "| bench | 1 | 1 |", "| tools | 4 | 4 |"):
        assert row in done.stdout.splitlines(), row


def test_refuses_what_is_no_revision(project):
    done = lines(project, "nothing")
    assert done.returncode != 0 and done.stderr.strip().startswith("tools/lines: nothing: is no revision")
