"""experiment.json: what an experiment was asked for, its cases, and where it ran."""

import json
from datetime import datetime, timezone
from pathlib import Path

from ..cases.case import Case
from ..program.machine import machine
from ..program.fingerprint import file_digest, write_whole
from ..results.run_folder import ResultProblem
from .experiment_file import ExperimentFile
from .swept_case import SweptCase

FILE_NAME = "experiment.json"


def write_manifest(out_dir: Path, file: ExperimentFile, cases: list[Case], command_line: list[str],
                   settings: dict[str, str]) -> None:
    """`cases`: of the whole experiment, whichever part of it runs here. `settings`: see earlier.py."""
    told = {
        "schema_version": 1, "experiment": file.name, "title": file.title, "file_sha256": file_digest(file.path),
        "seed": file.seed, "repetitions": file.repetitions, "machine": machine(), "command_line": command_line,
        "settings": settings,
        "started": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "cases": [planned(case) for case in cases if isinstance(case, SweptCase)],
    }
    write_whole(out_dir / FILE_NAME, json.dumps(told, indent=1) + "\n")


def planned(case: SweptCase) -> dict:
    return {"name": case.name, "group": case.group.name, **case.record(), "axes": {one.axis: one.value for one in case.point},
            "stride": case.stride, "guessed_seconds": round(case.guessed_seconds, 1), "is_too_long": case.is_too_long}


def read_manifest(out_dir: Path) -> dict:
    path = out_dir / FILE_NAME
    try:
        told = json.loads(path.read_text())
        if told["schema_version"] != 1 or not isinstance(told["cases"], list):
            raise ValueError(f"schema version {told['schema_version']}, these tools read 1")
        return told
    except OSError as problem:
        raise ResultProblem(f"{path}: can't be read ({problem.strerror}); it is written when an experiment starts") from None
    except (ValueError, KeyError, TypeError) as problem:
        raise ResultProblem(f"{path}: not the plan of an experiment ({problem}); start the experiment again") from None
