"""tools/setup: what it asks apt for, locks that others hold, systems without apt; with an apt that installs nothing."""

import subprocess

import pytest

from copied_tools import PROJECT, CopiedTools

PACKAGES = """# A list
build-essential
python python3-pandas   # with words
optional valgrind
"""
APT = 'echo "$@" >>"$CALLS"'
# `$HELD/1` to `$HELD/3`: for each there is one call more that does not get the lock.
BUSY_APT = APT + """
for lock in "$HELD"/*; do
  [ -e "$lock" ] || break
  rm "$lock"
  echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 4711 (apt-get)"
  echo "E: Unable to lock directory /var/lib/apt/lists/"
  exit 100
done"""


@pytest.fixture
def tools(tmp_path, monkeypatch) -> CopiedTools:
    """On a Debian system on which build-essential is installed."""
    monkeypatch.setenv("CALLS", str(tmp_path / "calls"))
    monkeypatch.setenv("HELD", str(tmp_path / "held"))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.delenv("MUSCLEBENCH_NO_SETUP", raising=False)
    (tmp_path / "held").mkdir()
    tools = CopiedTools(tmp_path, "tools/setup")
    (tools.root / "tools" / "packages.txt").write_text(PACKAGES)
    tools.stand_in("dpkg-query", '[ $# = 2 ] && echo "installed npm (= 9)," || case ${!#} in build-essential) printf installed ;; esac')
    tools.stand_in("apt-get", APT)
    tools.stand_in("id", "echo 0")
    tools.stand_in("sleep", "exit 0")
    return tools


def installed(tmp_path) -> list[str]:
    """Names of packages that apt was asked for."""
    calls = (tmp_path / "calls").read_text().splitlines() if (tmp_path / "calls").exists() else []
    return [call.split("--no-install-recommends ")[1] for call in calls if " install " in call]


@pytest.mark.parametrize(("words", "asked"), [
    ((), "python3-pandas"), (("--all",), "python3-pandas valgrind"), (("--python",), "python3-pandas"),
    (("clang", "build-essential"), "python3-pandas clang"), (("--python", "npm", "nodejs"), "python3-pandas nodejs")])
def test_only_what_is_missing_is_installed(tools, tmp_path, words, asked):
    done = tools.call("setup", *words)
    assert done.returncode == 0, done.stderr
    assert installed(tmp_path) == [asked]
    assert done.stdout == f"Installing {len(asked.split())} Debian packages: {asked}\n"


def test_for_python_no_compiler_is_installed(tools, tmp_path):
    tools.stand_in("dpkg-query", "true")
    tools.call("setup", "--python")
    assert installed(tmp_path) == ["python3-pandas"]


def test_it_waits_for_a_lock_that_another_apt_holds_and_says_so_once(tools, tmp_path):
    tools.stand_in("apt-get", BUSY_APT)
    for number in range(3):
        (tmp_path / "held" / str(number)).touch()
    done = tools.call("setup")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[1:] == ["Waiting for apt's lock, up to 15 minutes (It is held by process 4711 (apt-get))"]
    assert installed(tmp_path) == ["python3-pandas"]
    timeouts = [call.split("DPkg::Lock::Timeout=")[1].split()[0] for call in (tmp_path / "calls").read_text().splitlines()]
    assert timeouts == ["0", "3", "3", "3", "0"]  # update and install: apt's own waiting comes after the line that says so


def test_a_lock_that_stays_ends_it(tools):
    tools.stand_in("apt-get", 'echo "E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 1 (apt)"; exit 100')
    done = tools.call("setup")
    assert done.returncode == 2
    assert done.stderr.startswith("tools/setup: apt-get update failed (E: Could not get lock /var/lib/dpkg/lock-frontend. ")


def test_another_failure_of_apt_is_told_at_once(tools, tmp_path):
    tools.stand_in("apt-get", APT + '\necho "E: Unable to locate package python3-pandas"; exit 100')
    done = tools.call("setup")
    assert (done.returncode, len((tmp_path / "calls").read_text().splitlines())) == (2, 1)
    assert "(E: Unable to locate package python3-pandas); the whole log is " in done.stderr


@pytest.mark.parametrize("absent", ["dpkg-query", "apt-get"])
def test_elsewhere_it_names_the_packages_and_lets_others_go_on(tools, tmp_path, absent):
    for name in ("bash", "dirname", "sed"):
        tools.stand_in(name, f'exec {subprocess.check_output(["which", name], text=True).strip()} "$@"')
    (tools.bin / absent).unlink()
    done = tools.call("setup", "clang", PATH=str(tools.bin))
    assert done.returncode == 0 and not (tmp_path / "calls").exists()
    assert len(done.stderr.splitlines()) == 1
    assert "not a Debian system" in done.stderr and done.stderr.endswith(": build-essential python3-pandas clang\n")
    assert tools.call("setup", PATH=str(tools.bin), MUSCLEBENCH_NO_SETUP="1").stderr == ""


def test_it_can_be_told_to_do_nothing(tools, tmp_path):
    done = tools.call("setup", MUSCLEBENCH_NO_SETUP="1")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "") and not (tmp_path / "calls").exists()


@pytest.mark.parametrize("words", [("--al",), ("clang", "--all"), ("--all", "--python")])
def test_an_option_that_there_is_not_is_answered_in_one_line(tools, tmp_path, words):
    done = tools.call("setup", *words)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert f"'{words[-1]}' is not an option" in done.stderr and not (tmp_path / "calls").exists()


def test_python_tools_can_import_what_the_list_names_for_them():
    """The names of Debian's packages stand for those in pyproject.toml."""
    listed = {line.removeprefix("python python3-").strip() for line in (PROJECT / "tools" / "packages.txt").read_text().splitlines()
              if line.startswith("python python3-")}
    assert listed == {"numpy", "pandas", "matplotlib", "scipy", "vtk9", "jinja2"}
    told = (PROJECT / "tools" / "pyproject.toml").read_text()
    assert all(f'"{name.rstrip("9")}>=' in told for name in listed)
