"""How many nodes the tunnelling guard's rules keep from passing through bones, in whole motions of large steps."""

from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene
from ..program.registry import Registry
from ..results.run_folder import Run, read_all
from ..tables.table_formats import Column, Table
from .effect_runs import NAN

PRESET = "paper"  # bones jump to the pose of a frame
ONE_STEP = ("--loop", "substeps=1")  # the judge, which looks at the ends of frames, then sees every step
FRAMES = (6, 24)  # of the motion there and back
EFFECT = "tunnelling_guard"
RULES = ("", "angle", "crossing")  # "": no guard

GUARD_COLUMNS = [
    Column("muscle", "muscle"), Column("frames", "frames of the motion", 0), Column("step_deg", "degrees a frame", 1),
    Column("without", "tunnelled nodes without a guard", 0, "without"), Column("angle", "by the rule of 135 degrees", 0, "angle"),
    Column("angle_recall", "recall %", 0, "recall\n%"), Column("crossing", "by the path", 0, "crossing"),
    Column("crossing_recall", "recall %", 0, "recall\n%"),
]
CAPTION = (
    "Nodes on the wrong side of a bone, the most in a frame, where the whole motion is made in few steps (preset `paper`, bones "
    "jump, one substep a frame): without a guard, with the paper's rule of 135 degrees and with the crossing of a node's path. "
    "Recall: the share of those without a guard that is kept."
)


@dataclass(frozen=True)
class GuardCase(SceneCase):
    scene: Scene
    backend: str
    frames: int
    rule: str

    @property
    def name(self) -> str:
        return f"{self.scene.key}-guard={self.rule or 'none'}-frames={self.frames}"

    @property
    def kind(self) -> str:
        return "guards"

    @property
    def guessed_seconds(self) -> float:
        return 1.5 + 0.05 * self.scene.size * self.frames

    def arguments(self, folders: Folders) -> list[str]:
        guard = ["--effect", f"{EFFECT}:rule={self.rule}"] if self.rule else []
        return ["run", self.scene.name, "--backend", self.backend, "--preset", PRESET, "--threads", "1", *guard,
                *ONE_STEP, "--frames", str(self.frames), *self.scene.data_arguments(folders)]

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "preset": PRESET, "backend": self.backend, "parameters": {},
                "threads": 1}


def plan_guards(scenes: list[Scene], registry: Registry, backend: str) -> list[GuardCase]:
    """None where a scene's own guard would be in all, or this build has none."""
    if EFFECT not in registry.effects:
        return []
    return [GuardCase(replace(scene, preset=PRESET), backend, frames, rule)
            for scene in scenes if EFFECT not in scene.effects for frames in FRAMES for rule in RULES]


def guard_table(folders: dict[GuardCase, Path]) -> Table:
    """`folders`: of the complete cases."""
    runs = dict(zip(folders, read_all(list(folders.values()))))
    groups = dict.fromkeys((case.scene.name, case.frames) for case in runs)
    rows = [_row({case.rule: run for case, run in runs.items() if (case.scene.name, case.frames) == group}, group[1])
            for group in groups]
    keys = [column.key for column in GUARD_COLUMNS]
    return Table("guards", CAPTION, GUARD_COLUMNS, pd.DataFrame(rows, columns=keys), [key for key in keys if key != "muscle"])


def _row(runs: dict[str, Run], frames: int) -> dict:
    some = next(iter(runs.values()))
    row = {"muscle": some.muscle, "frames": frames, "step_deg": _largest_step_deg(some), "without": _tunnelled(runs.get(""))}
    for rule in RULES[1:]:
        kept = _tunnelled(runs.get(rule))
        row[rule] = kept
        row[f"{rule}_recall"] = 100 * (1 - kept / row["without"]) if row["without"] else NAN
    return row


def _tunnelled(run: Run | None) -> float:
    value = ((run.record if run else {}).get("outcome") or {}).get("tunnelled_nodes")
    return NAN if value is None else float(value)


def _largest_step_deg(run: Run) -> float:
    if run.frames.empty:
        return NAN
    return float(pd.concat([pd.Series([0.0]), run.frames["angle_deg"]]).diff().abs().max())
