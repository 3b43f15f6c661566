"""tools/compare: what it finds, what it does not take for a change, what it refuses."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import compare as command
import fake_runs
from musclebench.comparison import instructions, interleaved, revisions
from musclebench.comparison.frame_times import frame_times
from musclebench.comparison.metrics import WAITED, values_of
from musclebench.comparison.result_set import read_set
from musclebench.comparison.verdicts import compare
from musclebench.results.run_folder import Run, read_run
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
    say(0, "timeout")  # then that side was not judged
    assert changes() == set()


def end(folder: Path, status: str) -> Path:
    """As if the run had ended so."""
    record = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(record | {"status": status}))
    (folder / "measured.json").unlink(missing_ok=True)
    return folder


def test_time_that_was_up_once_is_no_answer_and_always_is_one(copies):
    end(copies[1] / "raw" / "resting_contact-grid-r2", "timeout")
    found = compare(*map(read_set, copies))
    assert {row.case for row in found.changes} == {"resting_contact-tree"}
    assert any("resting_contact-grid-r2: ended as timeout; others of its case ended" in fault for fault in found.after.faults)
    for run in (copies[1] / "raw").glob("resting_contact-grid-*"):
        end(run, "timeout")
    assert ("status", "ok", "timeout") in {(row.metric.name, row.before, row.after)
                                           for row in compare(*map(read_set, copies)).changes if row.case == "resting_contact-grid"}


def test_a_counted_run_whose_time_was_up_is_no_answer(copies):
    for side in copies:
        counted = shutil.copytree(side / "raw" / "resting_contact-grid-r0", side / "raw" / "resting_contact-grid-counted")
        noted = json.loads((counted / "measured.json").read_text())
        noted |= {"is_slowed": True, "counters": {"instructions": 1000, "collision_instructions": 100}}
        (counted / "measured.json").write_text(json.dumps(noted))
    before = read_set(copies[0])
    counted = before.cases["resting_contact-grid"][0]
    assert counted.values == {"instructions": 1000, "collision_instructions": 100}
    assert any("its constraint_instructions are not known" in fault for fault in before.faults)
    assert {row.case for row in compare(before, read_set(copies[1])).changes} == {"resting_contact-tree"}
    end(copies[1] / "raw" / "resting_contact-grid-counted", "timeout")
    after = read_set(copies[1])
    assert {row.case for row in compare(before, after).changes} == {"resting_contact-tree"}
    assert any("ended as timeout; its instructions are not counted" in fault for fault in after.faults)


def test_frames_are_compared_with_the_same_frames_of_other_runs():
    """The motion's frames take longer and longer, and each run was interrupted in half of them. The third is 10 % slower."""
    frame, random = np.arange(1, 61), np.random.default_rng(1)
    times = 1e5 * 1.1 ** frame

    def run(factor: float, interrupted) -> Run:
        rows = {"frame": frame, "warm_up": 0, "frame_ns": factor * np.where(interrupted, 5, 1) * times, WAITED: interrupted.astype(int)}
        return Run(Path("run"), {}, pd.DataFrame(rows))

    runs = [run(factor, random.random(60) < 0.5) for factor in [1.0, 1.0, 1.1, *[1.0] * 7]]
    found = frame_times([*runs, run(1.0, frame > 4)], "frame_ns")
    assert found[10] is None  # too few quiet frames
    slower = found.pop(2)
    assert found[:9] == pytest.approx([found[0]] * 9) and slower == pytest.approx(1.1 * found[0])
    assert found[0] == pytest.approx(np.mean(times), rel=0.1)
    assert frame_times(runs, "collision_ns") == [None] * 10 and frame_times([], "frame_ns") == []


def test_both_sides_are_told_for_the_same_frames(copies):
    """One side was interrupted in all of its short frames, the other in all of its long ones."""
    for side, is_long in zip(copies, (True, False)):
        for path in (side / "raw").glob("resting_contact-grid-r*/frames.csv"):
            frames = pd.read_csv(path)
            long = frames["frame"] % 2 == 1
            for column in ("detect_ns", "frame_ns"):
                frames[column] *= np.where(long, 3, 1)
            quiet_too = frames["frame"] > 50
            frames["involuntary_switches"] = np.where((long == is_long) | quiet_too, 0, 1)
            frames.to_csv(path, index=False)
            (path.parent / "measured.json").write_text(json.dumps(json.loads((path.parent / "measured.json").read_text()) | {"sha256": {}}))
    found = compare(*map(read_set, copies))
    assert {row.case for row in found.changes} == {"resting_contact-tree"}
    row = next(row for row in found.rows if (row.case, row.metric.name) == ("resting_contact-grid", "frame_ns"))
    assert row.ratio.value == pytest.approx(1, abs=0.02)


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
@pytest.mark.skipif(not (command.PROJECT / ".git").exists(), reason="the sources are no git repository")
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


@pytest.mark.long
@needs_program
@pytest.mark.skipif(bool(instructions.why_not_by_callgrind()), reason=instructions.why_not_by_callgrind())
def test_counted_instructions_are_those_of_the_loop_and_repeat(tmp_path):
    counts = []
    for frames in (1, 1, 3):
        prefix = instructions.callgrind_prefix(tmp_path)
        subprocess.run([*prefix, PROGRAM, "run", "hard/resting_contact", "--backend", "null", "--frames", str(frames),
                        "--no-referee", "--force", "--out", str(tmp_path / "run")], check=True, capture_output=True)
        counts.append(instructions.read_callgrind(tmp_path))
    once, again, three_times = (count["instructions"] for count in counts)
    assert math.isclose(once, again, rel_tol=1e-3) and math.isclose(three_times, 3 * once, rel_tol=0.2)
    assert set(counts[0]) == {"instructions", *instructions.PARTS}
    assert counts[0]["constraint_instructions"] > 0.5 * once > counts[0]["collision_instructions"] > 0
    assert sum(counts[0][part] for part in instructions.PARTS) < once


def test_instructions_are_counted_by_part(tmp_path):
    """Those of all calls of a function, with what it calls; its name stands where its number is used first."""
    (tmp_path / instructions.CALLGRIND_FILE).write_text("""events: Ir
fn=(1) musclebench::Simulation::collide(bool, musclebench::CollisionObserver*)
10 5
cfn=(2) musclebench::Simulation::find_contacts()
calls=4 20
+1 700
cfn=(3) musclebench::Simulation::respond()
calls=4 30
* 50

fn=(2)
20 650
cfn=(4) musclebench::other()
calls=9 1
+2 50

fn=(5) musclebench::Simulation::step()
1 1
cfn=(6) musclebench::Simulation::project(musclebench::SubstepInput const&, musclebench::Team const&)
calls=1 1
1 200
cfn=(2)
calls=1 1
1 30

totals: 1000
""")
    assert instructions.read_callgrind(tmp_path) == {"instructions": 1000, "collision_instructions": 780, "constraint_instructions": 200}


def test_what_answers_are_worth_is_compared(tmp_path):
    rest, moved = (np.array([[0.0, 0, z], [1, 0, z], [0, 1, z]]) for z in (0.0, 0.002))
    shots = [fake_runs.Snapshot(frame, 0, shape, np.zeros(3), np.zeros(3, dtype="u1"), []) for frame, shape in ((0, rest), (20, moved))]
    folder = fake_runs.write_run(tmp_path / "run", "synthetic/iliacus", "bvh", loop={"rest_frames": 6}, snapshots=shots,
                                 triangles=np.array([[0, 1, 2]]))
    record = json.loads((folder / "run.json").read_text())
    record["outcome"] = {"p99_surface_depth_m": 0.001, "max_surface_depth_m": 0.003}
    (folder / "run.json").write_text(json.dumps(record))
    run = read_run(folder)
    run.fibres = pd.DataFrame({"mean_moment_arm_m": [np.nan, 0.01, 0.03, 0.05]})
    told = values_of(run)
    assert (told["p99_surface_depth_m"], told["max_surface_depth_m"], told["moment_arm_m"]) == (0.001, 0.003, 0.03)
    assert told["return_to_rest_m"] == pytest.approx(0.002)
    run.record["case"]["loop"]["rest_frames"] = 0
    assert "return_to_rest_m" not in values_of(run)


def test_a_run_that_counting_slowed_tells_no_times(sets):
    sample = read_set(sets / "before").cases["resting_contact-tree"][-1]
    told = values_of(sample.run, {"is_slowed": True, "counters": {"instructions": 7}})
    assert told == {"instructions": 7} and "cpu_ns" in values_of(sample.run)


def test_nothing_counted_is_unknown(tmp_path):
    assert instructions.read_callgrind(tmp_path) == {}
    (tmp_path / instructions.CALLGRIND_FILE).write_text("totals: 0\n")
    assert instructions.read_callgrind(tmp_path) == {}
