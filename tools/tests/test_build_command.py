"""tools/build: help, unknown presets, one build at a time, progress; with a cmake that builds nothing."""

import json
import os
import pty
import subprocess

import pytest

from copied_tools import PROJECT, CopiedTools

PRESETS = [one["name"] for one in json.loads((PROJECT / "CMakePresets.json").read_text())["configurePresets"]
           if not one.get("hidden")]
STEPS = 40
# Configuring says nothing; building prints as ninja does.
CMAKE = f"""echo "$@" >>"$CALLS"
[ "$1" = --build ] || exit 0
for step in $(seq 1 {STEPS}); do echo "[$step/{STEPS}] Building CXX object part$step.o"; done
"""
FAILING = CMAKE + """echo "FAILED: part7.o"
echo "core/part.cpp:7:1: error: expected ';'"
exit 1"""


@pytest.fixture
def tools(tmp_path, monkeypatch) -> CopiedTools:
    monkeypatch.setenv("CALLS", str(tmp_path / "calls"))
    tools = CopiedTools(tmp_path, "tools/build", "CMakePresets.json")
    tools.stand_in("cmake", CMAKE)
    return tools


def calls(tmp_path) -> list[str]:
    return (tmp_path / "calls").read_text().splitlines() if (tmp_path / "calls").exists() else []


def test_help_names_every_preset_and_builds_nothing(tools, tmp_path):
    done = tools.call("build", "--help")
    assert done.returncode == 0
    assert "tools/build [PRESET [CMAKE OPTION...]]" in done.stdout
    assert [line.split(":")[0].strip() for line in done.stdout.splitlines() if line.startswith("    ")] == PRESETS
    assert calls(tmp_path) == [] and not (tools.root / "build").exists()


@pytest.mark.parametrize("word", ["relaese", "base", "re", "--preset", "-DMUSCLEBENCH_NATIVE=ON"])
def test_a_word_that_is_no_preset_is_answered_in_one_line(tools, tmp_path, word):
    done = tools.call("build", word)
    assert done.returncode == 2 and done.stdout == ""
    assert len(done.stderr.splitlines()) == 1 and f"'{word}'" in done.stderr
    if not word.startswith("-"):
        assert f"there are: {', '.join(PRESETS)}" in done.stderr
    assert calls(tmp_path) == [] and not (tools.root / "build").exists()


def test_a_missing_cmake_is_told_with_its_cure(tools):
    for name in ("bash", "cut", "paste", "grep", "sed", "awk", "nproc", "mkdir", "dirname"):
        tools.stand_in(name, f'exec {subprocess.check_output(["which", name], text=True).strip()} "$@"')
    (tools.bin / "cmake").unlink()
    done = tools.call("build", PATH=str(tools.bin))
    assert (done.returncode, done.stderr) == (
        2, "tools/build: cmake is missing; tools/setup installs it, or names what to install\n")


def test_a_log_gets_a_line_each_tenth(tools, tmp_path):
    done = tools.call("build", "debug", "-DMUSCLEBENCH_WITH_TESTS=OFF")
    assert done.returncode == 0, done.stderr
    told = done.stdout.splitlines()
    assert told[0] == "Building (debug) ..."
    assert [line.split(" built")[0] for line in told[1:]] == [f"debug: {percent} %" for percent in range(10, 101, 10)]
    assert f"(8 of {STEPS}), about " in told[2]
    assert "[40/40] Building CXX object part40.o" in (tools.root / "build" / "debug.log").read_text()
    assert calls(tmp_path)[0] == "--preset debug -DMUSCLEBENCH_WITH_TESTS=OFF"


def test_a_build_of_few_steps_tells_no_progress(tools):
    tools.stand_in("cmake", CMAKE.replace(str(STEPS), "19"))
    assert tools.call("build").stdout == "Building (release) ...\n"


def test_a_failed_build_names_the_first_error(tools):
    tools.stand_in("cmake", FAILING)
    done = tools.call("build")
    assert done.returncode == 2
    assert done.stderr.startswith("tools/build: the build of preset 'release' failed (core/part.cpp:7:1: error: expected ';'); ")
    assert "part7.o" not in done.stdout


def test_a_terminal_sees_one_line_of_progress_and_what_the_compiler_says(tools):
    tools.stand_in("cmake", FAILING)
    inside, outside = pty.openpty()
    with tools.start("build", stdout=outside, stderr=subprocess.DEVNULL) as process:
        os.close(outside)
        shown = b""
        try:
            while piece := os.read(inside, 4096):
                shown += piece
        except OSError:  # the end of a terminal
            pass
    os.close(inside)
    lines = shown.decode().split("\r\n")
    assert process.returncode == 2
    assert any(line.endswith("core/part.cpp:7:1: error: expected ';'") for line in lines)
    progress = next(line for line in lines if "2 % built (1 of 40)" in line)
    assert "100 % built (40 of 40)" in progress  # in the same line


def test_a_second_build_waits_for_the_first_and_says_so(tools, tmp_path):
    os.mkfifo(tmp_path / "gate")
    # The sleep gives a second that does not wait the time to be seen.
    tools.stand_in("cmake", f'[ "$1" = --build ] && read line <{tmp_path}/gate && sleep 0.3; echo "$PPID" >>"$CALLS"')
    with tools.start("build", stdout=subprocess.PIPE) as first:
        assert first.stdout.readline() == "Building (release) ...\n"
        with tools.start("build", stdout=subprocess.PIPE) as second:
            assert second.stdout.readline() == (
                "tools/build: another build of preset 'release' is under way; waiting for its end\n")
            (tmp_path / "gate").write_text("on\n")
            assert second.stdout.readline() == "Building (release) ...\n"
            (tmp_path / "gate").write_text("on\n")
    assert first.returncode == second.returncode == 0
    assert calls(tmp_path) == [str(first.pid)] * 2 + [str(second.pid)] * 2


def test_builds_of_two_presets_do_not_wait_for_each_other(tools, tmp_path):
    os.mkfifo(tmp_path / "gate")
    tools.stand_in("cmake", f'[ "$1 $3" = "--build release" ] && read line <{tmp_path}/gate; exit 0')
    with tools.start("build", stdout=subprocess.PIPE) as first:
        assert first.stdout.readline() == "Building (release) ...\n"
        assert tools.call("build", "debug").returncode == 0
        (tmp_path / "gate").write_text("on\n")
