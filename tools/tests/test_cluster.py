"""The same cases on more than one machine: merged parts, Slurm and Snakemake give the bytes of one machine."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

import experiment
from fake_trial import QUICK, TRIAL, call
import cluster_campaign
from one_node_slurm import is_installed, one_node, wait_for_jobs
from program import PROGRAM, needs_program

PROJECT = Path(__file__).resolve().parents[2]
CLUSTER = PROJECT / "bench" / "experiments" / "cluster"
PARTS, JOBS = 3, 2  # of the command, of what runs it


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """trial.toml; local, all on one machine; part-1, ... of several."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "trial.toml").write_text(TRIAL)
    assert call(folder / "trial.toml", folder / "local").returncode == 0
    for number in range(1, PARTS + 1):
        assert call(folder / "trial.toml", folder / f"part-{number}", "--shard", f"{number}/{PARTS}").returncode == 0
    return folder


@pytest.fixture
def trial(made):
    return made / "trial.toml"


@pytest.fixture
def local(made) -> bytes:
    return (made / "local" / "answers.csv").read_bytes()


@pytest.fixture
def parts(made, tmp_path) -> list[Path]:
    """Copies of its own."""
    return [Path(shutil.copytree(made / f"part-{number}", tmp_path / f"part-{number}")) for number in range(1, PARTS + 1)]


def merged(trial, out, parts) -> subprocess.CompletedProcess:
    return call(trial, out, "--merge", *parts)


def test_merged_parts_are_the_whole(trial, tmp_path, local, parts):
    done = merged(trial, tmp_path / "whole", parts)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "whole" / "answers.csv").read_bytes() == local
    counts = [len(list(part.glob("raw/*/case.json"))) for part in parts]
    assert sum(counts) == 24 and all(count > 3 for count in counts)
    again = call(trial, tmp_path / "whole")
    assert again.returncode == 0 and "26 of 26 cases are complete already" in again.stdout


def test_a_part_that_is_damaged_is_left_out_and_told(trial, tmp_path, parts):
    broken = next(parts[1].glob("raw/*/frames.csv"))
    broken.write_text("frame\n")
    done = merged(trial, tmp_path / "whole", parts)
    assert done.returncode == 1 and f"{broken.parent}: frames.csv has 0 of 2 rows; left out" in done.stderr
    assert "1 missing" in done.stdout
    assert call(trial, tmp_path / "whole").returncode == 0  # runs that one


@pytest.mark.parametrize(("change", "words"), [
    ({"binary_sha256": "other"}, "was measured with another build of the program than"),
    ({"data_sha256": "other"}, "was measured with other data than")])
def test_parts_of_other_builds_or_data_are_refused(trial, tmp_path, parts, change, words):
    seal = next(parts[2].glob("raw/*/case.json"))
    seal.write_text(json.dumps(json.loads(seal.read_text()) | change))
    done = merged(trial, tmp_path / "whole", parts)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and words in done.stderr
    assert not (tmp_path / "whole").exists()


def test_parts_of_other_plans_or_no_parts_are_refused(trial, tmp_path, parts, capsys):
    plan = json.loads((parts[1] / "experiment.json").read_text())
    (parts[1] / "experiment.json").write_text(json.dumps(plan | {"cases": plan["cases"][1:]}))
    done = merged(trial, tmp_path / "whole", parts)
    assert done.returncode == 2 and "has other cases planned than" in done.stderr
    assert experiment.main([str(trial), "--merge", str(tmp_path / "nowhere"), "--out", str(tmp_path / "whole")]) == 2
    assert "has no experiment.json" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.skipif(not shutil.which("snakemake"), reason="snakemake is not installed")
def test_snakemake_gives_the_bytes_of_one_machine(trial, tmp_path, local):
    config = [f"experiment={trial}", f"out={tmp_path}/snake", f"parts={JOBS}", f"musclebench={QUICK}"]
    done = subprocess.run(["snakemake", "-s", str(CLUSTER / "Snakefile"), "--cores", "2", "--config", *config], cwd=PROJECT,
                          capture_output=True, text=True, timeout=300, check=False, env=os.environ | {"HOME": str(tmp_path)})
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / "snake" / "whole" / "answers.csv").read_bytes() == local


@pytest.mark.long
@pytest.mark.skipif(not is_installed(), reason="Slurm and munge are not installed, or this is not root")
def test_a_slurm_job_array_gives_the_bytes_of_one_machine(trial, tmp_path, local):
    (tmp_path / "slurm").mkdir()
    out = tmp_path / "array"
    with one_node(tmp_path / "slurm") as environment:
        told = environment | {"EXPERIMENT": str(trial), "PARTS": str(JOBS), "OUT": str(out), "MUSCLEBENCH": str(QUICK)}
        done = subprocess.run(["sbatch", f"--array=1-{JOBS}", f"--output={tmp_path}/%a.log", str(CLUSTER / "slurm.sh")],
                              cwd=PROJECT, env=told, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr
        wait_for_jobs(environment, 300)
    logs = "".join(path.read_text() for path in tmp_path.glob("*.log"))
    assert merged(trial, out / "whole", sorted(out.glob("part-*"))).returncode == 0, logs
    assert (out / "whole" / "answers.csv").read_bytes() == local


@pytest.mark.long
@needs_program
@pytest.mark.parametrize("way", ["snakemake", "slurm"])
def test_a_fault_in_each_tenth_case_loses_nothing(way, tmp_path):
    if way == "snakemake" and not shutil.which("snakemake") or way == "slurm" and not is_installed():
        pytest.skip(f"{way} is not installed, or this is not root")
    assert cluster_campaign.main(["--musclebench", PROGRAM, "--out", str(tmp_path / "campaign"), "--cases", "60", "--parts", "2",
                                  "--by", way]) == 0
