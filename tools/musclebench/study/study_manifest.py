"""study.json: what a study was asked for, what it planned and where it ran."""

import json
import os
import platform
from datetime import datetime, timezone
from pathlib import Path

from ..program.fingerprint import write_whole
from .study_cases import MeasuredCase, ReplayCase
from .study_plan import StudyCase, Request, is_too_long

FILE_NAME = "study.json"


def write_manifest(out_dir: Path, request: Request, plan: list[StudyCase], command_line: list[str]) -> None:
    """`cases` are those of the whole study, whichever part of it runs here."""
    study = {
        "schema_version": 1, "data_set": request.data_set, "scenes": [scene.name for scene in request.scenes],
        "quick": request.quick,
        "repetitions": request.repetitions, "band_m": request.band_mm * 1e-3, "seed": request.seed,
        "frames_limit": request.frames_limit, "machine": machine(), "command_line": command_line,
        "started": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "cases": [_planned(case) for case in plan if isinstance(case, MeasuredCase)],
    }
    write_whole(out_dir / FILE_NAME, json.dumps(study, indent=1) + "\n")


def machine() -> dict:
    return {"cpu": _cpu(), "cores": len(os.sched_getaffinity(0)), "memory_bytes": total_memory_bytes(),
            "system": platform.platform(), "python": platform.python_version()}


def total_memory_bytes() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _planned(case: MeasuredCase) -> dict:
    more = {"stride": case.stride} if isinstance(case, ReplayCase) else {}
    return {"name": case.name, **case.record(), **more, "guessed_seconds": round(case.guessed_seconds, 1),
            "is_too_long": is_too_long(case)}


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())
