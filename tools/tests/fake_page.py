"""Folders of results for the page: runs whose muscle moves, and depths that are known."""

import base64
import json
import zlib
from pathlib import Path

import numpy as np

import fake_registry
import fake_runs
from musclebench.history.history import Finding, Measure, Night, opened
from musclebench.program.registry import save_registry
from musclebench.results import run_folder

FRAMES = 12
KEPT = (0, 3, 6, 9, 12)
ROLES = fake_registry.roles()
MUSCLES = ("iliacus", "gluteus_medius")
BONES = {"pelvis": fake_runs.sphere((0, 0, 0.03), 0.03), "femur": fake_runs.sphere((0, 0, -0.05), 0.04)}
MUSCLE = fake_runs.sphere((0, -0.05, 0.0), 0.06)
PRESSED_PA = {("femur", vertex): 100.0 + vertex for vertex in range(40)}
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
        for backend in fake_runs.backends():
            run = fake_runs.write_run(folder / "raw" / f"{muscle}-{backend}", f"synthetic/{muscle}", backend, FRAMES, bones=BONES,
                                      triangles=MUSCLE.triangles, snapshots=snapshots(), motions=MOTIONS)
            fake_runs.press_bones(run, PRESSED_PA)
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
        f"thin,{ROLES.control},not applicable,,,,,<b>no</b> answers\n"
        "thin,grid,breaks,depth,0.25,0.1,mm,\n"
        "flat,grid,holds,depth,0,0.1,mm,\n")
    (folder / "tables" / "cases.csv").write_text("case,what,why,bar,scene\nthin,A plate.,It is thin.,depth below 0.1 mm,\n")
    return folder


def embedded(page: str, name: str) -> str:
    """The CSV that the page carries under this name."""
    text = page.partition(f'id="rows-{name}">')[2].partition("</script>")[0]
    return zlib.decompress(base64.b64decode(text)).decode()


def data_of_views(page: str, name: str) -> dict:
    return json.loads(page.partition(f'id="{name}-data">')[2].partition("</script>")[0])


def write_accuracy(folder: Path) -> Path:
    """Four configurations of two muscles: a curve, an exact one, a wrong one, and the loop without collision."""
    grid, exact, choices, control = ROLES.field, ROLES.exact, ROLES.choices, ROLES.control
    points = [(grid, f"{grid} 16", f"{grid} cells", 16, 0.2, 1.0, 0, 0, 1), (grid, f"{grid} 64", f"{grid} cells", 64, 0.3, 0.05, 0, 0, 1),
              (exact, exact, "", "", 0.9, 1e-12, 0, 0, 1), (choices, choices, "", "", 90.0, 0.7, 0, 1, 0), (control, control, "", "", 0.001, 11.0, 1, 0, 0)]
    rows = ["panel,backend,configuration,series,label,fineness,time_ms,time_ms_low,time_ms_high,error_mm,structure_bytes,is_control,"
            "is_wrong,repetitions,frames,on_front"]
    rows += [f"synthetic/{muscle},{backend},{name},{series},{name},{fine},{ms * factor!r},{ms * factor * 0.9!r},{ms * factor * 1.2!r},{error!r},"
             f"1000000,{bool(is_control)},{bool(wrong)},1,40,{bool(front)}"
             for muscle, factor in zip(MUSCLES, (1.0, 2.0)) for backend, name, series, fine, ms, error, is_control, wrong, front in points]
    files = {"figures/pareto_replay.csv": "\n".join(rows) + "\n", "figures/pareto_replay.md": "**The same positions**\n\nThe error.\n\nData: synthetic.\n",
             "tables/price_list.csv": "muscle,target_mm,configuration\niliacus,0.1,grid 64\n",
             "tables/price_list.md": "Prices.\n\n| muscle | holds (mm) | cheapest |\n| --- | ---: | --- |\n| iliacus | 0.1 | grid 64 |\n",
             "tables/effect_costs.csv": "muscle,effect,own_ms,share_percent,added_ms,saved_ms\n"
             + "".join(f"{muscle},{effect},{ms},1,,\n" for muscle in MUSCLES for effect, ms in (("bending", 0.25), ("self_contact", 1.5))),
             "accuracy.csv": "case,scene,status,status_detail,disturbance\na,synthetic/iliacus,ok,,\nb,synthetic/iliacus,failed,out of luck,\n"}
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    save_registry(fake_registry.registry(), folder)
    return folder


NIGHTS, STEP_NIGHT, ANSWER_NIGHT = 14, 9, 11
TREE, BALL = "resting_contact-tree", "ball-grid"


def night_value(case: str, night: int) -> float:
    """Collision time, in ns: the tree is 10 % slower from STEP_NIGHT on."""
    noise = 1 + 0.01 * np.sin(1.7 * night + len(case))
    return {TREE: 2e6, BALL: 5e5}[case] * noise * (1.1 if case == TREE and night >= STEP_NIGHT else 1.0)


def write_history(path: Path, machine: str = "A processor, 2 cores") -> Path:
    """NIGHTS of two cases: one has a step of its time, one has another hash since ANSWER_NIGHT."""
    with opened(path) as history:
        for night in range(1, NIGHTS + 1):
            measures = []
            for case in (TREE, BALL):
                value, answer = night_value(case, night), "4567" if case == BALL and night >= ANSWER_NIGHT else "0123"
                measures += [Measure(case, "collision_ns", "time", "ns", value, None, 0.98 * value, 1.03 * value, 0.99 * value, 10, 0.01),
                             Measure(case, "structure_bytes", "counter", "bytes", 4e6, None, None, None, 4e6, 10, 0.0),
                             Measure(case, "state_hash", "exact", "", text=answer)]
            history.append(Night(f"2026-01-{night:02}T02:00:00Z", f"commit{night}", f"program{night}", machine, "cc", int(night == 3), 20), measures)
        history.note(STEP_NIGHT + 1, [Finding(TREE, "collision_ns", STEP_NIGHT, "change point", "1.99 ms", "2.2 ms", 1.1, 1.08, 1.12, 2e-6)])
        history.note(ANSWER_NIGHT, [Finding(BALL, "state_hash", ANSWER_NIGHT, "not the same", "0123", "4567")])
    return path
