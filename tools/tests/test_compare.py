"""tools/compare: what it finds, what it does not take for a change, what it refuses."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest

import compare as command
from musclebench.comparison import instructions, interleaved, revisions
from musclebench.comparison.metrics import values_of
from musclebench.comparison.result_set import read_set
from musclebench.comparison.verdicts import compare
from program import PROGRAM, needs_program

SCENE = "hard/resting_contact"
FAKE = Path(__file__).resolve().parent / "fake_compared.py"


def program(folder: Path, name: str, **told) -> str:
    """A stand-in that behaves so."""
    path = folder / f"{name}.py"
    shutil.copy(FAKE, path)
    path.write_text(f"{path.read_text()}# {name}\n# {json.dumps(told)}\n")  # another name has another digest
    return str(path)


def run(folder: Path, before: str, after: str, *more) -> int:
    return command.main([before, after, "--out", str(folder / "out"), "--repetitions", "6", "--scene", SCENE, *more])


@pytest.fixture(scope="module", autouse=True)
def nothing_is_counted():
    """By callgrind, under which a stand-in takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(interleaved, "why_not_by_callgrind", lambda: "left out of this test")
        yield


@pytest.fixture(scope="module")
def sets(tmp_path_factory) -> Path:
    """{before,after}: what is read again by many tests; one backend is 10 % slower."""
    folder = tmp_path_factory.mktemp("compared")
    assert run(folder, program(folder, "a", seed=1), program(folder, "b", seed=2, slower={"tree": 1.1}),
               "--repetitions", "8") == 1
    return next((folder / "out" / "runs").iterdir())


@pytest.fixture
def copies(sets, tmp_path) -> tuple[Path, Path]:
    return tuple(shutil.copytree(sets / side, tmp_path / side) for side in ("before", "after"))


def test_a_slowdown_is_found_in_its_backend_only(sets):
    found = compare(read_set(sets / "before"), read_set(sets / "after"))
    assert found.is_interleaved
    assert {(row.case, row.verdict) for row in found.changes} == {("resting_contact-tree", "slower")}
    row = next(row for row in found.changes if row.metric.name == "collision_ns")
    assert row.ratio.low < 1.1 < row.ratio.high and row.chance < 0.01


def test_the_report_is_markdown_with_ratio_and_spread(sets, capsys):
    assert command.main([str(sets / "before"), str(sets / "after"), "--out", str(sets / "again")]) == 1
    text = capsys.readouterr().out
    assert "| resting_contact-tree | collision_ns |" in text and "**slower**" in text
    assert "| case | runs | frame, median | 95 % | p95 | p99 | CV |" in text and "8 (warm-up 2 frames)" in text
    assert (sets / "again" / "compare.md").read_text() in text


def test_identical_programs_never_alarm(tmp_path, capsys):
    one = program(tmp_path, "a", spread=0.2)
    assert run(tmp_path, one, one, "--backend", "tree", "--backend", "grid") == 0
    assert "Both ran the same program" in capsys.readouterr().out


def test_what_only_the_judged_run_tells_is_no_difference_to_the_others(copies):
    """Suspect is what the Referee finds: the timed runs beside it end ok."""
    def say(side, status):
        path = copies[side] / "raw" / "resting_contact-grid-judged" / "run.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | {"status": status}))
        (path.parent / "measured.json").unlink(missing_ok=True)  # it notes the digest of the file

    def changes():
        return {(row.metric.name, row.before, row.after) for row in compare(*map(read_set, copies)).changes
                if row.case == "resting_contact-grid"}

    say(0, "suspect")
    assert changes() == {("status", "suspect", "ok")}
    say(1, "suspect")
    assert changes() == set()
    say(0, "timeout")
    assert ("status", "ok or timeout", "suspect") in changes()
    say(1, "timeout")
    assert changes() == {("status", "ok or timeout", "ok or timeout")}  # not the same from run to run


def test_suspect_is_no_change_where_only_one_side_was_judged(copies):
    path = copies[0] / "raw" / "resting_contact-grid-judged" / "run.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"status": "suspect"}))
    (path.parent / "measured.json").unlink()
    shutil.rmtree(copies[1] / "raw" / "resting_contact-grid-judged")
    assert not [row for row in compare(*map(read_set, copies)).changes if row.case == "resting_contact-grid"]


@pytest.mark.parametrize(("told", "metric"), [
    ({"hash": {"grid": "4567"}}, "state_hash"), ({"depth": {"grid": 0.0010000001}}, "p99_depth_m"),
    ({"status": "diverged"}, "status"),
])
def test_answers_have_to_be_the_same(told, metric, tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a"), program(tmp_path, "b", **told), "--backend", "grid") == 1
    assert f"| {metric} |" in capsys.readouterr().out


def test_few_runs_are_no_evidence(tmp_path, capsys):
    both = program(tmp_path, "a"), program(tmp_path, "b", slower={"tree": 1.5})
    assert run(tmp_path, *both, "--repetitions", "4", "--backend", "tree") == 0
    assert "too few runs" in capsys.readouterr().out


def measured_alone(folder: Path, factor: float, switches: int = 0) -> None:
    """As if the runs of the folder were of an invocation of their own, on a machine that takes `factor` times as long."""
    for run in (folder / "raw").iterdir():
        noted = json.loads((run / "measured.json").read_text())
        (run / "measured.json").write_text(json.dumps(noted | {"invocation": "another", "sha256": {}}))
        record = json.loads((run / "run.json").read_text())
        record["machine_state"]["involuntary_context_switches"] = switches
        record["cpu_ns"]["after_last_frame"] *= factor
        record["build_ns"] *= factor
        (run / "run.json").write_text(json.dumps(record))
        frames = pd.read_csv(run / "frames.csv")
        for column in ("detect_ns", "frame_ns"):
            frames[column] *= factor
        frames.to_csv(run / "frames.csv", index=False)


def test_what_was_not_interleaved_loses_the_machines_factor(copies):
    """Twice as slow in all: the machine's. One backend by more: its own."""
    measured_alone(copies[1], 2.0)
    found = compare(*map(read_set, copies))
    assert not found.is_interleaved and found.machine["collision_ns"] == pytest.approx(2.0, rel=0.03)
    assert {(row.case, row.verdict) for row in found.changes} == {("resting_contact-tree", "slower")}


def test_times_of_a_busy_machine_are_marked_and_not_judged(copies, tmp_path, capsys):
    measured_alone(copies[1], 1.0, switches=3000)
    assert command.main([*map(str, copies), "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "*) |" in text and "the machine was busy in" in text and "not trusted (the machine was busy)" in text


@pytest.mark.parametrize(("told", "words"), [
    ({"type": "Debug"}, "times of a build of type Debug say nothing"), ({"cpu": "Another"}, "different hardware"),
    ({"schema": 1}, "results of schema"),
])
def test_what_can_not_be_compared_is_refused(told, words, tmp_path, capsys):
    assert run(tmp_path, program(tmp_path, "a"), program(tmp_path, "b", **told), "--repetitions", "1", "--backend", "grid") == 2
    assert words in capsys.readouterr().err


def test_other_hardware_is_compared_where_forced_and_debug_without_times(tmp_path):
    once = ("--repetitions", "1", "--backend", "grid")
    assert run(tmp_path / "1", program(tmp_path, "a"), program(tmp_path, "b", cpu="Another"), "--force", *once) == 0
    assert run(tmp_path / "2", program(tmp_path, "c"), program(tmp_path, "d", type="Debug"), "--accuracy-only", *once) == 0


def test_a_truncated_table_is_left_out_with_its_line(copies):
    victim = copies[1] / "raw" / "resting_contact-grid-r3"
    (victim / "measured.json").unlink()
    rows = (victim / "frames.csv").read_text()
    (victim / "frames.csv").write_text(rows[:len(rows) // 2])
    found = read_set(copies[1])
    (fault,) = found.faults
    assert f"{victim / 'frames.csv'}:" in fault and "truncated" in fault
    assert len(found.cases["resting_contact-grid"]) == 8  # seven of eight, and the judged one


def test_a_file_that_is_not_the_noted_one_is_left_out(copies):
    victim = copies[0] / "raw" / "resting_contact-tree-r0"
    (victim / "frames.csv").write_text((victim / "frames.csv").read_text().replace("frame", "fr4me", 1))
    (fault,) = read_set(copies[0]).faults
    assert "measured.json:" in fault and "frames.csv has the SHA-256" in fault


def test_results_of_another_schema_are_left_out(copies):
    victim = copies[0] / "raw" / "resting_contact-tree-r0"
    (victim / "measured.json").unlink()
    record = victim / "run.json"
    record.write_text(record.read_text().replace('"schema_version": 2', '"schema_version": 9'))
    (fault,) = read_set(copies[0]).faults
    assert f"{record}:2: schema_version 9" in fault


@pytest.mark.parametrize("names", [("nothing", "HEAD"), ("HEAD", "nothing")])
def test_what_is_neither_folder_nor_revision_is_told(names, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(command, "program_of", lambda *_: Path(program(tmp_path, "a")))
    assert run(tmp_path, *names) == 2
    assert "nothing: neither a folder of results nor a revision" in capsys.readouterr().err


def test_revisions_are_built_each_once(tmp_path):
    repository, scratch = tmp_path / "repository", tmp_path / "builds"
    (repository / "tools").mkdir(parents=True)
    build = repository / "tools" / "build"
    build.write_text('#!/bin/sh\nmkdir -p "$(dirname "$0")/../build/release/bench"\n'
                     'cp "$0" "$(dirname "$0")/../build/release/bench/musclebench"\necho built >>"$(dirname "$0")/../../log"\n')
    build.chmod(0o755)
    git = ["git", "-C", str(repository), "-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "first"]):
        subprocess.run([*git, *words], check=True)
    commit = revisions.commit_of("HEAD", repository)
    for _ in range(2):
        assert revisions.program_of(commit, repository, scratch).is_file()
    assert (scratch / "log").read_text() == "built\n"
    build.write_text("#!/bin/sh\necho 'x.cpp:1: error' >&2; exit 2\n")
    subprocess.run([*git, "commit", "-qam", "second"], check=True)
    assert revisions.commits_between(commit, "HEAD", repository)[0].endswith("second")
    with pytest.raises(command.Problem, match="does not build .x.cpp:1: error"):
        revisions.program_of(revisions.commit_of("HEAD", repository), repository, scratch)
    assert revisions.commit_of("nonsense", repository) is None


def test_children_are_counted_and_this_process_is_not():
    try:
        counter = instructions.ChildCounter(instructions.SOFTWARE, instructions.TASK_CLOCK)
    except instructions.NotCounted as problem:
        pytest.skip(str(problem))
    sum(range(3_000_000))
    none = counter.read()
    counter = instructions.ChildCounter(instructions.SOFTWARE, instructions.TASK_CLOCK)
    subprocess.run(["/usr/bin/python3", "-c", "sum(range(3000000))"], check=True)
    assert none == 0 and counter.read() > 1e6


@needs_program
@pytest.mark.skipif(bool(instructions.why_not_by_callgrind()), reason=instructions.why_not_by_callgrind())
def test_counted_instructions_are_those_of_the_loop_and_repeat(tmp_path):
    counts = []
    for frames in (1, 1, 3):
        prefix = instructions.callgrind_prefix(tmp_path)
        subprocess.run([*prefix, PROGRAM, "run", "hard/resting_contact", "--backend", "null", "--frames", str(frames),
                        "--no-referee", "--force", "--out", str(tmp_path / "run")], check=True, capture_output=True)
        counts.append(instructions.read_callgrind(tmp_path))
    assert math.isclose(counts[0], counts[1], rel_tol=1e-3) and math.isclose(counts[2], 3 * counts[0], rel_tol=0.2)


def test_a_run_that_counting_slowed_tells_no_times(sets):
    sample = read_set(sets / "before").cases["resting_contact-tree"][-1]
    told = values_of(sample.run, {"is_slowed": True, "counters": {"instructions": 7}})
    assert told == {"status": "ok", "instructions": 7} and "frame_ns" in values_of(sample.run)


def test_nothing_counted_is_unknown(tmp_path):
    assert instructions.read_callgrind(tmp_path) is None
    (tmp_path / instructions.CALLGRIND_FILE).write_text("totals: 0\n")
    assert instructions.read_callgrind(tmp_path) is None
