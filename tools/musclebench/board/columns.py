"""The rows of a bundle: one a configuration of a backend on a scene. Lengths are mm, times of a frame ms."""

import re
from dataclasses import dataclass

from ..results.status import MEANINGS
from ..tables.difficulties import TITLES

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.,:/=+()-]{0,119}")
HASH = re.compile(r"[0-9a-f]{16}")
MOST_CHARACTERS = 500
STATUSES = (*MEANINGS, "missing", "killed")


@dataclass(frozen=True)
class Column:
    name: str
    kind: str  # name, text, status, hash, count, number, flag
    help: str  # with its unit
    is_required: bool = False


COLUMNS = (
    Column("scene", "name", "as `musclebench list` names it, or a file", True),
    Column("backend", "name", "as the program names it", True),
    Column("configuration", "name", "backend with what differs from its defaults", True),
    Column("spoken", "text", "the same as people say it"),
    Column("parameters", "text", "JSON object of what differs from the defaults", True),
    Column("threads", "count", "that the backend used", True),
    Column("series", "text", "the curve over resolutions on which it lies"),
    Column("fineness", "number", "grows with resolution along a curve"),
    Column("status", "status", "of the replay", True),
    Column("detail", "text", "why it is not ok"),
    Column("verdict", "text", "of a backend without a resolution: right, or wrong and why"),
    Column("stride", "count", "every so many-th frame was asked"),
    Column("frames", "count", "that were timed"),
    Column("repetitions", "count", "that ended well"),
    Column("time_ms", "number", "collision time of a frame, at recorded positions: median"),
    Column("time_ms_low", "number", "95 % interval"),
    Column("time_ms_high", "number", "95 % interval"),
    Column("build_s", "number", "time before the first frame, to build its structures"),
    Column("structure_bytes", "count", "memory of its structures"),
    Column("offset_mm", "number", "surface offset: how far its surface is from the true one, 99th percentile over contacts"),
    *(Column(f"{kind}_mm", "number", f"surface offset of contacts of this difficulty: {TITLES[kind]}") for kind in TITLES),
    Column("sites", "count", "places of contact at which the surface offset was measured"),
    Column("open_sites", "count", "of them, places where its surface is farther away than was searched: there it is off by more than is told"),
    Column("true_contacts", "count", "by the Referee, over all frames that were judged"),
    Column("missed_mm", "number", "depth of the deepest contact that it missed"),
    Column("false_mm", "number", "distance of the farthest node that it found wrongly"),
    Column("declared_missed_mm", "number", "no deeper contact is missed, by its own word"),
    Column("declared_false_mm", "number", "no node farther outside is found, by its own word"),
    Column("own_ms", "number", "collision time of a frame where it drives the muscle: median"),
    Column("own_ms_low", "number", "95 % interval"),
    Column("own_ms_high", "number", "95 % interval"),
    Column("arm_mm", "number", "moment arm off by, RMS over the motion"),
    Column("arm_floor_mm", "number", "what rounding does to the arm by itself"),
    Column("pressure_percent", "number", "peak contact pressure off by, RMS"),
    Column("pressure_floor_percent", "number", "what rounding does to it"),
    Column("torque_percent", "number", "joint torque off by, RMS"),
    Column("torque_floor_percent", "number", "what rounding does to it"),
    Column("is_disturbed", "flag", "the machine was busy with something else"),
    Column("queries_hash", "hash", "of all positions that were asked about: the query set"),
    Column("contact_hash", "hash", "of all its answers at them, to the last bit"),
    Column("state_hash", "hash", "of positions and velocities at the end where it drives the muscle"),
)
NAMES = tuple(column.name for column in COLUMNS)
TEXTS = tuple(column.name for column in COLUMNS if column.kind in ("name", "text", "status", "hash"))
NUMBERS = tuple(column.name for column in COLUMNS if column.kind in ("count", "number"))
FLAGS = tuple(column.name for column in COLUMNS if column.kind == "flag")
# What computing the answers again tells, too.
JUDGED = ("sites", "open_sites", "true_contacts", "offset_mm", *(f"{kind}_mm" for kind in TITLES), "missed_mm", "false_mm",
          "declared_missed_mm", "declared_false_mm")
