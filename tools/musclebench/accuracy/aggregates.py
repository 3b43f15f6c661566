"""One aggregate a configuration of a scene in a mode: its repetitions together, as figures and tables show them."""

import math
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from ..results.records import inner
from ..results.statistics import Estimate, pooled_median
from .cases import StudyCase
from .configurations import Configuration
from ..results.status import MEASURED

NANOSECONDS_TO_MS = 1e-6
ALLOWED_MISSED_SHARE = 0.01
ALLOWED_FALSE_SHARE = 0.01
ALLOWED_P99_OFFSET_MM = 0.1
ANSWER_COUNTS = ("contacts", "true_contacts", "missed_contacts", "false_contacts")
FEWEST_FRAMES = 10  # in which answers are compared


@dataclass
class Aggregate:
    mode: str
    scene: str
    configuration: Configuration
    cases: list[StudyCase]  # by repetition
    coupled: "Aggregate | None" = None  # of a replay: its configuration, or one with the same answers, moving its own muscle

    @property
    def muscle(self) -> str:
        return self.scene.split("/")[-1]

    @property
    def backend(self) -> str:
        return self.configuration.backend

    @cached_property
    def ok(self) -> list[StudyCase]:
        return [case for case in self.cases if case.is_ok]

    @property
    def status(self) -> str:
        """`nondeterministic` too where repetitions gave different answers; `ok` or `suspect` where any repetition is."""
        if any(case.run.status == "nondeterministic" for case in self.cases) or len(self.answers) > 1:
            return "nondeterministic"
        if not self.ok:
            return self.cases[0].run.status
        return "suspect" if any(case.run.status == "suspect" for case in self.ok) else "ok"

    @property
    def detail(self) -> str:
        """Of the first repetition that is not ok; of the answers where each for itself was."""
        if self.status == "ok":
            return ""
        told = [str(case.run.record.get("status_detail") or "") for case in self.cases if case.run.status != "ok"]
        return told[0] if told else "repetitions gave different answers; were they made by one build?"

    @property
    def answers(self) -> set[str]:
        """Hashes of what the repetitions answered."""
        key = "contact_hash" if self.mode == "replay" else "state_hash"
        return {case.run.record[key] for case in self.ok if case.run.record.get(key)}

    @property
    def is_disturbed(self) -> bool:
        """The machine was busy while one of its repetitions ran."""
        return any(case.disturbance for case in self.ok)

    @property
    def is_shown(self) -> bool:
        """Figures and prices show complete and deterministic configurations only."""
        return self.status in MEASURED

    def stage_ms(self, column: str) -> float:
        """Median over the frames without warm-up of all repetitions."""
        parts = [stage_ns(case, column) for case in self.ok]
        return NANOSECONDS_TO_MS * float(pd.concat(parts).median()) if parts else math.nan

    @cached_property
    def collision_ms(self) -> Estimate:
        return pooled_median(list(self.times_ns.values())).scaled(NANOSECONDS_TO_MS)

    @property
    def times_ns(self) -> dict:
        """{repetition: collision time by frame}"""
        return {case.repetition: stage_ns(case, "collision_ns") for case in self.ok}

    def number(self, *keys: str) -> float:
        """Worst over the repetitions of a number of run.json; NaN where none knows it."""
        values = [number(case.run.record, *keys) for case in self.ok]
        return max((value for value in values if not math.isnan(value)), default=math.nan)

    @property
    def structure_bytes(self) -> float:
        return self.number("structure_bytes")

    @property
    def p99_offset_mm(self) -> float:
        """How far the backend's surface is from the true one, 99th percentile over the contacts; of a method that can't be
        asked about single points the depth that its own motion leaves."""
        return self._offset_mm("p99_offset_m", "p99_contact_depth_m")

    @property
    def max_offset_mm(self) -> float:
        return self._offset_mm("max_offset_m", "max_depth_m")

    @property
    def inward_mm(self) -> float:
        """So deep nodes are let in, 99th percentile."""
        return self._offset_mm("p99_inward_m", "p99_contact_depth_m")

    @property
    def outward_mm(self) -> float:
        """So far nodes are held off, 99th percentile; unknown of a method that can't be asked about single points."""
        return 1e3 * self.number("surface_offset", "p99_outward_m")

    @property
    def is_asked(self) -> bool:
        """Whether it was asked about single points, as the surface offset wants."""
        return any(case.run.record.get("surface_offset") for case in self.ok)

    def _offset_mm(self, asked: str, left: str) -> float:
        if self.is_asked or self.coupled is None:
            return 1e3 * self.number("surface_offset", asked)
        return 1e3 * self.coupled.number("outcome", left)

    @property
    def left_mm(self) -> float:
        """Of a replay: the depth of contacts that its own run leaves, 99th percentile; NaN where it has none."""
        return math.nan if self.coupled is None else 1e3 * self.coupled.number("outcome", "p99_contact_depth_m")

    @property
    def held_mm(self) -> float:
        """What a price promises: the offset, or the depth that its own run was seen to leave where that is larger."""
        return math.nan if math.isnan(self.left_mm) else max(self.p99_offset_mm, self.left_mm)

    @property
    def missed_share(self) -> float:
        return share(self.number("accuracy", "missed_contacts"), self.number("accuracy", "true_contacts"))

    @property
    def false_share(self) -> float:
        return share(self.number("accuracy", "false_contacts"), self.number("accuracy", "contacts"))

    @property
    def remaining_depth_mm(self) -> float:
        """99th percentile over a coupled run's frames of the deepest point of the surface, else of the nodes."""
        surface = self.number("outcome", "p99_surface_depth_m")
        return 1e3 * (self.number("outcome", "p99_depth_m") if math.isnan(surface) else surface)

    @property
    def verdict(self) -> str:
        """Of a replay of a method without a resolution: `right`, `wrong: why`, or the status."""
        if not self.is_shown:
            return self.status
        faults = [
            f"{_percent(self.missed_share)} % missed" if self.missed_share > ALLOWED_MISSED_SHARE else "",
            f"{_percent(self.false_share)} % false" if self.false_share > ALLOWED_FALSE_SHARE else "",
            f"{self.p99_offset_mm:.2g} mm off" if self.p99_offset_mm > ALLOWED_P99_OFFSET_MM else "",
        ]
        faults = [fault for fault in faults if fault]
        if faults:
            return "wrong: " + ", ".join(faults)
        return "not judged" if math.isnan(self.p99_offset_mm) else "right"

    @property
    def is_wrong(self) -> bool:
        return self.is_right_or_wrong and self.verdict.startswith("wrong")

    @property
    def is_right_or_wrong(self) -> bool:
        """Methods with a resolution are not wrong but coarse: their error says it."""
        about = self.configuration.about
        return self.mode == "replay" and not about.has_resolution and not about.is_control


def aggregates_of(cases: list[StudyCase]) -> list[Aggregate]:
    """By mode, muscle and configuration, in the order in which tables list them."""
    grouped: dict[tuple, list[StudyCase]] = {}
    for case in cases:
        grouped.setdefault((case.mode, case.scene, case.configuration), []).append(case)
    aggregates = [Aggregate(*key, sorted(group, key=lambda case: case.repetition)) for key, group in grouped.items()]
    _find_coupled(of_mode(aggregates, "replay"), of_mode(aggregates, "coupled"))
    return sorted(aggregates, key=lambda one: (
        one.mode, one.muscle, one.scene, one.configuration.about.index, one.backend, one.configuration.series or "",
        one.configuration.fineness, one.configuration.factors, one.configuration.name,
    ))


def _find_coupled(replays: list[Aggregate], coupled: list[Aggregate]) -> None:
    """Of several configurations of a backend with the same answers a study may drive one only: the others' muscles would
    move alike."""
    own = {(one.scene, one.configuration): one for one in coupled if one.is_shown}
    driven = [(one, own[key]) for one in replays if (key := (one.scene, one.configuration)) in own]
    driven.sort(key=lambda pair: pair[0].configuration.factors)
    for one in replays:
        alike = (run for other, run in driven if other.backend == one.backend and _answer_alike(one, other))
        one.coupled = own.get((one.scene, one.configuration)) or next(alike, None)


def _answer_alike(one: Aggregate, other: Aggregate) -> bool:
    """The same counts of contacts in all frames that both replays have."""
    if one.scene != other.scene or not one.ok or not other.ok:
        return False
    ours, theirs = (aggregate.ok[0].run.frames.set_index("frame") for aggregate in (one, other))
    counts = [key for key in ANSWER_COUNTS if key in ours and key in theirs]
    both = ours[counts].join(theirs[counts], rsuffix="_other", how="inner")
    same = [both[key].equals(both[f"{key}_other"].rename(key)) for key in counts]
    return len(both) >= FEWEST_FRAMES and len(counts) == len(ANSWER_COUNTS) and all(same)


def of_mode(aggregates: list[Aggregate], mode: str) -> list[Aggregate]:
    return [aggregate for aggregate in aggregates if aggregate.mode == mode]


def find(aggregates: list[Aggregate], scene: str, chosen: Configuration) -> Aggregate | None:
    """The one that is complete, of one mode's aggregates."""
    return next((e for e in aggregates if e.scene == scene and e.configuration == chosen and e.is_shown), None)


def exact_aggregate(aggregates: list[Aggregate], scene: str) -> Aggregate | None:
    """Of coupled aggregates: the one that the others' shapes are compared with."""
    exact = [one for one in aggregates if one.scene == scene and one.is_shown and one.configuration.about.is_exact]
    return min(exact, key=lambda one: (one.configuration.factors, one.collision_ms.value), default=None)


def unit_of_price(aggregates: list[Aggregate], aggregate: Aggregate) -> Aggregate | None:
    """What times of the same mode and scene are divided by, where it is complete."""
    return next((one for one in aggregates if one.mode == aggregate.mode and one.scene == aggregate.scene
                 and one.configuration.is_unit_of_price and one.is_shown), None)


def name_of_unit(aggregates: list[Aggregate]) -> str:
    return next((one.configuration.name for one in aggregates if one.configuration.is_unit_of_price), "the unit")


def stage_ns(case: StudyCase, column: str) -> pd.Series:
    """By frame, without warm-up; empty where the run doesn't tell."""
    return case.run.timed_frames.reindex(columns=[column])[column].dropna()


def number(record: dict, *keys: str) -> float:
    """A number inside of a record; NaN where it is unknown."""
    value = inner(record, *keys)
    return math.nan if value is None or isinstance(value, (str, dict, list)) else float(value)


def _percent(value: float) -> str:
    return f"{100 * value:.1f}" if value < 0.0995 else f"{100 * value:.0f}"


def share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else (0.0 if part == 0 else math.nan)
