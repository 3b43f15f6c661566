"""The rows of the table: what is measured, the target that it has to take, and whether it does."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import pandas as pd

from ..accuracy.configurations import configuration
from ..program.registry import Registry
from ..results import samples
from ..results.disturbance import MARK
from ..results.run_folder import Run
from ..results.statistics import Estimate, paired_ratio
from ..results.status import MEASURED
from .bars import Setting, settings, targets, timed_groups
from .kernel_results import Kernels

MOST_SETUP = 0.2  # of the CPU time of a run of some hundred frames, the Referee's included
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
    is_disturbed: bool = False  # the machine was busy with something else while it was measured

    @property
    def remark(self) -> str:
        """The note as it is printed."""
        return (self.note + MARK if self.is_disturbed else self.note).strip()

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
    disturbed: dict[str, str] = field(default_factory=dict)  # why the machine was too busy, by the folder of a run


def rows(measured: Measured, registry: Registry) -> list[Row]:
    """A row for each race against the unit of price, one for what a run costs before its first frame, and one for each
    target of the backends' studies."""
    raced = settings(registry)
    unit = next((setting for setting in raced if setting.is_unit), None)
    races = [_race(measured, setting, unit, registry) for setting in raced if unit and setting != unit]
    timed = timed_groups()
    return [*races, *_setup_rows(measured), *(_kernel_row(measured, told, timed) for told in targets(registry))]


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
    return Row(what, target, at_most, at_least, chosen.measured, note, parts, chosen.is_disturbed)


def _in_words(told: dict) -> str:
    limits = [f"<= {told['at_most']:g}" if "at_most" in told else "", f">= {told['at_least']:g}" if "at_least" in told
              else "", f"aim {told['aim']:g}" if "aim" in told else ""]
    return ", ".join(limit for limit in limits if limit)


def _race(measured: Measured, setting: Setting, unit: Setting, registry: Registry) -> Row:
    names = [configuration(registry.backend(one.backend), dict(one.parameters)).name for one in (setting, unit)]
    told = {key: value for key, value in (("at_most", setting.at_most), ("aim", setting.aim)) if value is not None}
    return worst(f"collision time, {' / '.join(names)}", _race_parts(measured, setting.label, unit.label),
                 _in_words(told), at_most=setting.at_most)


def _race_parts(measured: Measured, label: str, unit: str) -> list[Row]:
    """A row a muscle: update + detect + respond over the unit's, frame by frame of the same round."""
    raced = [run for run in measured.runs if run.mode == "coupled" and not run.record["case"]["judged"]]
    parts = []
    for muscle in dict.fromkeys(run.muscle for run in raced):
        of_muscle = [run for run in raced if run.muscle == muscle]
        times = {name: {_round(run): run.timed_frames["collision_ns"] for run in of_muscle
                        if label_of(run) == name and run.status in MEASURED} for name in (label, unit)}
        row = Row(f"{label} / {unit}", measured=paired_ratio(times[label], times[unit]), note=muscle)
        failed = [run for run in of_muscle if label_of(run) == label and run.status not in MEASURED]
        if not row.is_known and failed:
            row.note = failed[0].record.get("status_detail") or failed[0].status
        row.is_disturbed = _any_disturbed(measured, [run for run in of_muscle if label_of(run) in (label, unit)])
        parts.append(row)
    return parts


def _setup_rows(measured: Measured) -> list[Row]:
    """CPU time before the first frame over that of the whole run: of the largest muscle, whose loop is the longest, a
    part for each setting. Of a judged run, as a user starts it, but that fields are loaded; and of one that is not
    judged, less the backend's structures."""
    ran = [run for run in measured.runs if run.mode == "coupled" and run.status in MEASURED and "cpu_ns" in run.record]
    nodes = {run.muscle: run.record["muscle"]["nodes"] for run in ran}
    largest = max(nodes, key=nodes.get, default="")

    def parts(judged: bool, left_out: tuple[str, ...]) -> list[Row]:
        of_label: dict[str, list[Run]] = {}
        for run in ran:
            if run.muscle == largest and run.record["case"]["judged"] == judged:
                of_label.setdefault(label_of(run), []).append(run)
        return [Row(f"set-up / run, {label}", note=f"{label}, {largest}", is_disturbed=_any_disturbed(measured, found),
                    measured=samples.median(pd.Series([_setup_share(run, left_out) for run in found])))
                for label, found in of_label.items()]

    return [worst("CPU before the first frame / of a judged run whose fields are stored, largest muscle", parts(True, ()),
                  f"<= {MOST_SETUP:g}", at_most=MOST_SETUP),
            worst("CPU before the first frame, less structures / of a run without the Referee", parts(False, ("build_ns",)),
                  "")]


def _setup_share(run: Run, left_out: tuple[str, ...]) -> float:
    cpu = run.record["cpu_ns"]
    return (cpu["before_first_frame"] - sum(run.record[key] for key in left_out)) / cpu["after_last_frame"]


def _any_disturbed(measured: Measured, runs: list[Run]) -> bool:
    return any(run.folder.name in measured.disturbed for run in runs)


def label_of(run: Run) -> str:
    """The setting's, which the folder's name holds: SCENE-LABEL-rN."""
    name = run.folder.name.rpartition("-r")[0].removesuffix("-judged")
    return name.removeprefix(f"{run.scene.replace('/', '-')}-").removeprefix(f"{run.muscle_alone}-")


def _round(run: Run) -> int:
    return int(run.folder.name.rpartition("-r")[2])


def _kernel_row(measured: Measured, told: dict, timed: set[str]) -> Row:
    measure = {"ratio": _ratio, "value": _value, "power": _power}[told["kind"]]
    parts = measure(measured.kernels, told)
    if not any(part.is_known or part.note.startswith(NOT_BUILT) for part in parts):
        parts = [Row(told["group"], note=measured.refusals.get(told["group"], NOT_MEASURED))]
    of_group = [run for run in measured.runs if run.mode == "kernels" and run.record["case"]["group"] == told["group"]]
    for part in parts:
        part.is_disturbed = told["group"] in timed and _any_disturbed(measured, of_group)
    return worst(told["what"], parts, _in_words(told), told.get("at_most"), told.get("at_least"))


def _names(kernels: Kernels, pattern: str) -> list[str]:
    """What {} stands for in the names of the kernels that measured something."""
    prefix, _, suffix = pattern.partition("{}")
    return [name.removeprefix(prefix).removesuffix(suffix) for name in kernels.names(prefix) if name.endswith(suffix)]


def _ratio(kernels: Kernels, told: dict) -> list[Row]:
    """Of two kernels of one process, sample by sample; a row for each name that both patterns hold."""
    above, below, counter = told["kernel"], told["below"], told["counter"]
    rows_of_names = []
    for name in _names(kernels, above) if "{}" in above else [""]:
        over, under = above.replace("{}", name), below.replace("{}", name)
        value = samples.ratio(kernels.of(over, counter, told["group"]),
                              kernels.of(under, told.get("below_counter", counter), told["group"]))
        rows_of_names.append(Row(f"{over} / {under}", measured=value, note=name))
    return rows_of_names


def _value(kernels: Kernels, told: dict) -> list[Row]:
    pattern, found = told["kernel"], []
    for name in _names(kernels, pattern):
        taken = kernels.of(pattern.replace("{}", name), told["counter"])
        value = samples.exact(taken.iloc[0]) if len(taken) == 1 else samples.median(taken)
        found.append(Row(pattern.replace("{}", name), measured=value.scaled(told.get("scale", 1.0)), note=name))
    problems = [Row(name, note=f"{NOT_BUILT}: {text}") for name, text in kernels.problems.items()
                if name.startswith(pattern.partition("{}")[0])]
    return found or problems


def _power(kernels: Kernels, told: dict) -> list[Row]:
    """Exponent of the size, or of its logarithm, that the time grows with."""
    of_size: Callable[[float], float] = math.log if told.get("of_logarithm") else float
    pattern = told["kernel"]
    sizes = sorted(int(name) for name in _names(kernels, pattern))
    times = {of_size(size): kernels.of(pattern.replace("{}", str(size)), told["counter"]) for size in sizes}
    return [Row(pattern.removesuffix("/{}"), measured=samples.power(times))]
