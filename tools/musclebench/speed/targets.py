"""The rows of the table: what is measured, the target that it has to take, and whether it does."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from ..results.run_folder import Run
from ..results.statistics import Estimate, paired_ratio

from . import samples
from .kernel_results import Kernels
from .speed_plan import REFERENCE

MEGABYTE = 1e6
# A fit over real caches is never exactly linear or logarithmic.
LARGEST_POWER = 1.1
NOT_BUILT, NOT_MEASURED = "not built", "not measured"


@dataclass
class Row:
    """One line of the table, or one of the measurements that its line is the worst of."""

    what: str
    target: str = ""  # as it is printed; empty: for information
    at_most: float | None = None
    at_least: float | None = None
    measured: Estimate = field(default_factory=Estimate.unknown)
    note: str = ""  # of which muscle or bone; or why there is no number
    parts: list["Row"] = field(default_factory=list)

    @property
    def is_known(self) -> bool:
        return not math.isnan(self.measured.value)

    @property
    def held(self) -> str:
        """By the median; the interval is printed beside it."""
        if not self.is_known or (self.at_most is None and self.at_least is None):
            return ""
        above = self.at_least is None or self.measured.value >= self.at_least
        below = self.at_most is None or self.measured.value <= self.at_most
        return "yes" if above and below else "no"


@dataclass
class Measured:
    """What the rows are made from."""

    runs: list[Run]
    kernels: Kernels
    refusals: dict[str, str]  # why a group of kernels was not run


def rows(measured: Measured) -> list[Row]:
    return [*_races(measured), *_queries(measured), *_fields(measured), *_embree(measured), *_threads(measured),
            *_sizes(measured), _allocations(measured)]


def worst(what: str, parts: list[Row], target: str, at_most: float | None = None, at_least: float | None = None,
          reason: str = NOT_MEASURED) -> Row:
    """The part that is farthest from its target, for all."""
    for part in parts:
        part.target, part.at_most, part.at_least = target, at_most, at_least
    known = [part for part in parts if part.is_known]
    if not known:
        reasons = [part.note for part in parts if part.note]
        return Row(what, target, at_most, at_least, note=reasons[0] if reasons else reason, parts=parts)
    chosen = max(known, key=lambda part: part.measured.value if at_least is None else -part.measured.value)
    missing = [part for part in parts if not part.is_known]
    note = chosen.note if len(parts) > 1 else ""
    note += f"; {len(missing)} of {len(parts)} missing" if missing else ""
    return Row(what, target, at_most, at_least, chosen.measured, note, parts)


def _races(measured: Measured) -> list[Row]:
    return [
        worst("collision time, bvh / voxel 64", _race(measured, "bvh"), "<= 2, aim 1", at_most=2),
        worst("collision time, sdf 64 / voxel 64", _race(measured, "sdf"), "<= 1.5, aim 1", at_most=1.5),
        worst("collision time, fcl node_distance / voxel 64", _race(measured, "fcl"), "<= 20", at_most=20),
        worst("the same without clearance cache: bvh", _race(measured, "bvh-cold"), ""),
        worst("the same without clearance cache: sdf 64", _race(measured, "sdf-cold"), ""),
    ]


def _race(measured: Measured, label: str) -> list[Row]:
    """A row a muscle: update + detect + respond over the reference's, frame by frame of the same round."""
    raced = [run for run in measured.runs if run.mode == "coupled"]
    rows_of_muscles = []
    for muscle in dict.fromkeys(run.muscle for run in raced):
        of_muscle = [run for run in raced if run.muscle == muscle and label_of(run) in (label, REFERENCE)]
        mine = [run for run in of_muscle if label_of(run) == label]
        times = {name: {_round(run): run.timed_frames["collision_ns"] for run in of_muscle
                        if label_of(run) == name and run.status == "ok"} for name in (label, REFERENCE)}
        row = Row(f"{label} / {REFERENCE}", measured=paired_ratio(times[label], times[REFERENCE]), note=muscle)
        failed = [run for run in mine if run.status != "ok"]
        if not row.is_known and failed:
            row.note = _reason(failed[0])
        rows_of_muscles.append(row)
    return rows_of_muscles


def label_of(run: Run) -> str:
    """The setting's, which the folder's name holds: MUSCLE-LABEL-rN."""
    return run.folder.name.removeprefix(f"{run.muscle}-").rpartition("-r")[0]


def _round(run: Run) -> int:
    return int(run.folder.name.rpartition("-r")[2])


def _reason(run: Run) -> str:
    return run.record.get("status_detail") or run.status


def _queries(measured: Measured) -> list[Row]:
    return [
        worst("sdf value + gradient / voxel test, near points, float",
              _ratios(measured, "queries", "sdf_value_and_gradient/float/{}", "voxel_test/{}", "ns_a_point"), "<= 5",
              at_most=5),
        worst("sdf build per node / cold closest point of bvh near",
              _ratios(measured, "build", "sdf_build_a_node/{}", "bvh_locate/near/{}", "ns_a_node",
                      "ns_a_point"), "<= 0.3", at_most=0.3),
    ]


def _ratios(measured: Measured, group: str, above: str, below: str, counter: str, counter_below: str = "") -> list[Row]:
    """A row for each name that both patterns hold."""
    kernels = measured.kernels
    prefix, _, suffix = above.partition("{}")
    names = [name.removeprefix(prefix).removesuffix(suffix) for name in kernels.names(prefix) if name.endswith(suffix)]
    found = []
    for name in names:
        measured_ratio = samples.ratio(kernels.of(above.format(name), counter, group),
                                       kernels.of(below.format(name), counter_below or counter, group))
        found.append(Row(f"{above.format(name)} / {below.format(name)}", measured=measured_ratio, note=name))
    return [row for row in found if row.is_known] or _why_not(measured, group)


def _why_not(measured: Measured, group: str) -> list[Row]:
    return [Row(group, note=measured.refusals.get(group, NOT_MEASURED))]


def _fields(measured: Measured) -> list[Row]:
    return [
        worst("MB of sdf 64 float, dense, a bone", _bytes(measured, "dense/float"), "<= 7.7", at_most=7.7),
        worst("MB of sdf 64 float, narrow band 10 mm, a bone", _bytes(measured, "band_10mm/float"), "<= 2", at_most=2),
        worst("the same compact instead of float: dense", _bytes(measured, "dense/compact"), ""),
        worst("the same compact instead of float: narrow band 10 mm", _bytes(measured, "band_10mm/compact"), ""),
        worst("adaptive sdf, p99 error 0.05 mm: bytes / uniform grid's", _adaptive(measured, "bytes_ratio"), "<= 0.25",
              at_most=0.25),
        worst("adaptive sdf, p99 error 0.05 mm: build time / uniform grid's", _adaptive(measured, "build_ratio"),
              "<= 0.25", at_most=0.25),
    ]


def _bytes(measured: Measured, storage: str) -> list[Row]:
    kernels, prefix = measured.kernels, f"sdf_bytes/{storage}/"
    found = [Row(name, measured=samples.exact(kernels.of(name, "bytes").iloc[0] / MEGABYTE),
                 note=name.removeprefix(prefix)) for name in kernels.names(prefix)]
    problems = [Row(name, note=f"{NOT_BUILT}: {text}") for name, text in kernels.problems.items()
                if name.startswith(prefix)]
    return found or problems or _why_not(measured, "bytes")


def _adaptive(measured: Measured, counter: str) -> list[Row]:
    kernels = measured.kernels
    found = [Row(name, measured=samples.median(kernels.of(name, counter)), note=name.rpartition("/")[2])
             for name in kernels.names("adaptive")]
    return [row for row in found if row.is_known] or _why_not(measured, "adaptive")


def _embree(measured: Measured) -> list[Row]:
    # Near the surface in the order of the muscle's nodes, far from it anywhere: as the peers were measured.
    places = {"near": "near/coherent", "far": "far/random"}
    return [worst(f"Embree's point query / cold bvh with sign, {name}",
                  _ratios_at(measured, place), ">= 3", at_least=3) for name, place in places.items()]


def _ratios_at(measured: Measured, place: str) -> list[Row]:
    kernels = measured.kernels
    value = samples.ratio(kernels.of(f"embree/{place}", "real_ns"), kernels.of(f"signed/{place}", "real_ns"))
    row = Row(f"embree/{place} / signed/{place}", measured=value)
    return [row] if row.is_known else _why_not(measured, "embree")


def _threads(measured: Measured) -> list[Row]:
    detections = {f"detect of all nodes, {name}": f"detect_threads/{name}/{{}}" for name in ("bvh", "sdf")}
    builds = {f"sdf build, {bone}": f"sdf_build_threads/{bone}/{{}}" for bone in _built_bones(measured.kernels)}
    found = [worst(f"two threads over one, {what}", [_speed_up(measured, what, kernel)], ">= 1.7", at_least=1.7)
             for what, kernel in detections.items()]
    parts = [_speed_up(measured, what, kernel) for what, kernel in builds.items()]
    return [*found, worst("two threads over one, sdf build", parts or _why_not(measured, "two_threads"), ">= 1.7",
                          at_least=1.7)]


def _built_bones(kernels: Kernels) -> list[str]:
    return sorted({name.split("/")[1] for name in kernels.names("sdf_build_threads/")})


def _speed_up(measured: Measured, what: str, kernel: str) -> Row:
    one, two = (measured.kernels.of(kernel.format(count), "real_ns", "two_threads") for count in (1, 2))
    row = Row(f"two threads, {what}", measured=samples.ratio(one, two), note=what)
    return row if row.is_known else _why_not(measured, "two_threads")[0]


def _sizes(measured: Measured) -> list[Row]:
    muscles, reference = ([_power(measured, f"muscle_size/{name}", "real_ns", lambda nodes: nodes) for name in names]
                          for names in (("bvh", "sdf"), (REFERENCE,)))
    located = _power(measured, "bone_size/bvh_locate", "ns_a_point", math.log)
    stepped = _power(measured, "bone_size/bvh_step", "real_ns", math.log)
    return [
        worst("power of the muscle's nodes that a step costs", muscles, f"<= {LARGEST_POWER}, linear",
              at_most=LARGEST_POWER),
        worst("the same of voxel, whose nodes come from memory, too", reference, ""),
        worst("power of log(triangles) that a cold query of bvh costs", [located],
              f"<= {LARGEST_POWER}, logarithmic", at_most=LARGEST_POWER),
        worst("power of log(triangles) that a step of bvh costs", [stepped], f"<= {LARGEST_POWER}, logarithmic",
              at_most=LARGEST_POWER),
    ]


def _power(measured: Measured, kernel: str, counter: str, of_size: Callable[[float], float]) -> Row:
    kernels, group = measured.kernels, kernel.split("/")[0]
    sizes = sorted(int(name.rpartition("/")[2]) for name in kernels.names(f"{kernel}/"))
    times = {of_size(size): kernels.of(f"{kernel}/{size}", counter) for size in sizes}
    row = Row(kernel, measured=samples.power(times), note=kernel.partition("/")[2])
    return row if row.is_known else _why_not(measured, group)[0]


def _allocations(measured: Measured) -> Row:
    kernels, prefix = measured.kernels, "allocations/"
    parts = [Row(name, measured=samples.exact(kernels.of(name, "allocations").iloc[0]), note=name.removeprefix(prefix))
             for name in kernels.names(prefix)]
    return worst("heap allocations in a frame after the second", parts or _why_not(measured, "allocations"), "0",
                 at_most=0)
