"""How far a run's figures move when one source of its error is refined and all others stay."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..results.arms import arm_differences
from ..results.force_differences import force_differences
from ..results.ply import read_ply
from ..results.run_folder import Run
from ..results.status import MEASURED

FIGURES = ("shape_mm", "arm_mm", "volume_percent", "surface_mm", "torque_percent", "pressure_percent")
SAME_ORDER = 0.5  # two orders that were seen differ by no more where refining has settled
LEAST_ORDER = 0.5
SETTLING = math.sqrt(2)  # a step is at least so many times shorter than the one before where it has settled without an order
COUNTS = 0.05  # what the finest is off by, as a share of what is told
ROUNDED = 1 + 1e-6  # a half that is one but for rounding


@dataclass(frozen=True, eq=False)
class Setting:
    """One run of a source: how it is set, and that over the scene's own setting."""

    words: str
    factor: float
    run: Run

    @property
    def is_usable(self) -> bool:
        """Went over the whole motion."""
        return self.run.status in MEASURED


@dataclass(frozen=True, eq=False)
class Source:
    """Of one kind of error. `reference` is what the others are compared with: the finest setting, or the exact run."""

    name: str
    settings: list[Setting]  # usable ones, coarse to fine, each from `own` on with twice the factor of the one before
    own: Setting  # that of the scene
    reference: Setting
    nearly: Run | None = None  # the reference with a coarser setting of another source, which it needs finer than the scene has it

    @property
    def is_refined(self) -> bool:
        return self.reference in self.settings and self.reference is not self.own

    def errors(self) -> dict[str, float]:
        """Of the scene's own setting; empty where its run did not end well."""
        return differences(self.own.run, self.reference.run) if self.own.is_usable else {}

    def order(self) -> float:
        """p of an error that falls as 1 / refinement^p; NaN where the last three steps do not agree on one."""
        steps = [math.log2(before / after) for before, after in pairwise(self._steps_mm) if before > 0 and after > 0]
        if not self.is_refined or len(steps) < 2 or abs(steps[-1] - steps[-2]) > SAME_ORDER or steps[-1] < LEAST_ORDER:
            return math.nan
        return steps[-1]

    def has_settled(self) -> bool:
        """Refining further would change little: an order is seen, or the last step is clearly shorter than the one before."""
        steps = self._steps_mm
        return not math.isnan(self.order()) or (len(steps) > 1 and steps[-1] * SETTLING <= steps[-2])

    def left_mm(self) -> float:
        """How far the finest shape is itself from the limit: by Richardson's rule where an order is seen; else its last step, or more
        where steps get shorter by less than a half each. 0 of a reference that is exact."""
        if not self.is_refined:
            return 0.0
        last, order = self._steps_mm[-1], self.order()
        still = shape_mm(self.nearly, self.reference.run) if self.nearly is not None else 0.0
        if not math.isnan(order):
            return still + last / (2**order - 1)
        shorter = last / self._steps_mm[-2] if self.has_settled() and self._steps_mm[-2] > 0 else 0.0
        return still + last * max(1.0, shorter / (1 - shorter))

    def most_mm(self) -> float:
        """The error of the shape, with what the reference is itself off by; NaN where it is not known."""
        return self.errors().get("shape_mm", math.nan) + self.left_mm()

    def halving(self, floor_mm: float = 0.0) -> Setting | None:
        """The first finer setting whose shape has at most half of the error; None where none was run, where refining has not
        settled, and where the error is no more than the floor. The finest itself counts only where an order tells its error."""
        if not self.errors().get("shape_mm", 0.0) > floor_mm or not self.has_settled():
            return None
        finer = [one for one in self.settings if one.factor > self.own.factor and (one is not self.reference or not math.isnan(self.order()))]
        half_mm = ROUNDED * self.most_mm() / 2
        return next((one for one in finer if shape_mm(one.run, self.reference.run) + self.left_mm() <= half_mm), None)

    @property
    def _steps_mm(self) -> list[float]:
        """From each shape to that of the next finer setting, from the scene's own on."""
        from_own = [one for one in self.settings if one.factor >= self.own.factor]
        return [shape_mm(before.run, after.run) for before, after in pairwise(from_own)]


def differences(run: Run, reference: Run) -> dict[str, float]:
    """Those of FIGURES that both runs know: the distance of shapes at full flexion (RMS over the nodes), of moment arms (RMS over
    the motion), the largest difference of the volume in percent of the volume at rest, the difference of the largest depth of
    the surface, and torque and peak pressure in percent of the reference's."""
    found = {"shape_mm": shape_mm(run, reference), "arm_mm": arm_differences(run, reference).get("arm_rms_mm", math.nan),
             "volume_percent": _volume_percent(run, reference), "surface_mm": _surface_mm(run, reference)}
    forces = force_differences(run, reference)
    found |= {f"{what}_percent": forces.get(f"{what}_percent", math.nan) for what in ("torque", "pressure")}
    return {name: value for name, value in found.items() if not math.isnan(value)}


def shape_mm(run: Run, reference: Run) -> float:
    """Root mean square over the nodes; NaN where one of the runs came to an end before full flexion."""
    distances_mm = node_distances_mm(run, reference)
    return math.nan if distances_mm is None else float(np.sqrt(np.mean(distances_mm**2)))


def node_distances_mm(run: Run, reference: Run) -> npt.NDArray[np.float64] | None:
    """Of each node at full flexion that both runs have; None where one of the runs came to an end before, or is of another mesh. The
    vertices of a mesh are the first ones of the same that is split."""
    ours, theirs = flexed(run), flexed(reference)
    if ours is None or theirs is None or len(ours) != len(theirs):
        return None
    if splits_of(run) == splits_of(reference) and any(len(mine) != len(other) for mine, other in zip(ours, theirs)):
        return None
    both = [(mine[:count], other[:count]) for mine, other in zip(ours, theirs) for count in [min(len(mine), len(other))]]
    return np.asarray(np.concatenate([1e3 * np.linalg.norm(mine - other, axis=1) for mine, other in both]))


def splits_of(run: Run) -> int:
    """Of the muscles' triangles."""
    return int((run.record["case"].get("meshes") or {}).get("split_muscles", 0))


def flexed(run: Run) -> list[npt.NDArray[np.float64]] | None:
    """Vertices of each muscle in the first snapshot: that of full flexion. None where the run came to an end before."""
    stored = sorted(run.record.get("snapshots") or [], key=lambda shot: shot["frame"])
    if not stored:
        return None
    ends = np.cumsum([muscle["vertices"] for muscle in run.record.get("muscles") or []])
    return np.split(read_ply(run.folder / stored[0]["file"]).vertices_m, ends[:-1])


def _volume_percent(run: Run, reference: Run) -> float:
    rest_m3 = (reference.record.get("muscle") or {}).get("rest_volume_m3")
    if not rest_m3 or "volume_m3" not in run.frames or "volume_m3" not in reference.frames:
        return math.nan
    frames = min(len(run.frames), len(reference.frames))
    return float(100 * np.abs(run.frames["volume_m3"].to_numpy()[:frames] - reference.frames["volume_m3"].to_numpy()[:frames]).max() / rest_m3)


def _surface_mm(run: Run, reference: Run) -> float:
    if "surface_depth_m" not in run.frames or "surface_depth_m" not in reference.frames:
        return math.nan
    return 1e3 * abs(float(run.frames["surface_depth_m"].max()) - float(reference.frames["surface_depth_m"].max()))


def frame_ms(run: Run) -> float:
    """Median over the frames after the warm-up."""
    counted = run.frames[run.frames["warm_up"] == 0] if "warm_up" in run.frames else run.frames
    return 1e-6 * float(counted["frame_ns"].median()) if len(counted) and "frame_ns" in counted else math.nan


@dataclass(frozen=True, eq=False)
class Budget:
    """Of one scene."""

    scene: str
    muscle: str
    own: Run  # exact, with the scene's own setting
    sources: list[Source]
    floors: list[dict[str, float]]  # what rounding alone changes, by FIGURES; of each start that ended well
    without: Run | None = None  # that finds no collision at all
    missing: tuple[str, ...] = ()  # in words, sources of which no finer run ended well

    @property
    def floor(self) -> dict[str, float]:
        return {name: max(start[name] for start in self.floors if name in start) for name in FIGURES
                if any(name in start for start in self.floors)}

    def times(self, run: Run) -> float:
        """The time of a frame over that of the exact run with the scene's own setting."""
        return frame_ms(run) / frame_ms(self.own)


def in_words(budget: Budget) -> str:
    """Which source is the largest of the shape, the others, what ended badly, and what halving the largest costs."""
    known = sorted((source for source in budget.sources if not math.isnan(source.most_mm())), key=lambda source: -source.most_mm())
    bad = [f"{source.own.words}: {source.own.run.status}" for source in budget.sources if not source.own.is_usable] + list(budget.missing)
    floor = budget.floor.get("shape_mm")
    rounding = f"rounding {floor:.2g} mm" if floor is not None else "rounding not known"
    also = f" Not judged: {'; '.join(bad)}." if bad else ""
    if not known:
        return f"{budget.scene}: no source of error could be told.{also}"
    if floor is not None and known[0].most_mm() <= floor:
        return f"{budget.scene}: no source moves the shape by more than {rounding}.{also}"
    largest, *others = known
    told = "; ".join([*(f"{source.name} {size_in_words(source)}" for source in others), rounding])
    text = f"{budget.scene}: most of the shape's error comes from the {largest.name}: {size_in_words(largest)} with {largest.own.words} ({told}).{also}"
    shape = differences(budget.without, budget.own).get("shape_mm") if budget.without is not None else None
    text += f" Without any collision the shape is {shape:.2g} mm from the exact run's." if shape is not None else ""
    return " ".join([text, *(_halving_in_words(source, budget) for source in known if source.is_refined and source.most_mm() > (floor or 0.0))])


def _halving_in_words(source: Source, budget: Budget) -> str:
    better = source.halving(budget.floor.get("shape_mm", 0.0))
    if better and not math.isnan(price := budget.times(better.run) / budget.times(source.own.run)):
        return f"{better.words.capitalize()} halve the error of the {source.name} for {price:.2g} times the time."
    if source.has_settled():
        return f"No setting that was run halves the error of the {source.name}."
    return f"What halves the error of the {source.name} is not known: refining it has not settled."


def size_in_words(source: Source) -> str:
    return f"{with_rest(source.errors()['shape_mm'], source.left_mm())} mm"


def with_rest(shape_mm: float, left_mm: float) -> str:
    """What a source moves, and behind the sign what its finest setting is itself off by, where that counts."""
    return f"{shape_mm:.2g} ± {left_mm:.2g}" if left_mm > COUNTS * shape_mm else f"{shape_mm:.2g}"
