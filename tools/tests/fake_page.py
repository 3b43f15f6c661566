"""Folders of results for the page: runs whose muscle moves, and depths that are known."""

import json
from pathlib import Path

import numpy as np

import fake_registry
import fake_runs
from musclebench.program.registry import save_registry
from musclebench.results import run_folder

FRAMES = 12
KEPT = (0, 3, 6, 9, 12)
MUSCLES = ("iliacus", "gluteus_medius")
BONES = {"pelvis": fake_runs.sphere((0, 0, 0.03), 0.03), "femur": fake_runs.sphere((0, 0, -0.05), 0.04)}
MUSCLE = fake_runs.sphere((0, -0.05, 0.0), 0.06)
MOTIONS = {"femur": {"axis": [-1, 0, 0], "centre_m": [0, 0, 0], "angles_rad": [0, 1.57]}}


def snapshots(deepest_m: float = 0.004) -> list[fake_runs.Snapshot]:
    """The muscle goes up by a millimetre a frame; its lower half is deeper in a bone the farther the joint is turned."""
    made = []
    for frame in KEPT:
        flexion = 1 - abs(2 * frame / FRAMES - 1)
        moved = MUSCLE.vertices_m + np.array([0.0, 0.0, 1e-3 * frame])
        depth = deepest_m * flexion * (MUSCLE.vertices_m[:, 2] < 0)
        poses = [(np.eye(3), np.zeros(3)), fake_runs.turn_about_x(90 * flexion, (0, 0, 0))]
        made.append(fake_runs.Snapshot(frame, 90 * flexion, moved, depth, (MUSCLE.vertices_m[:, 2] > 0.055).astype("u1"), poses))
    return made


def write_paper(folder: Path, muscles=MUSCLES) -> Path:
    """What tools/paper leaves, as far as the page reads it."""
    for muscle in muscles:
        for backend in fake_runs.BACKENDS:
            fake_runs.write_run(folder / "raw" / f"{muscle}-{backend}", f"synthetic/{muscle}", backend, FRAMES, bones=BONES,
                                triangles=MUSCLE.triangles, snapshots=snapshots(), motions=MOTIONS)
    runs = run_folder.read_runs(folder / "raw")
    run_folder.runs_table(runs).to_csv(folder / "runs.csv", index=False)
    (folder / "tables").mkdir()
    (folder / "tables" / "table_1_memory.csv").write_text("muscle\n")
    save_registry(fake_registry.registry(), folder)
    return folder


def write_hard(folder: Path) -> Path:
    """Two cases, a backend whose name pandas takes for unknown, and words that HTML would take for its own."""
    (folder / "tables").mkdir(parents=True)
    (folder / "tables" / "cells.csv").write_text(
        "case,backend,verdict,figure,value,bar,unit,said\n"
        f"thin,{fake_registry.roles().control},not applicable,,,,,<b>no</b> answers\n"
        "thin,grid,breaks,depth,0.25,0.1,mm,\n"
        "flat,grid,holds,depth,0,0.1,mm,\n")
    (folder / "tables" / "cases.csv").write_text("case,what,why,bar,scene\nthin,A plate.,It is thin.,depth below 0.1 mm,\n")
    return folder


def embedded(page: str, name: str) -> str:
    """The CSV that the page carries under this name."""
    import base64
    import zlib
    text = page.partition(f'id="rows-{name}">')[2].partition("</script>")[0]
    return zlib.decompress(base64.b64decode(text)).decode()


def data_of_views(page: str, name: str) -> dict:
    return json.loads(page.partition(f'id="{name}-data">')[2].partition("</script>")[0])
