#!/usr/bin/python3
"""Stands in for the program: writes what `musclebench run`, `record`, `replay` and `probe` write. FAKE_BEHAVIOUR maps
cases to misbehaviour, such as "iliacus-voxel=crash iliacus-sdf=diverge"; FAKE_LOG gets one line a call;
with FAKE_LIGHT runs hold no more than what a sweep looks at."""

import argparse
import json
import os
import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1])]

LAST_WORDS = {
    "crash": "musclebench: scene.toml: key 'x': no such thing",
    "full_disk": "musclebench: run/frames.csv: cannot be written; is the disk full or the folder write-protected?",
    "greedy": "musclebench: sdf: cells: needs 900000 MB of memory, 8000 MB are there; choose fewer cells",
}


def parse_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("command", choices=["run", "record", "replay", "probe", "list"])
    parser.add_argument("input", nargs="?")
    parser.add_argument("--json", action="store_true")
    for option in ("--backend", "--preset", "--out", "--data", "--snapshots", "--threads", "--frames", "--meshes", "--stride", "--effects",
                   "--band-mm", "--points"):
        parser.add_argument(option)
    parser.add_argument("--repetition", type=int)
    parser.add_argument("--param", action="append", default=[])
    parser.add_argument("--loop", action="append", default=[])
    parser.add_argument("--effect", action="append", default=[])
    parser.add_argument("--no-effect", action="append", default=[])
    parser.add_argument("--self-intersections", action="store_true")
    parser.add_argument("--fibres", type=int, default=0)
    parser.add_argument("--fibres-if-possible", type=int, default=0)
    parser.add_argument("--progress", action="store_true")
    parser.add_argument("--no-referee", action="store_true")
    parser.add_argument("--bones-only", action="store_true")
    parser.add_argument("--no-pruning", action="store_true")
    parser.add_argument("--forces", action="store_true")
    return parser.parse_args()


def case_name(options) -> str:
    """The experiments let a case write into .NAME.PROCESS/run."""
    hidden = next(part for part in reversed(Path(options.out).parts) if part.startswith("."))
    return hidden[1:].rpartition(".")[0]


def paper_snapshots(muscle, frames_wanted):
    import fake_runs
    import numpy as np
    full = max(frames_wanted)
    rest, turn = muscle.vertices_m, fake_runs.turn_about_x
    for frame in frames_wanted:
        angle = 90.0 * frame / full
        pose = turn(angle, (0, 0, 0))
        poses = [(np.eye(3), np.zeros(3)), pose]
        depth = 0.004 * angle / 90.0 * (rest[:, 2] < 0.0)
        yield fake_runs.Snapshot(frame, angle, rest, depth, (rest[:, 2] > 0.055).astype("u1"), poses)


def write_paper_run(options, status: str) -> None:
    import fake_runs
    bones = {"pelvis": fake_runs.sphere((0, 0, 0.03), 0.03), "femur": fake_runs.sphere((0, 0, -0.05), 0.04)}
    muscle = fake_runs.sphere((0, -0.05, 0.0), 0.06)
    wanted = [int(frame) for frame in (options.snapshots or "").split(",") if frame]
    shots = [] if status == "diverged" or not wanted else list(paper_snapshots(muscle, wanted))
    fake_runs.write_run(Path(options.out), options.input, options.backend, int(options.frames or 314), status,
                        "frame 3" if status == "diverged" else "", bones, muscle.triangles, shots,
                        {"femur": {"axis": [-1, 0, 0], "centre_m": [0, 0, 0], "angles_rad": [0, 1.57]}})
    if options.loop or options.param:
        told = Path(options.out) / "run.json"
        loop = {key: float(value) if key == "start_noise_m" else int(value)
                for key, value in (word.split("=") for word in options.loop) if key in ("substeps", "iterations", "rest_frames", "start_noise_m")}
        chosen = {"loop": loop, "parameters": dict(word.split("=", 1) for word in options.param)}
        record = json.loads(told.read_text())
        told.write_text(json.dumps(record | {"case": record["case"] | {key: value for key, value in chosen.items() if value}}))


def write_effect_run(options, status: str) -> None:
    """With what effects make of it: local_volume leaves no fold, margin no depth."""
    write_paper_run(options, status)
    told = Path(options.out) / "run.json"
    outcome = {"max_depth_m": 0.0, "max_surface_depth_m": 0.0 if "margin" in options.effect else 5e-4,
               "max_volume_error": 0.001 if "volume" not in options.no_effect else 0.2, "tunnelled_nodes": 0,
               "self_intersecting_triangles": 0 if "local_volume" in options.effect else 7,
               "self_intersecting_triangles_at_rest": 0, "p99_edge_stretch": 1.2}
    told.write_text(json.dumps(json.loads(told.read_text()) | {"outcome": outcome}))


def write_study_case(options, status: str, answer: str) -> None:
    """Only what the sweep looks at."""
    parameters = dict(assignment.split("=", 1) for assignment in options.param)
    structures = parameters.get("structures")
    built = bool(structures) and not (Path(structures) / "bone.field").exists()
    if built:
        (Path(structures) / "bone.field").write_text("a field")
    mode = {"run": "coupled"}.get(options.command, options.command)
    record = {
        "status": status, "status_detail": "", "contact_hash": answer, "state_hash": answer, "frames": 1,
        "structures": "built" if built else "loaded",
        "case": {"mode": mode, "backend": options.backend, "parameters": parameters},
    }
    folder = Path(options.out)
    folder.mkdir(parents=True)
    (folder / "frames.csv").write_text("frame\n1\n")
    (folder / "run.json").write_text(json.dumps(record))


def write_recording(options) -> None:
    Path(options.out).write_text(f"positions of {options.input}")


def main() -> int:
    options = parse_arguments()
    if options.command == "list" or options.points == "1":  # most calls need it not, and importing it takes a third of theirs
        import fake_registry
    if options.command == "list":
        print(fake_registry.text())
        return 0
    if options.command == "probe" and options.points == "1":
        fake_registry.write_survey(Path(options.out), options.input, int(options.frames or 314))
        return 0
    name = case_name(options)
    behaviours = dict(item.rsplit("=", 1) for item in os.environ.get("FAKE_BEHAVIOUR", "").split())
    behaviour = behaviours.get(name, "")
    if "FAKE_LOG" in os.environ:
        with open(os.environ["FAKE_LOG"], "a") as log:
            print(name, *sorted(os.sched_getaffinity(0)), file=log)
    if behaviour in LAST_WORDS:
        print(LAST_WORDS[behaviour], file=sys.stderr)
        return 2
    frames = int(options.frames or 314)
    print(f"progress {frames // 2} {frames}", file=sys.stderr, flush=True)
    if behaviour == "hang":
        Path(options.out).mkdir(parents=True)
        time.sleep(60)
    status = "diverged" if behaviour == "diverge" else "ok"
    if options.command == "record":
        write_recording(options)
    elif options.self_intersections:
        write_effect_run(options, status)
    elif options.command == "run" and "FAKE_LIGHT" not in os.environ:
        write_paper_run(options, status)
    else:
        write_study_case(options, status, "another answer" if behaviour == "differ" else "the answer")
    return 3 if behaviour == "diverge" else 0


if __name__ == "__main__":
    sys.exit(main())
