"""What a folder holds from before: a study of the same settings goes on and keeps its cases, one of others is refused."""

import shutil
from dataclasses import fields, replace
from pathlib import Path

from ..program.cli import Problem
from ..program.registry import Registry
from ..results.run_folder import ResultProblem
from .experiment_file import ASKED, SCENE_SETS, CaseGroup, ExperimentFile
from .manifest import FILE_NAME, read_manifest

# Of [[cases]]: what changes how a case is measured and not how it is called. All else says which cases there are.
HOW = ("mode", "preset", "file_presets", "judged", "snapshots", "adds_effect", "rest_s", "options", "stride", "replay_s",
       "band_mm", "points", "program", "samples", "sample_s")
assert set(HOW) <= {one.name for one in fields(CaseGroup)}
FRAMES_LIMIT = "frames_limit"


def settings_of(file: ExperimentFile) -> dict[str, str]:
    """By name, of what is not as usual."""
    usual, told = CaseGroup(""), {"experiment": file.name}
    if file.frames_limit:
        told[FRAMES_LIMIT] = str(file.frames_limit)
    if file.preset:
        told["preset"] = file.preset
    for group in file.groups:
        told |= {f"{group.name}.{key}": str(value) for key in HOW if (value := getattr(group, key)) != getattr(usual, key)}
    return told


def earlier_plan(out_dir: Path) -> dict:
    """As experiment.json tells it; empty where there is none, or none that can be read."""
    try:
        return read_manifest(out_dir)
    except ResultProblem:
        return {}


def differences(file: ExperimentFile, plan: dict) -> list[str]:
    """In words, of the settings of the plan and those of the file. [[cases]] that only one of them has add to the other."""
    if not plan:
        return []
    now, before = settings_of(file), plan.get("settings")
    if before is None:  # written by tools that did not note them, which are of one experiment at least
        before = now | {"experiment": plan.get("experiment", file.name)}
    groups = {case.get("group") for case in plan.get("cases", [])} & {group.name for group in file.groups}
    keys = [key for key in {**before, **now} if "." not in key or key.partition(".")[0] in groups]
    return [f"{key} {before.get(key, 'as usual')}, now {now.get(key, 'as usual')}" for key in keys
            if before.get(key) != now.get(key)]


def refuse_other_settings(out_dir: Path, file: ExperimentFile) -> None:
    if found := differences(file, earlier_plan(out_dir)):
        raise Problem(f"{out_dir}: holds a study of other settings ({'; '.join(found)}), which would be replaced; choose another "
                      "--out, or replace it with --force")


def remove_other_settings(out_dir: Path, file: ExperimentFile, result_dirs: tuple[str, ...]) -> None:
    """All cases that a plan of other settings names, and no more."""
    plan = earlier_plan(out_dir)
    if not differences(file, plan):
        return
    for name in {Path(case["name"]).name for case in plan.get("cases", [])}:
        for folder in result_dirs:
            shutil.rmtree(out_dir / folder / name, ignore_errors=True)
    (out_dir / FILE_NAME).unlink(missing_ok=True)


def with_earlier(file: ExperimentFile, plan: dict, registry: Registry) -> ExperimentFile | None:
    """The experiment on the plan's scenes, too, and with as many repetitions; None where it has nothing to add."""
    if not plan or differences(file, plan) or any(group.scenes == ASKED for group in file.groups):
        return None
    own = {group.name for group in file.groups if not group.scenes and group.mode != "hard"}
    places = {scene.name: place for place, scene in enumerate(registry.scenes)}
    scenes = dict.fromkeys(case["scene"] for case in plan["cases"] if case.get("group") in own)
    there = [scene for scene in scenes if scene in places or (scene.endswith(".toml") and Path(scene).is_file())]
    asked = file.scenes if isinstance(file.scenes, tuple) else (file.scenes,)
    every = sorted(dict.fromkeys([*asked, *there]), key=lambda scene: places.get(scene, -1 if scene in SCENE_SETS else len(places)))
    wider = replace(file, scenes=tuple(every), repetitions=max(file.repetitions, int(plan.get("repetitions") or 1)))
    return None if set(every) == set(asked) and wider.repetitions == file.repetitions else wider
