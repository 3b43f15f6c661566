"""Whatever ends an experiment, nothing complete is lost or half-written, and the rerun's results equal an undisturbed run's."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

import fake_registry
from fake_sweep import swept
from fake_trial import QUICK, ROLES, TRIAL, answers, call, command, wait_for
from musclebench.cases.case import Folders
from musclebench.cases.pool import Limits
from musclebench.cases.worker import Worker
from musclebench.experiments.case_tables import write_tables
from musclebench.experiments.experiment_file import read_experiment
from musclebench.experiments.running import Sweep
from musclebench.experiments.swept_experiment import SweptExperiment
from musclebench.results.damage import damage
from musclebench.results.status import MEASURED
from program import PROGRAM, needs_program

FEWEST_CASES = 24
KILLS = (12, pytest.param(50, marks=pytest.mark.weekly))
WITHOUT_LOOKING_AHEAD = """import runpy, sys
from pathlib import Path
sys.path.insert(0, str(Path(sys.argv[1]).parent))
from musclebench.experiments import running
running.SPARE_BYTES = -1e12
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
HAS_NAMESPACES = subprocess.run(["unshare", "-m", "true"], capture_output=True, check=False).returncode == 0


@pytest.fixture
def trial(tmp_path):
    path = tmp_path / "trial.toml"
    path.write_text(TRIAL)
    return path


def run_here(trial: Path, out: Path) -> list[str]:
    """In this process; the survey is left out."""
    cases = swept(trial, *(fake_registry.scene(f"synthetic/{name}") for name in ("iliacus", "gluteus_medius")))
    assert len(cases) >= FEWEST_CASES
    sweep = Sweep(read_experiment(trial), cases, {}, SweptExperiment(QUICK, Folders(out)), fake_registry.registry())
    return sweep.run(cases, Limits(sorted(os.sched_getaffinity(0))[:2], 60.0))


def fork_and_kill(trial: Path, out: Path, after_seconds: float) -> str:
    """"killed"; "ended" before; "refused" where a case of a runner that was killed before still holds the folder."""
    child = os.fork()
    if child == 0:
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        code = 1
        try:
            run_here(trial, out)
            code = 0
        finally:
            os._exit(code)
    time.sleep(after_seconds)
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    return "killed" if os.WIFSIGNALED(status) else "refused" if os.waitstatus_to_exitcode(status) else "ended"


def complete(out: Path) -> dict[str, str]:
    """{name: run.json} of what is sealed."""
    return {path.parent.name: (path.parent / "run.json").read_text() for name in ("raw", "recordings")
            for path in out.glob(f"{name}/[!.]*/case.json")}


def hidden(out: Path) -> list[Path]:
    return [path for path in (*out.glob("raw/.*"), *out.glob("recordings/.*"))]


def cleared(trial: Path, out: Path) -> bool:
    """What a case of a runner that was killed left behind after the next one had cleaned up goes with the one after that."""
    if hidden(out):
        run_here(trial, out)
    return not hidden(out)


@pytest.fixture
def undisturbed(trial, tmp_path):
    assert run_here(trial, tmp_path / "undisturbed") == []
    return answers(tmp_path / "undisturbed")


@pytest.mark.long
@pytest.mark.parametrize("wanted", KILLS)
def test_kill_9_at_random_moments_loses_nothing_complete(wanted, trial, tmp_path, undisturbed, capfd):
    moments, kills, ended, refusals = random.Random(3), 0, 0, 0
    out, before = tmp_path / "out-0", {}
    while kills < wanted:
        outcome = fork_and_kill(trial, out, moments.uniform(0.0, 0.2))
        kills, refusals = kills + (outcome == "killed"), refusals + (outcome == "refused")
        assert refusals < wanted
        now = complete(out)
        assert before.items() <= now.items()
        for name in ("raw", "recordings"):
            folders = [path for path in out.glob(f"{name}/[!.]*")]
            assert all((path / "case.json").is_file() and not damage(path) for path in folders)
        before = now
        if outcome == "ended":
            assert answers(out) == undisturbed
            ended += 1
            out, before = tmp_path / f"out-{ended}", {}
    time.sleep(1)  # the longest case
    run_here(trial, out)
    assert answers(out) == undisturbed and (out / "cases.log").read_text().endswith("\n")


def test_what_a_killed_case_left_late_goes_with_the_next_run(trial, tmp_path, undisturbed):
    out = tmp_path / "undisturbed"
    (out / "raw" / ".iliacus-run-voxel-r1.999999").mkdir()
    assert cleared(trial, out) and answers(out) == undisturbed


def test_tables_say_what_was_not_run(trial, tmp_path, undisturbed):
    out = tmp_path / "undisturbed"
    shutil.rmtree(next(out.glob("raw/iliacus-run-*-r1")))
    (next(out.glob("raw/iliacus-run-*-r2")) / "frames.csv").write_text("frame\n")
    counts = write_tables(out)[0]["status"].value_counts()
    assert counts.to_dict() == {"ok": 22, "missing": 1, "damaged": 1}


def test_the_table_of_frames_says_that_the_motion_was_squeezed(trial, tmp_path):
    done = call(trial, tmp_path / "out", "--frames-limit", "12", "--filter", "iliacus-run")
    assert done.returncode == 0 and "squeezed into 12 frames, so that bones move faster." in done.stdout, done.stderr
    assert all("squeezed into 12 frames" in path.read_text() for path in (tmp_path / "out").glob("frame_spread.[mt]*"))


@pytest.mark.long
@pytest.mark.skipif(not HAS_NAMESPACES, reason="no mount namespaces here (unshare -m)")
def test_a_full_disk_keeps_what_is_complete(trial, tmp_path, undisturbed):
    (tmp_path / "disk").mkdir()
    (tmp_path / "driver.py").write_text(WITHOUT_LOOKING_AHEAD)
    run = " ".join([sys.executable, "driver.py", *command(trial, tmp_path / "disk" / "out")[1:]])
    script = f"""cd {tmp_path}
        mount -t tmpfs -o size=140k small disk && {run} 2>errors; echo $? >code
        ls disk/out/raw >kept; ls -A disk/out/raw | grep -c '^[.]' >hidden
        mount -o remount,size=9m disk && {run} 2>again; echo $? >>code; cp disk/out/answers.csv answers.csv"""
    subprocess.run(["unshare", "-m", "sh", "-c", script], check=False, timeout=120, stdout=subprocess.DEVNULL)
    assert (tmp_path / "code").read_text().split() == ["2", "0"], (tmp_path / "errors").read_text()
    told = [line for line in (tmp_path / "errors").read_text().splitlines() if not line.startswith("[")]
    assert len(told) == 1 and "the disk is full; complete cases are kept" in told[0]
    assert len((tmp_path / "kept").read_text().split()) > 2 and (tmp_path / "hidden").read_text().strip() == "0"
    assert (tmp_path / "answers.csv").read_bytes() == undisturbed


@pytest.mark.long
@pytest.mark.skipif(not HAS_NAMESPACES, reason="no mount namespaces here (unshare -m)")
def test_a_read_only_folder_is_one_line(trial, tmp_path):
    (tmp_path / "disk").mkdir()
    script = f"mount -t tmpfs -o ro small {tmp_path}/disk && exec {' '.join(command(trial, tmp_path / 'disk' / 'out'))}"
    done = subprocess.run(["unshare", "-m", "sh", "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "Read-only file system" in done.stderr


@pytest.mark.long
def test_two_runners_do_not_share_a_folder_and_ctrl_c_says_what_is_kept(trial, tmp_path, undisturbed):
    out = tmp_path / "out"
    first = subprocess.Popen(command(trial, out), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                             env={**os.environ, "FAKE_HANGS": "2"})
    wait_for(lambda: len(list(out.glob("raw/.*/run/frames.csv"))) == 2 and len(list(out.glob("raw/*/case.json"))) == 16)
    second = call(trial, out)
    assert second.returncode == 2 and "another run writes there" in second.stderr
    first.send_signal(signal.SIGINT)
    errors = first.communicate(timeout=60)[1]
    assert first.returncode == 130
    assert errors.splitlines()[-1] == (f"experiment: interrupted; 18 of the 26 cases of this run have ended and are kept in {out}, "
                                       "2 unfinished ones are removed; the same command goes on")
    assert not hidden(out)
    assert run_here(trial, out) == [] and answers(out) == undisturbed


def test_what_fails_is_a_row_with_its_reason_and_its_last_words(trial, tmp_path):
    """Each of another muscle or repetition."""
    ends = {("iliacus", 0): ("echo first >&2; echo 'key x: no such thing' >&2; exit 2", "failed", "exit code 2: key x: no such thing"),
            ("iliacus", 1): ("echo in flight >&2; kill -SEGV $$", "failed", "signal SIGSEGV: in flight"),
            ("gluteus_medius", 0): ("echo std::bad_alloc >&2; kill -ABRT $$", "out_of_memory", "signal SIGABRT: std::bad_alloc"),
            ("gluteus_medius", 1): ("echo slow >&2; sleep 60", "timeout", "stopped after 1 s"),
            ("iliacus", 2): ("echo 'takes closed surfaces only' >&2; exit 6", "unsupported", "takes closed surfaces only")}
    program, out = tmp_path / "program.sh", tmp_path / "out"
    lines = [f'*"run synthetic/{muscle} "*"--backend {ROLES.field} "*"--repetition {repetition}"*) {words} ;;'
             for (muscle, repetition), (words, _, _) in ends.items()]
    program.write_text("\n".join(["#!/bin/sh", 'case "$*" in', *lines, "esac", f'exec {QUICK} "$@"\n']))
    program.chmod(0o755)
    done = call(trial, out, "--repetitions", "3", "--timeout", "1", program=program)
    rows = pd.read_csv(out / "times.csv").set_index("name")
    assert done.returncode == 1 and (rows["status"] == "ok").sum() == len(rows) - len(ends)
    for (muscle, repetition), (words, status, detail) in ends.items():
        name = f"{muscle}-run-{ROLES.field}-r{repetition}"
        assert rows.loc[name, "status"] == status and rows.loc[name, "status_detail"] == detail
        assert json.loads((out / "raw" / name / "run.json").read_text())["last_lines"][-1] in words
        assert f"{status:<14}" in next(line for line in (out / "cases.log").read_text().splitlines() if name in line)


def test_what_the_system_killed_for_want_of_memory_is_told_apart(trial, tmp_path, monkeypatch):
    case = next(case for case in swept(trial, fake_registry.scene("synthetic/iliacus")) if "-run-" in case.name)
    for kills, status in (([3, 3], "failed"), ([3, 4], "out_of_memory")):
        monkeypatch.setattr("musclebench.cases.worker.oom_kills", lambda told=iter(kills): next(told))
        monkeypatch.setenv("FAKE_HANGS", "0")
        worker = Worker(case, SweptExperiment(QUICK, Folders(tmp_path)), [0])
        worker.kill_for_timeout()
        assert worker.finish() == status


@pytest.mark.long
@needs_program
def test_a_kill_of_the_real_program_changes_no_answer(trial, tmp_path):
    trial.write_text(TRIAL.replace('"synthetic/iliacus", "synthetic/gluteus_medius"', '"hard/resting_contact"'))
    more = ("--frames-limit", "200", "--repetitions", "1", "--filter", ROLES.unit)
    assert call(trial, tmp_path / "undisturbed", *more, program=PROGRAM).returncode == 0
    process = subprocess.Popen(command(trial, tmp_path / "out", *more, program=PROGRAM), stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    wait_for(lambda: complete(tmp_path / "out") or process.poll() is not None)
    process.kill()
    process.wait(60)
    assert call(trial, tmp_path / "out", *more, program=PROGRAM).returncode == 0
    rows = pd.read_csv(tmp_path / "out" / "answers.csv")
    assert rows["status"].isin(MEASURED).sum() == 2
    assert (tmp_path / "out" / "answers.csv").read_bytes() == (tmp_path / "undisturbed" / "answers.csv").read_bytes()
