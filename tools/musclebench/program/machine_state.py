"""What else the machine does while a program runs that doesn't tell it itself: the readings of the program's own runs,
under the same keys of run.json."""

import os
import re
import resource
import time
from dataclasses import dataclass
from pathlib import Path

CPU_INFO, LOAD, MEMORY_EVENTS = Path("/proc/cpuinfo"), Path("/proc/loadavg"), Path("/proc/vmstat")
CPU_FOLDER = Path("/sys/devices/system/cpu")
MHZ_OF_CORE = re.compile(r"^processor\s*:\s*(\d+)$.*?^cpu MHz\s*:\s*([\d.]+)", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Reading:
    """At one moment. Switches are those of all children so far that have ended."""

    ns: int
    involuntary: int
    voluntary: int
    load: float | None
    mhz: float | None
    governor: str | None


def last_core() -> int:
    """On which one case at a time is measured: the first core has the interrupts."""
    return sorted(os.sched_getaffinity(0))[-1]


def oom_kills() -> int:
    """Processes that the system has killed so far for want of memory; 0 where it does not tell."""
    told = dict(line.split() for line in _text(MEMORY_EVENTS).splitlines())
    return int(told.get("oom_kill", 0))


def reading(core: int) -> Reading:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    clocks = {int(number): float(mhz) for number, mhz in MHZ_OF_CORE.findall(_text(CPU_INFO))}
    governor = _text(CPU_FOLDER / f"cpu{core}/cpufreq/scaling_governor").strip()
    load = _text(LOAD).split()
    return Reading(time.monotonic_ns(), usage.ru_nivcsw, usage.ru_nvcsw, float(load[0]) if load else None,
                   clocks.get(core), governor or None)


def told_between(before: Reading, after: Reading) -> dict:
    """For run.json; true of a child only if no other one ended in between."""
    return {"wall_ns": after.ns - before.ns,
            "machine_state": {"involuntary_context_switches": after.involuntary - before.involuntary,
                              "voluntary_context_switches": after.voluntary - before.voluntary,
                              "load_average_1m": {"before": before.load, "after": after.load},
                              "cpu_mhz": {"before": before.mhz, "after": after.mhz}, "governor": after.governor}}


def _text(path: Path) -> str:
    """Empty where the system does not tell."""
    try:
        return path.read_text()
    except OSError:
        return ""


def settings_of(core: int) -> dict:
    """What a time on this core depends on beside the program: set by who runs the machine. None: the system does not tell,
    as virtual machines do not."""
    boost, no_turbo = _text(CPU_FOLDER / "cpufreq/boost").strip(), _text(CPU_FOLDER / "intel_pstate/no_turbo").strip()
    threads = _text(CPU_FOLDER / "smt/active").strip()
    governor = _text(CPU_FOLDER / f"cpu{core}/cpufreq/scaling_governor").strip()
    return {"core": core, "nice": os.nice(0), "governor": governor or None,
            "turbo": boost == "1" if boost else no_turbo == "0" if no_turbo else None,
            "smt": threads == "1" if threads else None}
