"""What is compared of a run: times, counters, and answers that have to be the same."""

from dataclasses import dataclass

import pandas as pd

from ..results.ply import read_ply, rms_distance_m
from ..results.run_folder import Run
from ..results.status import MEASURED

TIME, COUNTER, EXACT = "time", "counter", "exact"
SMALLEST = {TIME: 0.05, COUNTER: 0.01, EXACT: 0.0}  # relative change that counts
SHORTEST_NS = 2000.0  # a shorter time is that of reading the clock
FEWEST_FRAMES = 5
WAITED = "involuntary_switches"  # column: times that the scheduler took the core away while the frame was timed


@dataclass(frozen=True)
class Metric:
    name: str
    kind: str
    unit: str = ""
    what: str = ""

    @property
    def is_deterministic(self) -> bool:
        """A counter that the same program counts alike each time; of the CPU's counter one run tells little."""
        return self.kind == COUNTER and self.name != "process_instructions"

    @property
    def smallest(self) -> float:
        return SMALLEST[self.kind]


METRICS = {metric.name: metric for metric in (
    Metric("collision_ns", TIME, "ns", "collision of a frame, of those that nothing interrupted"),
    Metric("frame_ns", TIME, "ns", "a frame of the loop, of those that nothing interrupted"),
    Metric("cpu_ns", TIME, "ns", "CPU time of a frame, mean over all frames: waiting does not count"),
    Metric("build_ns", TIME, "ns", "building the structures"),
    Metric("instructions", COUNTER, "", "in all frames of the loop, by callgrind"),
    Metric("collision_instructions", COUNTER, "", "of them in update, detection and response"),
    Metric("constraint_instructions", COUNTER, "", "of them in the projection of constraints"),
    Metric("process_instructions", COUNTER, "", "of the whole process in user space, by the CPU's counter"),
    Metric("structure_bytes", COUNTER, "bytes", "of the structures"),
    Metric("contacts", COUNTER, "", "answered, over all frames"),
    Metric("status", EXACT, "", "how the run ended"),
    Metric("state_hash", EXACT, "", "of all positions and velocities at the end"),
    Metric("contact_hash", EXACT, "", "of all contacts of a replay"),
    Metric("p99_depth_m", EXACT, "m", "99th percentile of the depth; of a replay of the error of depth"),
    Metric("max_depth_m", EXACT, "m", "largest depth; of a replay largest error of depth"),
    Metric("p99_surface_depth_m", EXACT, "m", "99th percentile over the frames of the deepest point of the surface"),
    Metric("max_surface_depth_m", EXACT, "m", "the deepest of them"),
    Metric("return_to_rest_m", EXACT, "m", "RMS distance of the nodes at the end of the rest from where they began"),
    Metric("moment_arm_m", EXACT, "m", "median over the frames of the mean moment arm of the fibres"),
    Metric("missed_contacts", EXACT, "", "true ones that were not answered"),
    Metric("false_contacts", EXACT, "", "answered ones that are not true"),
    Metric("verdict", EXACT, "", "of a cell of the matrix of hard cases"),
)}


def values_of(run: Run, measured: dict | None = None) -> dict[str, float | str]:
    """{metric: value} of what the run tells; for its frames' times see frame_times. `measured`: what was noted beside it,
    such as counted instructions; a run that counting slowed tells nothing else."""
    measured = measured or {}
    found: dict[str, float | str | None] = {} if measured.get("is_slowed") else {"status": run.status}
    if run.status in MEASURED:
        found |= measured.get("counters", {})
        if not measured.get("is_slowed"):
            found |= _answers(run) | _times(run) | {"structure_bytes": run.record.get("structure_bytes"),
                                                    "contacts": _sum(run.frames, "contacts")}
    return {name: value for name, value in found.items() if name in METRICS and value is not None and not pd.isna(value)}


def quiet_frames(run: Run) -> pd.DataFrame:
    """Timed frames during which the process kept its core; all timed ones where the program does not tell."""
    timed = run.timed_frames
    return timed[timed[WAITED] == 0] if WAITED in timed and timed[WAITED].notna().any() else timed


def _times(run: Run) -> dict[str, float | None]:
    """Of a judged run none: the Referee leaves colder caches, and its own time is in that of the process."""
    if run.record["case"].get("judged"):
        return {}
    cpu, frames = run.record.get("cpu_ns") or {}, run.record.get("frames")
    found: dict[str, float | None] = {"build_ns": run.record.get("build_ns")}
    if frames and {"before_first_frame", "after_last_frame"} <= cpu.keys():
        found["cpu_ns"] = (cpu["after_last_frame"] - cpu["before_first_frame"]) / frames
    return {name: value for name, value in found.items() if value is not None and value >= SHORTEST_NS}


def _answers(run: Run) -> dict[str, float | str | None]:
    outcome, offset = run.record.get("outcome") or {}, run.record.get("surface_offset") or {}
    return {"state_hash": run.record.get("state_hash"), "contact_hash": run.record.get("contact_hash"),
            "p99_depth_m": offset.get("p99_offset_m", outcome.get("p99_depth_m")),
            "max_depth_m": offset.get("max_offset_m", outcome.get("max_depth_m")),
            **{key: outcome.get(key) for key in ("p99_surface_depth_m", "max_surface_depth_m")},
            "return_to_rest_m": _return_to_rest_m(run),
            "moment_arm_m": run.fibres["mean_moment_arm_m"].median() if len(run.fibres) else None,
            "missed_contacts": _sum(run.frames, "missed_contacts"), "false_contacts": _sum(run.frames, "false_contacts")}


def _return_to_rest_m(run: Run) -> float | None:
    """Of a run that rested after its motion, and kept its first and last shape."""
    rested = (run.record["case"].get("loop") or {}).get("rest_frames")
    shots = {shot["frame"]: run.folder / shot["file"] for shot in run.record.get("snapshots") or []}
    last = run.record.get("frames")
    if not rested or not {0, last} <= shots.keys():
        return None
    return rms_distance_m(read_ply(shots[last]), read_ply(shots[0]))


def _sum(frames: pd.DataFrame, column: str) -> float | None:
    return frames[column].sum(min_count=1) if column in frames else None
