#!/usr/bin/python3
"""How many substeps a muscle needs: the shape at full flexion against the number of substeps a frame.

Runs a scene with the `standard` preset for 5, 10, 20, ... substeps (the time of a frame stays the same), takes the run with the
most substeps as the reference, and writes the distance of each shape to it as CSV and prints it as Markdown.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).resolve().parent))
from musclebench.results.ply import read_ply  # noqa: E402

FRAME_TIME_S = 0.02
FRAMES = 90


def run_case(program: Path, scene: str, substeps: int, arguments: argparse.Namespace) -> dict:
    """Runs one case and returns its manifest, its frames and its shape at full flexion (vertices in metres, triangles)."""
    out = arguments.out / "raw" / scene.replace("/", "-") / f"substeps-{substeps}"
    command = [str(program), "run", scene, "--preset", "standard", "--backend", "sdf", "--out", str(out),
               "--param", f"structures={arguments.out / 'fields' / scene.split('/')[0]}",
               "--loop", f"substeps={substeps}", "--loop", f"time_step_s={FRAME_TIME_S / substeps!r}",
               "--snapshots", f"{FRAMES // 2},{FRAMES}"]
    if arguments.data:
        command += ["--data", str(arguments.data)]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 3):
        sys.exit(f"tools/convergence.py: {done.stderr.strip().splitlines()[-1] if done.stderr else 'the run failed'}")
    manifest = json.loads((out / "run.json").read_text())
    shapes = {shot["frame"]: read_ply(out / shot["file"]) for shot in manifest["snapshots"]}
    return {"manifest": manifest, "frames": pd.read_csv(out / "frames.csv"), "shapes": shapes}


def distances_mm(shape: np.ndarray, reference: np.ndarray) -> np.ndarray:
    return 1e3 * np.linalg.norm(shape - reference, axis=1)


def rows_of(scene: str, results: dict[int, dict]) -> list[dict]:
    reference = results[max(results)]["shapes"]
    rows = []
    for substeps, result in sorted(results.items()):
        row = {"scene": scene, "substeps": substeps, "status": result["manifest"]["status"]}
        if FRAMES // 2 in result["shapes"] and FRAMES // 2 in reference:
            at_flexion = distances_mm(result["shapes"][FRAMES // 2].vertices_m, reference[FRAMES // 2].vertices_m)
            row |= {"rms_mm": float(np.sqrt(np.mean(at_flexion**2))), "p99_mm": float(np.percentile(at_flexion, 99)),
                    "largest_mm": float(at_flexion.max())}
        frames = result["frames"]
        rest = result["manifest"]["muscle"]["rest_volume_m3"]
        row |= {"volume_error_percent": float(100 * (frames.volume_m3 / rest - 1).abs().max()),
                "largest_depth_mm": float(1e3 * frames.max_depth_m.max())}
        rows.append(row)
    return rows


def parse_arguments() -> argparse.Namespace:
    root = Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="scenes, such as synthetic/iliacus")
    parser.add_argument("--musclebench", type=Path, default=root / "build/release/bench/musclebench",
                        help="the program (default: %(default)s)")
    parser.add_argument("--data", type=Path, help="folder of the anatomical data, for lhdl/ scenes")
    parser.add_argument("--substeps", default="5,10,20,40,80,160", help="numbers to compare (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=root / "reports/out/convergence",
                        help="folder of the raw results (default: %(default)s)")
    parser.add_argument("--report", type=Path, default=root / "reports/convergence",
                        help="folder of the table (default: %(default)s)")
    return parser.parse_args()


def main() -> None:
    arguments = parse_arguments()
    if not arguments.musclebench.exists():
        sys.exit(f"tools/convergence.py: {arguments.musclebench} is missing; run tools/build first")
    counts = [int(count) for count in arguments.substeps.split(",")]
    rows = []
    for number, scene in enumerate(arguments.scenes):
        results = {}
        for place, count in enumerate(counts):
            print(f"\r{scene}: {count} substeps ({number * len(counts) + place + 1} of "
                  f"{len(counts) * len(arguments.scenes)})   ", end="", file=sys.stderr, flush=True)
            results[count] = run_case(arguments.musclebench, scene, count, arguments)
        rows += rows_of(scene, results)
    print(file=sys.stderr)
    table = pd.DataFrame(rows)
    arguments.report.mkdir(parents=True, exist_ok=True)
    table.to_csv(arguments.report / "substeps.csv", index=False)
    text = "\n".join(["| " + " | ".join(table.columns) + " |", "|" + " --- |" * len(table.columns)]
                     + ["| " + " | ".join(f"{v:.3g}" if isinstance(v, float) else str(v) for v in row) + " |"
                        for row in table.itertuples(index=False)])
    print(text)
    print(f"written to {arguments.report}")


if __name__ == "__main__":
    main()
