"""What machine this is."""

import os
import platform
from pathlib import Path


def machine() -> dict:
    return {"cpu": _cpu(), "cores": len(os.sched_getaffinity(0)), "memory_bytes": total_memory_bytes(),
            "system": platform.platform(), "python": platform.python_version()}


def total_memory_bytes() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())
