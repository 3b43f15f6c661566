#!/usr/bin/python3 -IS
"""Stands in for a program that is compared: writes what `list --json`, `--version`, `probe`, `run` and `hard` write. A copy's last line has its
times, answers and misbehaviour: # {"slower": {backend: factor}, "hash": {backend: text}, ...}."""

import json
import random
import sys
import time
from pathlib import Path

COLUMNS = "frame,angle_deg,warm_up,update_ns,detect_ns,respond_ns,frame_ns,contacts,nodes_inside,max_depth_m,mean_depth_m," \
          "missed_contacts,false_contacts,resident_bytes,involuntary_switches"
BACKENDS = ("plain", "tree", "grid", "slow")
SCENES = ("hard/resting_contact", "synthetic/iliacus")


def listed() -> dict:
    return {"schema": 1, "scenes": [{"name": name} for name in SCENES], "presets": [{"name": "paper"}],
            "backends": [{"name": name, "exact": True, "parameters": [],
                          "study": {"longest_stride": 8} if name == "slow" else {}} for name in BACKENDS]}


def probe(words: list[str]) -> None:
    """What a survey reads."""
    folder = Path(words[words.index("--out") + 1])
    folder.mkdir(parents=True)
    preset = words[words.index("--preset") + 1] if "--preset" in words else ""
    loop = {"frames": 60, "rest_frames": 0, "substeps": 1, "iterations": 3, "time_step_s": 0.003}
    (folder / "run.json").write_text(json.dumps({"case": {"loop": loop, "preset": preset}, "bones": [], "muscle": {"vertices": 100}}))


def run(words: list[str], told: dict) -> None:
    scene, backend, frames = words[1], words[words.index("--backend") + 1], int(words[words.index("--frames") + 1])
    folder, repetition = Path(words[words.index("--out") + 1]), int(words[words.index("--repetition") + 1])
    is_judged = "--no-referee" not in words
    noise = random.Random(f"{backend} {repetition} {told.get('seed', 0)}")
    detect = 1e5 * told.get("slower", {}).get(backend, 1.0) * noise.gauss(1, told.get("spread", 0.01))
    depth, missed = (told.get("depth", {}).get(backend, 0.001), 2) if is_judged else ("", "")
    rows = [[frame, 0, int(frame <= 2), 0, int(detect * noise.gauss(1, 0.01)), 0, int(detect * 2), 10, 0, depth, "", missed,
             missed, 1, 0] for frame in range(1, frames + 1)]
    folder.mkdir(parents=True)
    (folder / "frames.csv").write_text("\n".join([COLUMNS, *(",".join(map(str, row)) for row in rows)]) + "\n")
    record = {
        "schema_version": told.get("schema", 2), "status": told.get("status", "ok"), "status_detail": "", "frames": frames,
        "case": {"mode": "coupled", "scene": scene, "backend": backend, "judged": is_judged, "repetition": repetition},
        "build": {"git": told.get("git", "abc"), "compiler": "cc", "type": told.get("type", "Release")},
        "machine": {"cpu": told.get("cpu", "A processor"), "cores": 2}, "wall_ns": 10**9,
        "machine_state": {"involuntary_context_switches": told.get("switches", 0)}, "build_ns": 10**6,
        "cpu_ns": {"before_first_frame": 0, "after_last_frame": int(detect * 2 * frames)}, "structure_bytes": 1000,
        "state_hash": told.get("hash", {}).get(backend, "0123"), "outcome": {"p99_depth_m": depth or None},
    }
    (folder / "run.json").write_text(json.dumps(record, indent=2))


def main() -> int:
    told = json.loads(Path(__file__).read_text().splitlines()[-1].removeprefix("# "))
    if sys.argv[1] == "list":
        print(json.dumps(listed()))
    elif sys.argv[1] == "--version":
        print(f"musclebench 0 (abc, cc, {told.get('type', 'Release')})")
    elif sys.argv[1] == "probe":
        probe(sys.argv[1:])
    elif sys.argv[1] == "hard":
        time.sleep(told.get("hard_seconds", 0))
        folder = Path(sys.argv[sys.argv.index("--out") + 1])
        folder.mkdir(parents=True, exist_ok=True)
        rows = [f"thin-plate,{name},{told.get('cells', {}).get(name, 'holds')},missed,0,0,,,1," for name in BACKENDS]
        (folder / "matrix.csv").write_text("\n".join(["case,backend,verdict,figure,value,bar,unit,detail,seconds,scene", *rows]) + "\n")
    else:
        run(sys.argv[1:], told)
    return 0


if __name__ == "__main__":
    sys.exit(main())
