"""A random scene is run, and its shapes are judged."""

import json
import shutil
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ..results.run_folder import ResultProblem
from .judge import Shape, counted, shapes_of
from .scenes import FRAMES, RandomScene, random_scene, write_scene

TIMEOUT_S = 300.0
PASSED, ESCAPED, BEGINS_SO, REFUSED, TOO_LONG, CRASHED = "passed through", "left the room", "begins crossed", "refused", "too long", "crashed"
TOLD = "told"  # by the program: what is prescribed came together
FLEW_OFF = "flew off"  # what a fast bone flings may; the program ends such a run as diverged
HELD = "held"
DIVERGED = "diverged"
GAVE_UP = "gave up"  # although nothing that is prescribed moves
FINDINGS = (PASSED, ESCAPED, CRASHED, TOO_LONG, DIVERGED, GAVE_UP, REFUSED)
LEFT = "left the scene"  # in words of the program


@dataclass
class Trial:
    scene: int
    kind: str
    what: str  # bodies and speed
    verdict: str
    status: str = ""  # what the program says of the run
    frame: int = 0  # of the first that passed or left
    triangles: int = 0  # that pass through others, in that frame
    detail: str = ""

    @property
    def is_finding(self) -> bool:
        return self.verdict in FINDINGS

    @property
    def row(self) -> dict[str, object]:
        return asdict(self)


def tried(program: Path, seed: int, number: int, out: Path, effects: list[str], backend: str, keeps: bool) -> Trial:
    """`out`: a folder of this scene; it stays where something was found, or where `keeps` says so."""
    scene = random_scene(seed, number)
    shutil.rmtree(out, ignore_errors=True)
    path = write_scene(scene, out, effects)
    command = [str(program), "run", str(path), "--backend", backend, "--threads", "1", "--out", str(out / "run"),
               "--snapshots", ",".join(map(str, range(FRAMES + 1)))]
    told = Trial(number, scene.kind, scene.words, HELD)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired:
        told.verdict = TOO_LONG
        return told
    record = out / "run" / "run.json"
    if done.returncode < 0 or not record.is_file():
        told.verdict = REFUSED if done.returncode == 2 else CRASHED
        told.detail = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    else:
        _judge(scene, out / "run", told)
    if not told.is_finding and not keeps:
        shutil.rmtree(out)
    return told


def _judge(scene: RandomScene, run: Path, told: Trial) -> None:
    manifest = json.loads((run / "run.json").read_text())
    told.status, told.detail = manifest["status"], str(manifest.get("status_detail") or "")
    gave_up = min((one["frame"] for one in manifest.get("gave_up", [])), default=FRAMES + 1)
    is_gone = told.status == DIVERGED and LEFT in told.detail
    if told.status == DIVERGED:
        told.verdict = (ESCAPED if scene.half_room_m else FLEW_OFF) if is_gone else DIVERGED
    gave_up = manifest.get("gave_up", [])
    if gave_up and not scene.has_moving_bones:
        told.verdict, told.frame, told.detail = GAVE_UP, gave_up[0]["frame"], gave_up[0]["why"]
        return
    try:
        for shape in shapes_of(run, manifest):
            if gave_up and shape.frame >= gave_up[0]["frame"]:
                if told.verdict == HELD:
                    told.verdict, told.frame, told.detail = TOLD, shape.frame, gave_up[0]["why"]
                return
            found = counted(shape, scene.carriers)
            if any(found.values()):
                told.verdict = BEGINS_SO if shape.frame == 0 else PASSED
                told.detail = ", ".join(f"{kind} {count}" for kind, count in found.items() if count)
            elif scene.half_room_m and _has_left(shape, scene.half_room_m):
                told.verdict = ESCAPED
            else:
                continue
            told.frame, told.triangles = shape.frame, sum(found.values())
            return
    except ResultProblem as problem:
        told.verdict, told.detail = CRASHED, str(problem)


def _has_left(shape: Shape, half_m: float) -> bool:
    used = np.concatenate([muscle.points[np.unique(muscle.triangles)] for muscle in shape.muscles])
    return bool((np.abs(used) > half_m).any())
