"""How far a run's figures move when one source of its error is refined and all others stay."""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..results.arms import arm_differences
from ..results.force_differences import force_differences
from ..results.ply import read_ply
from ..results.run_folder import Run

FIGURES = ("shape_mm", "arm_mm", "volume_percent", "surface_mm", "torque_percent", "pressure_percent")
SAME_ORDER = 0.5  # two orders that were seen differ by no more where refining has settled
LEAST_ORDER = 0.5
ROUNDED = 1 + 1e-6  # a half that is one but for rounding


@dataclass(frozen=True)
class Setting:
    """One run of a source: how it is set, and that over the scene's own setting."""

    words: str
    factor: float
    run: Run


@dataclass(frozen=True)
class Source:
    """Of one kind of error. `finest` is what the others are compared with: the last setting, or the exact run."""

    name: str
    settings: list[Setting]  # coarse to fine
    own: Setting  # that of the scene
    finest: Run

    @property
    def is_refined(self) -> bool:
        return self.settings[-1].run is self.finest and len(self.settings) > 1

    def errors(self) -> dict[str, float]:
        """Of the scene's own setting."""
        return differences(self.own.run, self.finest)

    def order(self) -> float:
        """p of an error that falls as 1 / refinement^p; NaN where the last three steps do not agree on one."""
        steps = [math.log2(before / after) for before, after in zip(self._steps_mm, self._steps_mm[1:]) if before > 0 and after > 0]
        if not self.is_refined or len(steps) < 2 or abs(steps[-1] - steps[-2]) > SAME_ORDER or steps[-1] < LEAST_ORDER:
            return math.nan
        return steps[-1]

    def left_mm(self) -> float:
        """How far the finest shape is itself from the limit: by Richardson's rule where an order is seen, else its last step.
        0 of a reference that is exact."""
        if not self.is_refined:
            return 0.0
        last, order = (self._steps_mm or [math.nan])[-1], self.order()
        return last if math.isnan(order) else last / (2**order - 1)

    def halving(self) -> Setting | None:
        """The first finer setting whose shape has at most half of the error; None where none was run. The finest itself counts
        only where an order tells its error."""
        own, left = self.errors().get("shape_mm", math.nan), self.left_mm()
        finer = [one for one in self.settings if one.factor > self.own.factor and (one.run is not self.finest or not math.isnan(self.order()))]
        return next((one for one in finer if differences(one.run, self.finest).get("shape_mm", math.inf) + left <= ROUNDED * (own + left) / 2), None)

    @property
    def _steps_mm(self) -> list[float]:
        """From each shape to that of the next finer setting, as far as each doubles the one before."""
        from_own = [one for one in self.settings if one.factor >= self.own.factor]
        return [shape_mm(before.run, after.run) for before, after in zip(from_own, from_own[1:])]


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
    ours, theirs = flexed(run), flexed(reference)
    if ours is None or theirs is None or ours.shape != theirs.shape:
        return math.nan
    return 1e3 * float(np.sqrt(np.mean(np.sum((ours - theirs) ** 2, axis=1))))


def flexed(run: Run) -> npt.NDArray[np.float64] | None:
    """Vertices in the first snapshot: that of full flexion. None where the run came to an end before."""
    stored = sorted(run.record.get("snapshots") or [], key=lambda shot: shot["frame"])
    return read_ply(run.folder / stored[0]["file"]).vertices_m if stored else None


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


@dataclass
class Budget:
    """Of one scene."""

    scene: str
    muscle: str
    sources: list[Source]
    floor: dict[str, float] = field(default_factory=dict)  # what rounding alone changes, by FIGURES

    def largest(self) -> Source:
        return max(self.sources, key=lambda source: source.errors().get("shape_mm", -1.0))


def in_words(budget: Budget, names: dict[str, str]) -> str:
    """One sentence on the shape, another on how to halve what is largest. `names`: of the sources, for a reader."""
    errors = sorted(((source.errors()["shape_mm"], source) for source in budget.sources if "shape_mm" in source.errors()),
                    key=lambda pair: -pair[0])
    if not errors:
        return f"{budget.scene}: no shape of it is known."
    floor = budget.floor.get("shape_mm", 0.0)
    (most, largest), others = errors[0], errors[1:]
    if most <= floor:
        return f"{budget.scene}: no source moves the shape by more than rounding does ({floor:.2g} mm)."
    told = ", ".join(f"{names[source.name]} {error:.2g} mm" for error, source in others)
    text = f"{budget.scene}: most of the shape's error comes from the {names[largest.name]}: {most:.2g} mm with {largest.own.words}"
    text += f" ({told}; rounding {floor:.2g} mm)." if told else f" (rounding {floor:.2g} mm)."
    if better := largest.halving():
        text += f" {better.words.capitalize()} halve it for {frame_ms(better.run) / frame_ms(largest.own.run):.2g} times the time."
    elif largest.is_refined:
        text += " No setting that was run halves it."
    return text
