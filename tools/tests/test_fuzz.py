"""`tools/fuzz` over a stand-in for libFuzzer, and over the real programs where they are built."""

import subprocess
import sys
from pathlib import Path

import fuzz
import pytest

from musclebench.fuzzing.fuzzer import PROGRAM_NAME, Progress, find_fuzzers, progress_in, report_in

TOOLS = Path(fuzz.__file__).parent
BUILD = TOOLS.parent / "build" / "fuzz"

# Reads files of its corpus folders as libFuzzer does; one that holds "bad" is a finding. Reader 'broken' can't start.
STAND_IN = f"""#!{sys.executable}
import sys
from pathlib import Path
words = sys.argv[1:]
if "--list" in words:
    print("good\\nwrong\\nbroken")
    sys.exit()
options = dict(word.lstrip("-").split("=", 1) for word in words if word.startswith("-"))
folders = [Path(word) for word in words if not word.startswith("-")]
if "write-seeds" in options:
    Path(options["write-seeds"], "seed_1").write_text("bad" if options["reader"] == "wrong" else "seed")
    sys.exit()
files = {{path.read_text(): path for folder in folders for path in folder.iterdir()}}
if "merge" in options:
    for text in files:
        Path(folders[0], text).write_text(text)
    sys.exit()
if options["reader"] == "broken":
    sys.exit("cannot start")
Path(folders[0], "new").write_text("new")
print("#7 NEW    cov: 12 ft: 30", file=sys.stderr)
if "bad" in files:
    Path(options["artifact_prefix"] + "crash-1").write_text("bad")
    print("reader.cpp:3:4: runtime error: division by zero\\nSUMMARY: UndefinedBehaviorSanitizer", file=sys.stderr)
    sys.exit(77)
print("stat::number_of_executed_units: 31", file=sys.stderr)
"""


@pytest.fixture
def build(tmp_path) -> Path:
    program = tmp_path / "build" / "room" / "fuzz" / PROGRAM_NAME
    program.parent.mkdir(parents=True)
    program.write_text(STAND_IN)
    program.chmod(0o755)
    return tmp_path / "build"


def run(build: Path, *words: str) -> int:
    return fuzz.main([*words, "--seconds", "1", "--build", str(build), "--out", str(build.parent / "out")])


def test_a_reader_that_holds_has_a_line_and_keeps_its_corpus(build, capsys):
    assert run(build, "good") == 0
    assert capsys.readouterr().out.split() == "good 31 executions, coverage 12, corpus of 2 files, no findings".split()
    kept = build.parent / "out" / "good" / "corpus"
    assert {path.read_text() for path in kept.iterdir()} == {"seed", "new"}


def test_a_finding_is_told_and_kept(build, capsys):
    assert run(build, "good", "wrong", "--jobs", "2") == 1
    line, = [line for line in capsys.readouterr().out.splitlines() if line.startswith("wrong")]
    finding = build.parent / "out" / "wrong" / "findings" / "crash-1"
    assert line.endswith(f"1 finding: runtime error: division by zero; {finding}")
    assert finding.read_text() == "bad"


@pytest.mark.parametrize(("words", "problem"), [
    (["none"], "'none' is no reader; there are: good, wrong, broken"),
    (["broken"], "--reader=broken ended with 1"),
    (["good", "--jobs", "0"], "--jobs 0: must be 1 or more"),
])
def test_what_cannot_be_done_is_one_line(build, capsys, words, problem):
    assert run(build, *words) == 2
    error = capsys.readouterr().err
    assert problem in error and error.count("\n") == 1


def test_without_a_build_it_says_so(tmp_path, capsys):
    assert run(tmp_path / "none") == 2
    assert "holds no fuzzers" in capsys.readouterr().err


def test_progress_is_the_last_of_the_log():
    assert progress_in("#1 INITED cov: 3\n#20 NEW cov: 5 ft: 9\n") == Progress(20, 5)
    assert progress_in("") == Progress(0, 0)


@pytest.mark.parametrize(("log", "report"), [
    ("terminate called\n  what():  vector::reserve\nSUMMARY: libFuzzer: deadly signal\n", "what():  vector::reserve"),
    ("==1== ERROR: libFuzzer: timeout after 11 seconds\nSUMMARY: libFuzzer: timeout\n", "SUMMARY: libFuzzer: timeout"),
    ("nothing", "see the log"),
])
def test_a_report_is_one_line(log, report):
    assert report_in(log) == report


def test_every_reader_runs_for_a_second(tmp_path):
    fuzzers = find_fuzzers(BUILD, TOOLS.parent)
    if not fuzzers:
        pytest.skip("no fuzzers are built: tools/build fuzz")
    names = {fuzzer.reader for fuzzer in fuzzers}
    assert {"ply", "obj", "off", "stl", "scene", "motion", "landmarks", "recording"} <= names
    done = subprocess.run([sys.executable, TOOLS / "fuzz.py", "off", "--seconds", "1", "--out", tmp_path],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert any((tmp_path / "off" / "corpus").iterdir())
