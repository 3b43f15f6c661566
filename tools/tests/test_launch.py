"""What tools do before they start: options first, then packages and builds. Stand-ins for setup, build and programs."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from copied_tools import PROJECT
from musclebench.page.bundle import script_file

TOOLS = ("accuracy", "board", "bundle", "compare", "budget", "effects", "experiment", "fuzz", "hard", "import", "moment-arms", "mutants", "nightly",
         "paper", "population", "publish", "release", "report", "safe-step", "speed", "stress")
NEEDED_WORDS = {"board": (".",), "bundle": (".",),
                "import": (".", "--map", "tools/pyproject.toml", "--out", "new"), "compare": ("HEAD", "HEAD"), "experiment": ("paper",),
                "population": ("ankle/soleus", "--shape", "size=5"),
                "release": ("1.0.0",), "report": (".",), "safe-step": ("hard/step_size",)}
PACKAGES = {"numpy", "pandas", "scipy", "matplotlib", "vtk", "vtkmodules", "jinja2", "PIL"}
# Hides packages from every Python that has its folder on the path.
HIDES = """import os, sys
sys.modules.update(dict.fromkeys(os.environ["HIDDEN_PACKAGES"].split()))
"""
SAYS = 'echo "$(basename "$0") $*" >>"$CALLS"; exit ${CODE:-0}'
RELEASE = "build release"


class Tree:
    """A copy of the sources whose tools only say what they would do. Nothing is built."""

    def __init__(self, folder: Path):
        self.root, self.calls_file, self.hidden = folder / "tree", folder / "calls", ""
        for name in ("tools", "bench/experiments"):
            shutil.copytree(PROJECT / name, self.root / name, ignore=shutil.ignore_patterns(
                "tests", "__pycache__", "node_modules", ".pytest_cache") if name == "tools" else None)
        for name in ("setup", "build"):
            self.replace(self.root / "tools" / name, f"#!/bin/bash\n{SAYS}\n")
        for name in TOOLS:
            self.replace(self.root / "tools" / f"{name.replace('-', '_')}.py",
                         "import os, sys\nopen(os.environ['CALLS'], 'a').write(' '.join(['started', *sys.argv[1:]]) + '\\n')\n")
        (folder / "hides").mkdir()
        (folder / "hides" / "sitecustomize.py").write_text(HIDES)
        self.environment = os.environ | {"CALLS": str(self.calls_file), "PYTHONPATH": str(folder / "hides"),
                                         "PYTHONDONTWRITEBYTECODE": "1", "LC_ALL": "C"}

    @staticmethod
    def replace(path: Path, text: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def call(self, name: str, *words, **more: str) -> subprocess.CompletedProcess:
        self.calls_file.unlink(missing_ok=True)
        return subprocess.run([self.root / "tools" / name, *map(str, words)], cwd=self.root, capture_output=True, text=True,
                              check=False, timeout=60, env=self.environment | {"HIDDEN_PACKAGES": self.hidden} | more)

    @property
    def calls(self) -> list[str]:
        return [line.strip() for line in self.calls_file.open()] if self.calls_file.exists() else []


@pytest.fixture(scope="module")
def copied(tmp_path_factory) -> Tree:
    tree = Tree(tmp_path_factory.mktemp("launch"))
    for words in (("init", "-q"), ("add", "."), ("-c", "user.name=x", "-c", "user.email=x@y", "commit", "-qm", "x")):
        subprocess.run(["git", *words], cwd=tree.root, check=True, capture_output=True)
    return tree


@pytest.fixture
def tree(copied) -> Tree:
    copied.hidden = ""
    shutil.rmtree(copied.root / "build", ignore_errors=True)
    return copied


@pytest.fixture
def fresh(tree) -> Tree:
    """A machine that has nothing but Python."""
    tree.hidden = " ".join(PACKAGES)
    return tree


@pytest.mark.parametrize("name", TOOLS)
def test_a_typo_is_told_in_one_line_before_anything_is_installed_or_built(fresh, name):
    done = fresh.call(name, *NEEDED_WORDS.get(name, ()), "--no-such-option")
    assert done.returncode == 2 and fresh.calls == []
    assert done.stderr == f"{name}: unrecognized arguments: --no-such-option; --help shows the options\n"


@pytest.mark.parametrize("name", TOOLS)
def test_help_needs_nothing(fresh, name):
    done = fresh.call(name, "--help")
    assert (done.returncode, done.stderr, fresh.calls) == (0, "", [])
    assert done.stdout.startswith(f"usage: tools/{name} ")


@pytest.mark.parametrize(("name", "words", "told"), [
    ("accuracy", ("--data", "/nowhere"), "/nowhere: has no lhdl.json"),
    ("accuracy", ("--shard", "3/2"), "'3/2' is not like 2/3"),
    ("accuracy", ("--musclebench", "/nowhere"), "/nowhere: no such program"),
    ("budget", ("--finest", "x"), "argument --finest: invalid int value: 'x'"),
    ("effects", ("--repetitions", "0"), "--repetitions 0: must be 1 or more"),
    ("paper", ("--scene", "mine.toml"), "--scene mine.toml: no such file"),
    ("paper", ("--out", "tools/setup"), "--out tools/setup: is a file"),
    ("experiment", ("papper",), "'papper': no experiment of that name; did you mean 'paper'?"),
    ("experiment", ("tools/pyproject.toml",), "tools/pyproject.toml: line"),
    ("experiment", ("paper", "--merge", "/nowhere"), "/nowhere: no such folder"),
    ("population", ("ankle/soleus",), "--shape is missing"), ("population", ("ankle/soleus", "--shape", "scael=5"), "there is no kind 'scael'"),
    ("moment-arms", ("--experiment", "bench/experiments/paper.toml"), "needs mode run"),
    ("nightly", ("--append", "/nowhere"), "/nowhere: no such folder of a night"),
    ("compare", ("HEAD", "no-such-branch"), "no-such-branch: neither a folder of results nor a revision"),
    ("compare", ("tools", "HEAD"), "one is a folder of results, the other is not"),
    ("publish", ("--only", "papers"), "invalid choice: 'papers'"),
    ("publish", (), "the working tree has changes"),
    ("report", ("/nowhere",), "/nowhere: no such folder of results"),
    ("safe-step", ("mine.toml",), "--scene mine.toml: no such file"),
    ("speed", ("--micro", "/nowhere"), "/nowhere: no such program"),
    ("fuzz", ("--seconds", "0"), "--seconds 0: must be a number above 0"),
    ("mutants", ("--only", "no-such-fault"), "--only no-such-fault: no such fault; --list prints them"),
    ("mutants", ("--faults", "/nowhere.toml"), "/nowhere.toml: [Errno 2] No such file"),
    ("mutants", ("--jobs", "0"), "--jobs 0: must be 1 or more"), ("mutants", ("--shard", "3/2"), "'3/2' is not like 2/3"),
    ("mutants", ("--seen", "/nowhere/seen.json"), "--seen /nowhere/seen.json: no file can be there"),
    ("mutants", ("--seen", "tools/setup"), "tools/setup: not the JSON that a campaign writes"),
    ("mutants", ("--scratch", "tools/setup"), "--scratch tools/setup: is a file"),
])
def test_what_the_disk_tells_is_told_before_the_build(fresh, name, words, told):
    if name == "publish":
        (fresh.root / "tools" / "changed").touch()
    done = fresh.call(name, *words)
    (fresh.root / "tools" / "changed").unlink(missing_ok=True)
    assert done.returncode == 2 and fresh.calls == []
    assert len(done.stderr.splitlines()) == 1 and told in done.stderr


@pytest.mark.parametrize(("name", "words", "calls"), [
    *((name, NEEDED_WORDS.get(name, ()), ["setup", RELEASE])
      for name in ("accuracy", "budget", "effects", "experiment", "hard", "moment-arms", "nightly", "paper", "safe-step")),
    *((name, NEEDED_WORDS[name], ["setup pybind11-dev", RELEASE]) for name in ("import", "population")),
    ("speed", (), ["setup", "build bench"]),
    ("publish", ("--quick",), ["setup", "build bench"]),
    ("fuzz", ("--seconds", "1"), ["setup clang", "build fuzz"]),
    ("compare", ("HEAD", "HEAD"), ["setup"]), ("mutants", (), ["setup"]),
    # What only reads results, or is told which program to run, neither installs nor builds.
    ("accuracy", ("--report-only",), []), ("speed", ("--report-only",), []),
    ("experiment", ("paper", "--merge", "tools"), []), ("experiment", ("paper", "--musclebench", "/bin/true"), []),
    ("paper", ("--musclebench=/bin/true",), []), ("nightly", ("--simulate", "1"), []), ("nightly", ("--report-only",), []),
    ("publish", ("--write-only",), []), ("publish", ("--dry-run",), []),
    ("compare", ("tools", "bench"), []), ("compare", ("/bin/true", "/bin/false"), []),
    ("report", ("tools", "--export", "vtk"), []), ("mutants", ("--check",), []), ("mutants", ("--list",), []),
])
def test_only_what_is_needed_is_installed_and_built(tree, name, words, calls):
    done = tree.call(name, *words)
    assert done.returncode == 0, done.stderr
    assert tree.calls == [*calls, " ".join(["started", *words])]


@pytest.fixture
def without_npm(tree) -> dict[str, str]:
    """The environment of a call."""
    for name in ("bash", "dirname", "basename", "dpkg-query"):
        tree.replace(tree.root / "bin" / name, f'#!/bin/bash\nexec {shutil.which(name)} "$@"\n')
    return {"PATH": str(tree.root / "bin")}


@pytest.mark.parametrize("code", ["0", "2"])
def test_a_page_brings_npm_where_that_is_missing_and_goes_without_where_it_cant_be_had(tree, without_npm, code):
    assert tree.call("report", "tools", CODE=code, **without_npm).returncode == 0
    assert tree.calls == ["setup --python nodejs npm", "started tools"]


def test_a_page_whose_program_is_made_needs_no_npm(tree, without_npm):
    made = script_file(tree.root / "tools" / "page", tree.root / "build" / "page")
    tree.replace(made, "")
    assert tree.call("report", "tools", **without_npm).returncode == 0
    assert tree.calls == ["started tools"]


def test_packages_that_stay_missing_are_named_in_one_line(fresh):
    """As on a system without apt, where setup installs nothing."""
    done = fresh.call("report", "tools", "--export", "vtk")
    assert done.returncode == 2 and fresh.calls == ["setup --python"]
    assert done.stderr.startswith("report: Python lacks numpy, pandas, scipy, jinja2 (") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("code", ["2", "1"])
def test_a_failure_to_install_ends_it(tree, code):
    assert tree.call("paper", CODE=code).returncode == int(code)
    assert tree.calls == ["setup"]


@pytest.mark.parametrize(("name", "build"), [
    ("accuracy", RELEASE), ("experiment", RELEASE), ("speed", "build bench")])
def test_a_dry_run_builds_nothing(fresh, name, build):
    words = (*NEEDED_WORDS.get(name, ()), "--dry-run")
    done = fresh.call(name, *words)
    assert (done.returncode, done.stderr, fresh.calls) == (0, "", [])
    assert f"  tools/setup\n  tools/{build}\n" in done.stdout
    fresh.hidden = ""
    program = fresh.root / "build" / build.split()[1] / "bench" / "musclebench"
    fresh.replace(program, "#!/bin/bash\n")
    assert fresh.call(name, *words).returncode == 0 and fresh.calls == [" ".join(["started", *words])]


def test_what_is_installed_and_built_is_told_beside_the_output(tree):
    """Names of cases are read by programs."""
    tree.replace(tree.root / "tools" / "build", "#!/bin/bash\necho building\n")
    done = tree.call("experiment", "paper", "--list-cases")
    tree.replace(tree.root / "tools" / "build", f"#!/bin/bash\n{SAYS}\n")
    assert (done.stdout, done.stderr) == ("", "building\n")


def test_every_tool_that_launches_is_tested_here():
    found = {path.name for path in (PROJECT / "tools").iterdir()
             if path.is_file() and path.suffix == "" and "/launch\" " in path.read_text(errors="replace")}
    assert found == set(TOOLS)
