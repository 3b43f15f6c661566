"""The Dockerfile without docker: its commands run, in its order, on the files that it has copied by then."""

import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from copied_tools import PROJECT, CopiedTools
from program import PROGRAM, needs_program

TEXT = re.sub(r"\\\n\s*", "", (PROJECT / "Dockerfile").read_text())
STEPS = [line.split(" ", 1) for line in TEXT.splitlines() if line and not line.startswith("#")]
IGNORED = (PROJECT / ".dockerignore").read_text().split()
EVERYTHING = ("tools", "CMakePresets.json", "CMakeLists.txt")  # as far as its commands read it


def copied(root: Path, words: list[str]) -> None:
    *sources, target = words
    for source in EVERYTHING if sources == ["."] else sources:
        assert (PROJECT / source).exists() and source not in IGNORED
        into = root / source if sources == ["."] else root / target / Path(source).name
        into.parent.mkdir(parents=True, exist_ok=True)
        if (PROJECT / source).is_dir():
            shutil.copytree(PROJECT / source, into, dirs_exist_ok=True, ignore=shutil.ignore_patterns("tests", "musclebench", "page"))
        else:
            shutil.copy(PROJECT / source, into)


def test_its_commands_run_in_their_order(tmp_path):
    tools, built = CopiedTools(tmp_path), None
    tools.stand_in("dpkg-query", "true")
    tools.stand_in("apt-get", f'echo "$@" >>{tmp_path}/asked')
    tools.stand_in("id", "echo 0")
    tools.stand_in("cmake", "[ $1 = --build ] && mkdir -p build/release/bench build/release/python && touch build/release/bench/musclebench; exit 0")
    ran = []
    for step, words in STEPS:
        if step == "FROM":
            assert words.split()[0] == "debian:12"
            built, tools.root = tools.root, tmp_path / words.replace(" ", "-")
            tools.root.mkdir()
        elif step == "COPY" and words.startswith("--from=build"):
            source, target = (word.removeprefix("/musclebench/") for word in words.split()[1:])
            assert (built / source).exists()
            (tools.root / target).parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if (built / source).is_dir() else shutil.copy)(built / source, tools.root / target)
        elif step == "COPY":
            copied(tools.root, words.split())
        elif step == "RUN":
            tool, *arguments = shlex.split(words)
            done = tools.call(tool.removeprefix("tools/"), *arguments, MUSCLEBENCH_NO_SETUP="")
            assert done.returncode == 0, done.stderr
            ran.append(tool)
        elif step == "ENTRYPOINT":
            assert (tools.root / words.strip('["]')).is_file()
    assert ran == ["tools/setup", "tools/build", "tools/setup"]
    asked = [line for line in (tmp_path / "asked").read_text().splitlines() if " install " in line]
    assert "libfcl-dev" in asked[0] and "libfcl-dev" not in asked[1] and "libfcl0.7" in asked[1] and "python3-pandas" in asked[1]


def test_options_of_its_build_are_those_of_the_project():
    known = (PROJECT / "CMakeLists.txt").read_text()
    options = re.findall(r"-D(\w+)=", TEXT)
    assert all(f"option({name} " in re.sub(r" +", " ", known) for name in options)


@pytest.mark.long
@needs_program
def test_it_has_the_libraries_that_the_program_is_linked_with():
    if not shutil.which("dpkg") or not shutil.which("objdump"):
        pytest.skip("dpkg or objdump is missing: which package a library comes from is not known")
    listed = subprocess.run(["objdump", "-p", PROGRAM], capture_output=True, text=True, check=True).stdout
    found = dict(re.findall(r"(\S+) => (\S+)", subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout))
    packages = set()
    for name in re.findall(r"NEEDED\s+(\S+)", listed):
        owner = subprocess.run(["dpkg", "-S", os.path.realpath(found[name])], capture_output=True, text=True, check=False).stdout
        packages.add(owner.partition(":")[0])
    in_every_debian = {"libc6", "libstdc++6", "libgcc-s1", ""}
    of_libraries = {"libbullet3.24", "libembree3-3", "libvtk9.1", "libsimbody3.7"}  # the image is built without them
    last = [words for step, words in STEPS if step == "RUN"][-1].split()
    assert packages - in_every_debian - of_libraries <= set(last)


def test_without_a_daemon_and_without_root_its_check_is_left_out(tmp_path):
    tools = CopiedTools(tmp_path, ".ci/image", "Dockerfile")
    tools.stand_in("id", "echo 1000")
    for script, told in (("exit 1", "no docker daemon answers"), ('[ "$1" = info ]', "debian:12 can't be had")):
        tools.stand_in("docker", script)
        done = subprocess.run([tools.root / ".ci" / "image"], capture_output=True, text=True, check=False, env=tools.environment())
        assert done.returncode == 0
        assert done.stdout.splitlines() == [f"image: {told}", "image: left out, folders made by debootstrap need root and the right to mount"]
    tools.stand_in("docker", '[ "$1" != build ]')
    assert subprocess.run([tools.root / ".ci" / "image"], check=False, env=tools.environment()).returncode == 1
