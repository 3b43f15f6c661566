"""Instructions, which noise does not touch: by the CPU's own counter where the system allows it (perf_event_open(2)), else
by callgrind, under which a program is some fifty times slower."""

import ctypes
import os
import platform
import re
import shutil
import struct
from pathlib import Path

SYSCALL = {"x86_64": 298, "aarch64": 241}
HARDWARE, INSTRUCTIONS = 0, 1  # perf_event_attr: type and config
SOFTWARE, TASK_CLOCK = 1, 1
ATTRIBUTE_BYTES = 112  # of version 5 of the structure; older kernels take it where the rest is zero
DISABLED, INHERIT, NO_KERNEL, NO_HYPERVISOR, ENABLE_ON_EXEC = 1 << 0, 1 << 1, 1 << 5, 1 << 6, 1 << 12
# The loop only: reading, building and writing take some per cent more or less from run to run.
COUNTED = "musclebench::Simulation::step_frame(*"
CALLGRIND_FILE = "callgrind.out"
CPU_INFO = Path("/proc/cpuinfo")
TOTALS = re.compile(r"^(?:totals|summary): (\d+)", re.MULTILINE)
# Of the loop: 10 % of a part may be less than 1 % of the whole. Each is called from the loop only, and none within another.
PARTS = {
    "collision_instructions": ("musclebench::Simulation::find_contacts(", "musclebench::Simulation::respond("),
    "constraint_instructions": ("musclebench::Simulation::project(",),
}
CALLED = re.compile(r"^cfn=\((\d+)\)(?: (.*))?$")
NAMED = re.compile(r"^fn=\((\d+)\)(?: (.*))?$")


class NotCounted(Exception):
    """Why the system does not count, in one line."""


class ChildCounter:
    """What the children that are started from now on count, once they have ended. Not of this process."""

    def __init__(self, kind: int = HARDWARE, event: int = INSTRUCTIONS):
        number = SYSCALL.get(platform.machine())
        if number is None:
            raise NotCounted(f"perf_event_open is not known here on {platform.machine()}")
        attribute = bytearray(ATTRIBUTE_BYTES)
        struct.pack_into("IIQQQQQ", attribute, 0, kind, ATTRIBUTE_BYTES, event, 0, 0, 0,
                         DISABLED | INHERIT | NO_KERNEL | NO_HYPERVISOR | ENABLE_ON_EXEC)
        library = ctypes.CDLL(None, use_errno=True)
        self._file = library.syscall(number, ctypes.c_char_p(bytes(attribute)), 0, -1, -1, ctypes.c_ulong(8))  # close on exec
        if self._file < 0:
            raise NotCounted(f"perf_event_open: {os.strerror(ctypes.get_errno())}{_advice()}")

    def read(self) -> int:
        """Ends the count."""
        value, = struct.unpack("q", os.read(self._file, 8))
        os.close(self._file)
        return value


def why_not_by_cpu() -> str:
    """Empty where the CPU's counter can be read."""
    try:
        ChildCounter().read()
    except NotCounted as problem:
        return str(problem)
    return ""


def why_not_by_callgrind() -> str:
    if not shutil.which("valgrind"):
        return "valgrind is missing; tools/setup --all installs it"
    if platform.machine() == "x86_64" and not _processor_has("rdtscp"):
        # Highway reads the clock as it is loaded, and valgrind knows that instruction only where the processor has it.
        return "valgrind cannot run the program on a processor without rdtscp; take another machine"
    return ""


def _processor_has(flag: str) -> bool:
    """Also where nobody tells."""
    try:
        flags = re.search(r"^flags\s*:(.*)$", CPU_INFO.read_text(), re.MULTILINE)
    except OSError:
        return True
    return flags is None or flag in flags.group(1).split()


def callgrind_prefix(folder: Path) -> list[str]:
    """In front of a command; the counts go into the folder."""
    return ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / CALLGRIND_FILE}", "--collect-atstart=no",
            f"--toggle-collect={COUNTED}"]


def read_callgrind(folder: Path) -> dict[str, int]:
    """{counter: instructions} of the loop and of its parts; without those of which nothing was counted: a program without the
    function, or without its name."""
    try:
        text = (folder / CALLGRIND_FILE).read_text(errors="replace")
    except OSError:
        return {}
    total = TOTALS.search(text)
    calls = _inclusive(text)
    parts = {part: sum(cost for name, cost in calls.items() if name.startswith(names)) for part, names in PARTS.items()}
    return {name: count for name, count in ({"instructions": int(total.group(1)) if total else 0} | parts).items() if count}


def _inclusive(text: str) -> dict[str, int]:
    """{function: instructions of all calls of it, with what it calls}. The second line after a call has its cost; a name
    stands at the number's first use, wherever that is."""
    names: dict[str, str] = {}
    found: dict[str, int] = {}
    called, is_cost = "", False
    for line in text.splitlines():
        if line.startswith(("cfn=", "fn=")) and (match := CALLED.match(line) or NAMED.match(line)):
            names.setdefault(match.group(1), match.group(2) or "")
            if line.startswith("cfn="):
                called = match.group(1)
        elif line.startswith("calls="):
            is_cost = True
        elif is_cost:
            found[called] = found.get(called, 0) + int(line.split()[1])
            is_cost = False
    by_name: dict[str, int] = {}
    for number, cost in found.items():
        by_name[names[number]] = by_name.get(names[number], 0) + cost
    return by_name


def _advice() -> str:
    try:
        level = int(Path("/proc/sys/kernel/perf_event_paranoid").read_text())
    except (OSError, ValueError):
        return ""
    if level > 2 and os.geteuid() != 0:
        return f" (kernel.perf_event_paranoid is {level}; 2 allows it)"
    return "; a virtual machine often has no counter" if not list(Path("/sys/bus/event_source/devices").glob("cpu*")) else ""
