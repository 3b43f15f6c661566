#!/usr/bin/python3
"""Many small real cases through Snakemake or Slurm on one node, with a fault injected into each tenth.

tools/tests/cluster_campaign.py --musclebench PROGRAM --out DIR [--cases 1000] [--parts 20] [--by snakemake|slurm|both]

What is run again until all is whole is compared with the same cases on one machine without faults. Prints what each step took.
As root faults of the disk are those of a full file system, and Slurm can be started. Exit code 1: something was lost or differs.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent)]

import ball_on_box  # noqa: E402  (found through the path that is set above)
from one_node_slurm import one_node, wait_for_jobs  # noqa: E402

PROJECT = Path(__file__).resolve().parents[2]
CLUSTER = PROJECT / "bench/experiments/cluster"
EXPERIMENT = """title = "Many small cases"
scenes = ["FOLDER/scene.toml"]
repetitions = REPETITIONS

[[cases]]
name = "run"
backends = ["null", "voxel", "sdf", "bvh", "brute_force"]
configurations = "default"
file_presets = true
named = "{backend}-{substeps}-r{repetition}"

[cases.vary.substeps]
2 = ["--loop", "substeps=2"]
3 = ["--loop", "substeps=3"]
"""
COMBINATIONS = 10  # of backends and substeps
MOST_ATTEMPTS = 12


@dataclass
class Campaign:
    """What came of it."""

    seconds: dict[str, float] = field(default_factory=dict)
    faults: Counter = field(default_factory=Counter)
    attempts: int = 0
    first_statuses: Counter = field(default_factory=Counter)
    failed_rows: int = 0  # of the table after the first attempt
    is_equal: bool = False
    leftovers: list[str] = field(default_factory=list)  # files that no complete case has


def experiment(folder: Path, out: Path, program: Path, *more: str) -> int:
    command = ["tools/experiment", str(folder / "many.toml"), "--musclebench", str(program), "--out", str(out), *more]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    return done.returncode


@contextmanager
def full_disk(folder: Path):
    """A file system without room, where one can be mounted."""
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", str(folder)], capture_output=True, check=False)
    try:
        if mounted.returncode == 0:
            (folder / "filler").write_bytes(b"0" * 4096)
        yield
    finally:
        if mounted.returncode == 0:
            subprocess.run(["umount", str(folder)], check=True)


def snakemake(folder: Path, out: Path, parts: int, environment: dict) -> bool:
    """One attempt at all parts; whether they are whole."""
    config = [f"experiment={folder}/many.toml", f"out={out}", f"parts={parts}", f"musclebench={PROJECT}/tools/tests/faulty_program.sh"]
    done = subprocess.run(["snakemake", "-s", str(CLUSTER / "Snakefile"), "--cores", "2", "--keep-going", "--rerun-incomplete",
                           "--config", *config], cwd=PROJECT, capture_output=True, text=True, check=False, env=environment)
    return done.returncode == 0


def slurm(folder: Path, out: Path, parts: int, environment: dict) -> bool:
    told = environment | {"EXPERIMENT": f"{folder}/many.toml", "PARTS": str(parts), "OUT": str(out),
                          "MUSCLEBENCH": f"{PROJECT}/tools/tests/faulty_program.sh"}
    subprocess.run(["sbatch", f"--array=1-{parts}", f"--output={folder}/%a.log", "--oversubscribe", "--cpus-per-task=1",
                    str(CLUSTER / "slurm.sh")], cwd=PROJECT, env=told, capture_output=True, text=True, timeout=60, check=True)
    wait_for_jobs(environment, 3600)
    return all((out / f"part-{part}/answers.csv").is_file() for part in range(1, parts + 1))


def rows(table: Path) -> list[str]:
    return table.read_text().splitlines()[1:] if table.is_file() else []


def run_campaign(folder: Path, program: Path, cases: int, parts: int, attempt_by, environment: dict) -> Campaign:
    """`folder` has the scene, many.toml and `reference`. `attempt_by`: snakemake or slurm."""
    campaign, out, faults = Campaign(), folder / attempt_by.__name__, folder / f"faults-{attempt_by.__name__}"
    faults.mkdir()
    (faults / "program").symlink_to(program)
    folders = [out / f"part-{part}" for part in range(1, parts + 1)]
    with full_disk(faults / "full"):
        while campaign.attempts < MOST_ATTEMPTS:
            campaign.attempts += 1
            started = time.monotonic()
            whole = attempt_by(folder, out, parts, environment | {"FAULTS": str(faults)})
            campaign.seconds[f"attempt {campaign.attempts}"] = time.monotonic() - started
            statuses = Counter(json.loads(path.read_text())["status"] for part in folders for path in part.glob("raw/*/run.json"))
            if campaign.attempts == 1:
                campaign.first_statuses = statuses
            if whole and sum(statuses.values()) == cases and not statuses.keys() - {"ok", "suspect"}:
                break
            for part in folders:  # of a part that is whole but for failed cases, a workflow knows nothing to do
                (part / "answers.csv").unlink(missing_ok=True)
            shutil.rmtree(out / "whole", ignore_errors=True)
    campaign.faults = Counter(path.read_text().strip() for path in faults.glob("*/fault"))
    started = time.monotonic()
    shutil.rmtree(out / "whole", ignore_errors=True)
    experiment(folder, out / "whole", program, "--merge", *map(str, folders))
    campaign.seconds["merge"] = time.monotonic() - started
    campaign.is_equal = (out / "whole/answers.csv").read_bytes() == (folder / "reference/answers.csv").read_bytes()
    campaign.leftovers = [str(path) for part in folders for path in part.glob("raw/.*")]
    return campaign


def prepare(folder: Path, program: Path, cases: int) -> float:
    """Seconds of the same cases on this machine without faults."""
    ball_on_box.write_scene(folder)
    (folder / "many.toml").write_text(EXPERIMENT.replace("FOLDER", str(folder)).replace("REPETITIONS", str(cases // COMBINATIONS)))
    started = time.monotonic()
    experiment(folder, folder / "reference", program)
    assert len(rows(folder / "reference/answers.csv")) == cases, "the plan has other cases than were asked for"
    return time.monotonic() - started


def told(name: str, campaign: Campaign, cases: int) -> str:
    times = ", ".join(f"{step} {seconds:.0f} s" for step, seconds in campaign.seconds.items())
    first = ", ".join(f"{count} {status}" for status, count in sorted(campaign.first_statuses.items()))
    faults = ", ".join(f"{count} {kind}" for kind, count in sorted(campaign.faults.items()))
    return (f"{name}: {cases} cases, faults: {faults}; after the first attempt: {first}; {campaign.attempts} attempts ({times}); "
            f"{'equal to one machine' if campaign.is_equal else 'DIFFERS'}, {len(campaign.leftovers)} leftovers")


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--musclebench", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--parts", type=int, default=20)
    parser.add_argument("--by", choices=["snakemake", "slurm", "both"], default="both")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True)
    folder, program = options.out.resolve(), options.musclebench.resolve()
    print(f"one machine without faults: {prepare(folder, program, options.cases):.0f} s", flush=True)
    held = True
    with ExitStack() as node:
        ways = {"snakemake": (snakemake, os.environ | {"HOME": str(folder)})}
        if options.by != "snakemake":
            short = Path(node.enter_context(tempfile.TemporaryDirectory()))  # a socket's path has at most 107 characters
            ways["slurm"] = (slurm, node.enter_context(one_node(short)))
        for name, (way, environment) in ways.items():
            if options.by not in (name, "both"):
                continue
            campaign = run_campaign(folder, program, options.cases, options.parts, way, dict(environment))
            print(told(name, campaign, options.cases), flush=True)
            held = held and campaign.is_equal and not campaign.leftovers
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
