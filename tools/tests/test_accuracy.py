"""The sweep of the accuracy study from end to end, with a stand-in for the program."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import accuracy
import fake_registry
from musclebench.cases.worker import Worker
from musclebench.experiments import running
from musclebench.program import fingerprint

PROGRAM = Path(__file__).resolve().parent / "fake_musclebench.py"
FEW = {
    "null": {"control": True, "series": [{"replays": False, "step_ms": 0.0}]},
    "voxel": {"series": [{"name": "cells", "sweep": {"cells": [16]}, "step_ms": 0.05, "probed": True}]},
    "sdf": {"series": [{"name": "cells", "sweep": {"cells": [8]}, "step_ms": 0.1,
                        "stores": True, "stored_bytes": 1e3, "probed": True}]},
    "bvh": {"series": [{"step_ms": 1.0}]},
    "brute_force": {"longest_stride": 128, "series": [{"step_ms": 1.2e4}]},
}
PROBES = ["adductor_brevis-probe-sdf-cells=8-r0", "adductor_brevis-probe-voxel-cells=16-r0"]
ONCE = ["iliacus-coupled-null", "iliacus-replay-voxel-cells=16", "iliacus-coupled-voxel-cells=16",
        "iliacus-replay-sdf-cells=8", "iliacus-coupled-sdf-cells=8",
        "iliacus-replay-bvh", "iliacus-coupled-bvh"]
ARMS = [f"iliacus-arms-{name}-r0" for name in ("null", "voxel-cells=16", "sdf-cells=8", "bvh")]
FORCES = [name.replace("-arms-", "-forces-") for name in ARMS]
TOO_LONG = ["iliacus-coupled-brute_force-r0", "iliacus-arms-brute_force-r0", "iliacus-forces-brute_force-r0"]
RUN_CASES = sorted(["iliacus", *PROBES, "iliacus-replay-brute_force-r0", "iliacus-floor-bvh-r0",
                    "iliacus-arms_floor-bvh-r0", *ARMS, "iliacus-forces_floor-bvh-r0", *FORCES,
                    *[f"{name}-r{r}" for name in ONCE for r in (0, 1)]])
# A program of its own, since the report can't be left out in another process from here.
DRIVER = """
import sys
sys.path[:0] = [{tools!r}, {tests!r}]
import accuracy
accuracy.report.write_report = lambda out_dir: []
sys.exit(accuracy.main(sys.argv[1:]))
"""


class Sweep:
    """Runs tools/accuracy.py on few configurations of one muscle."""

    def __init__(self, folder: Path, monkeypatch, capfd):
        self.out, self._log, self._monkeypatch, self._capfd = folder / "out", folder / "log", monkeypatch, capfd

    @property
    def arguments(self) -> list[str]:
        return ["--musclebench", str(PROGRAM), "--out", str(self.out), "--muscle", "iliacus", "--repetitions", "2"]

    def __call__(self, *more, behaviour=""):
        """(exit code, standard output, standard error, names of the cases that the program was started for)"""
        self._monkeypatch.setenv("FAKE_BEHAVIOUR", behaviour)
        self._monkeypatch.setenv("FAKE_LOG", str(self._log))
        self._monkeypatch.setenv("FAKE_LIGHT", "1")
        self._log.write_text("")
        code = accuracy.main([*self.arguments, *more])
        text, errors = self._capfd.readouterr()
        return code, text, errors, sorted(self.calls())

    def start(self, behaviour: str) -> subprocess.Popen:
        """In a process of its own."""
        tools = Path(accuracy.__file__).resolve().parent
        driver = DRIVER.format(tools=str(tools), tests=str(tools / "tests"))
        environment = {**os.environ, "FAKE_BEHAVIOUR": behaviour, "FAKE_LOG": f"{self._log}-of-another", "FAKE_LIGHT": "1"}
        return subprocess.Popen([sys.executable, "-c", driver, *self.arguments], env=environment,
                                stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)

    def calls(self) -> dict[str, list[int]]:
        """{name of a case: cores it had}"""
        lines = [line.split() for line in self._log.read_text().splitlines()] if self._log.exists() else []
        return {words[0]: [int(word) for word in words[1:]] for words in lines}

    def record(self, name: str) -> dict:
        return json.loads((self.out / "raw" / name / "run.json").read_text())

    def hidden(self) -> list[Path]:
        return [*self.out.glob("raw/.*"), *self.out.glob("recordings/.*")]


@pytest.fixture
def sweep(tmp_path, monkeypatch, capfd):
    (tmp_path / "registry.json").write_text(fake_registry.with_studies(FEW))
    monkeypatch.setenv("FAKE_REGISTRY", str(tmp_path / "registry.json"))
    monkeypatch.setattr(accuracy.report, "write_report", lambda out_dir: [], raising=False)
    return Sweep(tmp_path, monkeypatch, capfd)


@pytest.fixture(scope="module")
def finished_once(tmp_path_factory):
    return tmp_path_factory.mktemp("finished") / "out"


@pytest.fixture
def finished(sweep, finished_once):
    """After `sweep()`, which runs for the first of these tests; the others get what it left."""
    if finished_once.exists():
        shutil.copytree(finished_once, sweep.out)
    else:
        code, _, errors, _ = sweep()
        assert code == 0, errors
        shutil.copytree(sweep.out, finished_once)
    return sweep


def wait_for(condition, seconds=120.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)


def test_every_case_runs_once_on_one_core_and_leaves_a_sealed_folder(sweep):
    code, _, errors, called = sweep()
    assert code == 0, errors
    assert called == RUN_CASES
    assert all(len(cores) == 1 for cores in sweep.calls().values())
    rows = {folder.name for folder in (sweep.out / "raw").iterdir()}
    assert rows == {*RUN_CASES, *TOO_LONG} - {"iliacus"}
    assert (sweep.out / "recordings" / "iliacus" / "iliacus.recording").is_file()
    planned = json.loads((sweep.out / "experiment.json").read_text())["cases"]
    assert {case["name"] for case in planned} == rows
    assert sweep()[3] == []  # complete


def test_what_is_too_long_is_a_row_with_its_estimate(finished):
    row = finished.record(TOO_LONG[0])
    assert row["status"] == "timeout" and row["status_detail"].startswith("not run: 942 steps of about 12 s")
    assert row["case"] == {"mode": "coupled", "scene": "synthetic/iliacus", "preset": "paper", "backend": "brute_force",
                           "parameters": {}, "threads": 1, "repetition": 0}


def test_a_probe_builds_what_the_others_load(sweep):
    sweep("--keep-structures")
    assert sweep.record(PROBES[0])["structures"] == "built"
    for name in ("iliacus-replay-sdf-cells=8-r0", "iliacus-coupled-sdf-cells=8-r1"):
        assert sweep.record(name)["structures"] == "loaded"
    # What a killed build has left must not make the next one look fast.
    shutil.rmtree(sweep.out / "raw" / PROBES[0])
    assert sweep("--keep-structures")[3] == [PROBES[0]]
    assert sweep.record(PROBES[0])["structures"] == "built"
    assert (sweep.out / "structures").exists()
    sweep()
    assert not (sweep.out / "structures").exists()


@pytest.mark.long
def test_experiments_share_structures_that_one_has_built(sweep, tmp_path):
    shared = tmp_path / "shared"
    sweep("--structures", str(shared))
    assert sweep.record(PROBES[0])["structures"] == "built" and any(shared.iterdir())
    assert not (sweep.out / "structures").exists()
    assert sweep()[3] == []  # where structures are kept makes no case another one
    shutil.rmtree(sweep.out / "raw")
    sweep("--structures", str(shared))
    assert sweep.record(PROBES[0])["structures"] == "loaded"


def test_a_changed_program_or_recording_is_measured_again(finished):
    sealed = finished.out / "raw" / "iliacus-coupled-null-r1" / "case.json"
    sealed.write_text(json.dumps({**json.loads(sealed.read_text()), "binary_sha256": "of another build"}))
    assert finished()[3] == ["iliacus-coupled-null-r1"]
    recording = finished.out / "recordings" / "iliacus" / "iliacus.recording"
    recording.write_text("other positions")
    assert finished()[3] == [name for name in RUN_CASES if "-replay-" in name]
    recording.unlink()
    # The new recording is as the first one was, which the replays are not of any more.
    assert finished()[3] == ["iliacus", *[name for name in RUN_CASES if "-replay-" in name]]
    recording.unlink()
    assert finished()[3] == ["iliacus"]  # the same positions again
    assert finished("--force")[3] == RUN_CASES


def test_a_folder_may_be_moved(finished, tmp_path):
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    finished.out = tmp_path / "elsewhere"
    assert finished()[3] == []


@pytest.mark.long
def test_failures_are_rows_and_the_others_go_on(sweep):
    behaviour = f"{ONCE[1]}-r0=crash {ONCE[3]}-r0=greedy {ONCE[4]}-r0=diverge {ONCE[6]}-r1=hang"
    code, _, errors, called = sweep("--timeout", "1.5", "--no-page", behaviour=behaviour)
    assert code == 1 and called == RUN_CASES
    assert sweep.record(f"{ONCE[1]}-r0")["status"] == "failed"
    assert "key 'x': no such thing" in sweep.record(f"{ONCE[1]}-r0")["status_detail"]
    assert sweep.record(f"{ONCE[1]}-r0")["case"]["parameters"] == {"cells": 16}
    assert sweep.record(f"{ONCE[3]}-r0")["status"] == "out_of_memory"
    assert sweep.record(f"{ONCE[4]}-r0")["status"] == "diverged"
    assert sweep.record(f"{ONCE[6]}-r1")["status_detail"].startswith("stopped after")
    without_result = sorted([f"{ONCE[1]}-r0", f"{ONCE[3]}-r0", f"{ONCE[6]}-r1"])  # diverging is an answer
    assert sorted(line.split(": ")[1] for line in errors.splitlines() if line.startswith("accuracy")) == without_result
    assert sweep()[3] == without_result


def test_without_a_recording_replays_are_rows_that_say_so(sweep):
    code, _, _, called = sweep(behaviour="iliacus=crash")
    assert code == 1 and not [name for name in called if "-replay-" in name]
    row = sweep.record("iliacus-replay-bvh-r0")
    assert row["status"] == "failed" and "no such thing" in row["status_detail"]
    assert sweep()[0] == 0


def test_answers_that_differ_between_repetitions_are_marked(sweep):
    code, _, errors, _ = sweep(behaviour=f"{ONCE[5]}-r1=differ {ONCE[6]}-r1=differ")
    assert code == 1 and errors.count("nondeterministic") == 2
    for name, words in ((ONCE[5], "contact hash"), (ONCE[6], "state hash")):
        row = sweep.record(f"{name}-r1")
        assert row["status"] == "nondeterministic"
        assert row["status_detail"] == f"{words} another answer, but the answer in repetition 0"
        assert sweep.record(f"{name}-r0")["status"] == "ok"


@pytest.mark.long
def test_kill_9_loses_only_the_case_in_flight(sweep, tmp_path):
    victim = f"{ONCE[5]}-r1"
    process = sweep.start(f"{victim}=hang")
    # Everything else is done and the one that hangs has begun to write when the whole is killed.
    others = {*RUN_CASES, *TOO_LONG} - {victim, "iliacus"}
    wait_for(lambda: others <= {file.parent.name for file in sweep.out.glob("raw/*/case.json")})
    wait_for(lambda: list(sweep.out.glob(f"raw/.{victim}.*/run")))
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=120)
    wait_for(lambda: str(tmp_path) not in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout)
    assert sweep.hidden()
    code, _, _, called = sweep()
    assert code == 0 and called == [victim] and not sweep.hidden()


def test_an_interrupt_removes_what_is_unfinished(sweep):
    process = sweep.start(f"{ONCE[5]}-r0=hang {ONCE[6]}-r0=hang")
    wait_for(lambda: len(list(sweep.out.glob("raw/.*/run"))) == 2)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130 and errors.splitlines()[-1].startswith("accuracy: interrupted")
    assert not sweep.hidden()


@pytest.mark.parametrize("moment", ["_start", "finish"])
def test_an_interrupt_while_a_case_starts_or_ends_leaves_nothing(sweep, monkeypatch, moment):
    usual, interrupted = getattr(Worker, moment), []

    def interrupting(worker, *arguments):
        done = usual(worker, *arguments) if moment == "_start" else None
        if not interrupted:
            interrupted.append(done)
            signal.raise_signal(signal.SIGINT)
        return done if moment == "_start" else usual(worker, *arguments)

    monkeypatch.setattr(Worker, moment, interrupting)
    code, _, errors, _ = sweep()
    assert code == 130 and errors.splitlines()[-1].startswith("accuracy: interrupted")
    assert not sweep.hidden() and (moment == "finish" or interrupted[0].poll() is not None)


@pytest.mark.long
def test_two_sweeps_do_not_share_a_folder(sweep):
    process = sweep.start(f"{ONCE[5]}-r0=hang")
    wait_for(lambda: list(sweep.out.glob("raw/.*/run")))
    code, _, errors, called = sweep()
    process.kill()
    process.communicate(timeout=120)
    assert code == 2 and errors.count("\n") == 1 and "another run writes there" in errors and called == []


def test_a_full_disk_that_the_program_meets_ends_the_sweep_with_one_line(sweep):
    code, _, errors, called = sweep("--jobs", "1", behaviour=f"{ONCE[6]}-r1=full_disk")
    assert code == 2
    assert [line for line in errors.splitlines() if not line.startswith("[")] == [
        f"accuracy: {sweep.out}: the disk is full; complete cases are kept, make room and start again"]
    complete = [path.parent.name for path in sweep.out.glob("raw/*/case.json")]
    assert 0 < len(complete) < len(RUN_CASES) and f"{ONCE[6]}-r1" not in complete and not sweep.hidden()
    again = sweep()
    assert again[0] == 0 and not set(again[3]) & (set(complete) - set(TOO_LONG))


def test_a_full_disk_that_the_sweep_meets_leaves_nothing_half_written(sweep, monkeypatch):
    write = fingerprint.seal

    def seal(folder, print_of_case):
        if f"{ONCE[6]}-r0" in str(folder):
            raise OSError(errno.ENOSPC, "No space left on device")
        write(folder, print_of_case)

    monkeypatch.setattr(fingerprint, "seal", seal)
    code, _, errors, _ = sweep()
    assert code == 2 and "the disk is full" in errors.splitlines()[-1]
    assert not sweep.hidden() and not (sweep.out / "raw" / f"{ONCE[6]}-r0").exists()


def test_space_is_checked_before_anything_runs(sweep, monkeypatch):
    monkeypatch.setattr(running, "free_bytes", lambda folder: 1e6)
    code, _, errors, called = sweep()
    assert code == 2 and called == [] and "GB are needed and 0.0 GB are free" in errors and not sweep.out.exists()


def test_parts_of_two_machines_make_the_whole(sweep, tmp_path):
    whole, called = sweep.out, []
    for part in ("1/2", "2/2"):
        sweep.out = tmp_path / f"part-{part[0]}"
        called.append(set(sweep("--shard", part)[3]))
    assert called[0] & called[1] <= {"iliacus"} and sorted(called[0] | called[1]) == RUN_CASES
    for part in ("part-1", "part-2"):
        shutil.copytree(tmp_path / part, whole, dirs_exist_ok=True)
    sweep.out = whole
    assert sweep()[3] == [] and len(list(whole.glob("raw/*/run.json"))) == len({*RUN_CASES, *TOO_LONG} - {"iliacus"})


def test_a_dry_run_prints_the_cases_and_writes_nothing(sweep):
    code, text, _, called = sweep("--dry-run")
    assert code == 0 and called == [] and not sweep.out.exists()
    assert all(name in text for name in RUN_CASES) and all(f"{name}  (not run, too long)" in text for name in TOO_LONG)


def test_one_backend_is_measured_beside_those_that_tables_compare_with(sweep):
    _, text, _, _ = sweep("--dry-run", "--backend", "sdf")
    names = {line.split()[-1] for line in text.splitlines() if "-replay-" in line or "-coupled-" in line}
    assert {name.split("-")[2] for name in names} == {"null", "sdf", "bvh"}  # the stand-in has no unit of price
    _, text, _, _ = sweep("--dry-run", "--backend", "brute_force")
    assert "iliacus-replay-brute_force-r0" in text and "sdf" not in text
    assert "iliacus-floor-bvh-r0" in text


def test_a_dry_run_of_what_is_complete_leaves_no_work(finished):
    assert "0 s of work left" in finished("--dry-run")[1]


def test_the_report_alone_runs_nothing(finished):
    assert finished("--report-only", behaviour="iliacus=crash")[::3] == (0, [])
    shutil.rmtree(finished.out)
    assert finished("--report-only")[0] == 2


@pytest.mark.parametrize("arguments, words", [
    (["--musclebench", "/no/such/program"], "no such program"),
    (["--muscle", "biceps"], "'biceps'"),
    (["--backend", "sfd"], "--backend sfd: not built; there are: null,"),
    (["--data", "/no/such/data"], "lhdl.json"),
    (["--repetitions", "-2"], "--repetitions -2"),
    (["--jobs", "0"], "--jobs 0"),
    (["--timeout", "-1"], "--timeout -1"),
    (["--timeout", "nan"], "--timeout nan"),
    (["--band-mm", "0"], "--band-mm 0"),
    (["--memory-gb", "-4"], "--memory-gb -4"),
    (["--shard", "3/2"], "'3/2'"),
    (["--shard", "-1/2"], "--shard"),
    (["--frames-limit", "many"], "--frames-limit"),
    (["--dry-run", "--report-only"], "not allowed with"),
    (["--report-only", "--out", "/no/such/study"], "/no/such/study: holds no study"),
])
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, capsys, tmp_path):
    assert accuracy.main(["--musclebench", str(PROGRAM), "--out", str(tmp_path / "out"), *arguments]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1 and words in errors and not (tmp_path / "out").exists()


@pytest.mark.parametrize("file, text, words", [
    ("frames.csv", "frame\n", "frames.csv has 0 of 1 rows"),
    ("frames.csv", "", "frames.csv has 0 of 1 rows"),
    ("frames.csv", "frame\n1", "frames.csv has 0 of 1 rows"),  # cut before the end of the line
    ("run.json", "[]", "run.json is no record of a run"),
    ("run.json", "{", "run.json is not JSON"),
])
def test_a_damaged_folder_is_kept_apart_and_run_again(finished, file, text, words):
    victim = f"{ONCE[6]}-r0"
    (finished.out / "raw" / victim / file).write_text(text)
    code, _, errors, called = finished()
    assert code == 0 and called == [victim] and words in errors and "Traceback" not in errors
    assert (finished.out / "damaged" / victim / file).read_text() == text
    assert finished()[3] == [] and finished.record(victim)["status"] == "ok"
