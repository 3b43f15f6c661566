#!/usr/bin/python3
"""Stands in for the program: writes a run folder as `musclebench run` does. FAKE_BEHAVIOUR maps cases to misbehaviour,
such as "iliacus-voxel=crash iliacus-sdf=diverge gluteus_medius-fcl=hang"; FAKE_LOG gets one line a call."""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import fake_runs  # noqa: E402  (beside this file, which the program's folder is not)


def parse_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("command")
    parser.add_argument("scene")
    for option in ("--backend", "--preset", "--out", "--data", "--snapshots", "--threads", "--frames"):
        parser.add_argument(option)
    parser.add_argument("--progress", action="store_true")
    return parser.parse_args()


def snapshots(muscle, frames_wanted):
    full = max(frames_wanted)
    rest, turn = muscle.vertices_m, fake_runs.turn_about_x
    for frame in frames_wanted:
        angle = 90.0 * frame / full
        pose = turn(angle, (0, 0, 0))
        poses = [(np.eye(3), np.zeros(3)), pose]
        depth = 0.004 * angle / 90.0 * (rest[:, 2] < 0.0)
        yield fake_runs.Snapshot(frame, angle, rest, depth, (rest[:, 2] > 0.055).astype("u1"), poses)


def main() -> int:
    options = parse_arguments()
    muscle_name = options.scene.split("/")[-1]
    name = f"{muscle_name}-{options.backend}"
    behaviour = dict(item.split("=") for item in os.environ.get("FAKE_BEHAVIOUR", "").split()).get(name, "")
    if "FAKE_LOG" in os.environ:
        with open(os.environ["FAKE_LOG"], "a") as log:
            print(name, *sorted(os.sched_getaffinity(0)), file=log)
    if behaviour == "crash":
        print("musclebench: scene.toml: key 'x': no such thing", file=sys.stderr)
        return 2
    frames = int(options.frames or 314)
    print(f"progress {frames // 2} {frames}", file=sys.stderr, flush=True)
    if behaviour == "hang":
        Path(options.out).mkdir(parents=True)
        time.sleep(60)
    bones = {"pelvis": fake_runs.sphere((0, 0, 0.03), 0.03), "femur": fake_runs.sphere((0, 0, -0.05), 0.04)}
    muscle = fake_runs.sphere((0, -0.05, 0.0), 0.06)
    status = "diverged" if behaviour == "diverge" else "ok"
    shots = [] if behaviour == "diverge" else list(snapshots(muscle, [int(f) for f in options.snapshots.split(",")]))
    fake_runs.write_run(Path(options.out), options.scene, options.backend, frames, status,
                        "frame 3" if behaviour == "diverge" else "", bones, muscle.triangles, shots,
                        {"femur": {"axis": [-1, 0, 0], "centre_m": [0, 0, 0], "angles_rad": [0, 1.57]}})
    print(json.dumps({"done": name}))
    return 3 if behaviour == "diverge" else 0


if __name__ == "__main__":
    sys.exit(main())
