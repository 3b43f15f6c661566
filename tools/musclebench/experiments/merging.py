"""Puts the parts of an experiment that several machines ran into one folder."""

import json
import os
import shutil
from pathlib import Path

from ..program.cli import Problem
from ..program.fingerprint import FILE_NAME as SEAL, write_whole
from ..program.out_folder import claimed
from ..program.registry import FILE_NAME as REGISTRY
from ..results.damage import damage
from .manifest import FILE_NAME as MANIFEST, read_manifest
from .swept_experiment import RESULT_DIRS

SAME_IN_ALL = {"binary_sha256": "another build of the program", "data_sha256": "other data"}


def merge(parts: list[Path], out_dir: Path) -> list[str]:
    """A line for each folder that was left out; the parts stay as they are. Raises Problem where they are not of one
    experiment, build and data, and then writes nothing."""
    folders = [folder for part in parts for folder in _complete(part)]
    _check_plans(parts)
    _check_seals(folders)
    left_out = []
    with claimed(out_dir, *RESULT_DIRS):
        for folder in folders:
            if fault := damage(folder):
                left_out.append(f"{folder}: {fault}; left out, the next run makes it again")
            else:
                _put(folder, out_dir / folder.parent.name / folder.name)
        for name in (MANIFEST, REGISTRY):
            write_whole(out_dir / name, (parts[0] / name).read_text())
    return left_out


def _complete(part: Path) -> list[Path]:
    if not (part / MANIFEST).is_file():
        raise Problem(f"{part}: has no {MANIFEST}; name the --out folder of an experiment")
    return [seal.parent for name in RESULT_DIRS for seal in sorted((part / name).glob(f"*/{SEAL}"))
            if not seal.parent.name.startswith(".")]


def _check_plans(parts: list[Path]) -> None:
    plans = [read_manifest(part) for part in parts]
    for part, plan in zip(parts, plans):
        if [case["name"] for case in plan["cases"]] != [case["name"] for case in plans[0]["cases"]]:
            raise Problem(f"{part}: has other cases planned than {parts[0]}; merge parts of one experiment with the same options")
        if plan.get("settings") != plans[0].get("settings"):
            raise Problem(f"{part}: has other settings than {parts[0]}; merge parts of one experiment with the same options")


def _check_seals(folders: list[Path]) -> None:
    first: dict[str, tuple[str, Path]] = {}
    for folder in folders:
        try:
            seal = json.loads((folder / SEAL).read_text())
        except ValueError:
            continue  # that of a case which is run again
        for key, words in SAME_IN_ALL.items():
            expected, of = first.setdefault(key, (seal.get(key), folder))
            if seal.get(key) != expected:
                raise Problem(f"{folder}: was measured with {words} than {of}; merge parts of one build and data")


def _put(folder: Path, final: Path) -> None:
    """Under a hidden name first. A case that is there, of the same parts merged before, is replaced."""
    hidden = final.parent / f".{final.name}.{os.getpid()}"
    shutil.copytree(folder, hidden)
    shutil.rmtree(final, ignore_errors=True)
    os.replace(hidden, final)
