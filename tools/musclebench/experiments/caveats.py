"""What stands with every table of a study whose cases are not all of one program, or whose motion is squeezed."""

import json
from collections import Counter
from pathlib import Path

from ..program.fingerprint import FILE_NAME as SEAL
from .earlier import FRAMES_LIMIT, earlier_plan


def caveats(out_dir: Path) -> str:
    """Empty for a study as it should be."""
    plan = earlier_plan(out_dir)
    return " ".join(filter(None, [_squeezed(plan), _programs(out_dir, plan)]))


def _squeezed(plan: dict) -> str:
    frames = (plan.get("settings") or {}).get(FRAMES_LIMIT)
    return f"A quick look: the whole motion is squeezed into {frames} frames, so that bones move faster." if frames else ""


def _programs(out_dir: Path, plan: dict) -> str:
    counts = Counter(program for case in plan.get("cases", []) if (program := _program_of(out_dir / "raw" / case["name"])))
    if len(counts) < 2:
        return ""
    told = ", ".join(f"{count} of {git} (binary {digest[:8]})" for (git, digest), count in counts.items())
    return f"Cases of {len(counts)} programs, whose times and answers may differ: {told}."


def _program_of(folder: Path) -> tuple[str, str] | None:
    """Its version and digest; none where a case has no result."""
    try:
        digest = json.loads((folder / SEAL).read_text())["binary_sha256"]
        build = json.loads((folder / "run.json").read_text()).get("build") or {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return str(build.get("git", "an unknown version")), digest
