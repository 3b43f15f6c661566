"""Runs in space: bones, and the muscle at every moment that a run kept, with the depth of each node."""

import math
import sys
from dataclasses import dataclass, field

import numpy as np

from ..results.ply import read_ply
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_snapshots
from .scene_data import Sight, scene_data

BUDGET_CHARACTERS = 7_000_000  # of all moments of a folder
FEWEST_OF_A_NODE = 0.5  # characters of its positions and depth at a moment
MANY_MOMENTS = 500  # take more than two seconds
WORDS = (
    "Drag to turn. Press + and -, or turn the wheel with Ctrl or after a click, to zoom. All runs share one camera. Keyboard: arrow "
    "keys turn, 0 shows the first view, space plays. Click on a node for its depth in a bone (by the Referee) and its distance "
    "from the nearest bone (by the meshes shown). Positions are rounded to 0.03 mm. Colours show the depth of nodes, or the depth "
    "of the deepest surface point near each node: a bone can cut through a face whose corners are all outside. Bound nodes have no "
    "depth."
)

Cases = dict[tuple[str, str], Run]  # {(muscle, backend): run}


@dataclass
class Views:
    """All scenes of a folder; meshes that scenes share are kept once. Of the moments that runs kept, those that fit."""

    title: str
    cases: Cases = field(default_factory=dict)
    sight: Sight | None = None
    scenes: list[dict] = field(default_factory=list)
    meshes: dict[str, dict] = field(default_factory=dict)
    stride: int = 1  # every so many moments
    name: str = "view"
    kind_of_part: str = "views"

    @property
    def words(self) -> str:
        """What one sees, and what was left out."""
        if self.stride == 1:
            return WORDS
        return (f"{WORDS} Runs kept up to {self.most_moments} moments. The page shows {_ordinal(self.stride)}, the moment of the largest angle "
                "and the last, to stay below 10 MB. tools/report --export vtk has all.")

    @property
    def data(self) -> dict:
        """As tools/page/view.js reads it."""
        return {"scenes": self.scenes, "meshes": self.meshes}

    @property
    def characters(self) -> int:
        return sum(len(text) for scene in self.scenes for run in scene["runs"]
                   for text in (run["positions"], *(depths["text"] for depths in run["depths"].values())))

    @property
    def most_moments(self) -> int:
        return max((len(run.record["snapshots"]) for run in self.cases.values()), default=0)

    def fit(self, characters: float) -> None:
        """Leaves out moments until positions and depths have no more characters, as long as three moments are left."""
        while self.characters > characters and self.most_moments > 3 * self.stride:
            # Moments farther apart differ more, so that this never leaves out too many.
            self.pack(max(self.stride + 1, math.floor(self.stride * self.characters / characters)))

    def pack(self, stride: int) -> None:
        shots = {case: _shots(run, stride) for case, run in self.cases.items()}
        shots = {case: kept for case, kept in shots.items() if kept}
        self.stride, self.scenes, self.meshes = stride, [], {}
        for muscle in dict.fromkeys(muscle for muscle, _ in shots):
            mine = {backend: kept for (other, backend), kept in shots.items() if other == muscle}
            self.scenes.append(scene_data(muscle, {backend: self.cases[muscle, backend] for backend in mine}, mine, self.meshes, self.sight))


def views_of(cases: Cases, title: str, sight: Sight | None = None) -> Views:
    """Of the cases with snapshots; a scene a muscle. `sight`: by default that of Fig. 6, from where the muscle lies on its
    bones."""
    views = Views(title, {case: run for case, run in cases.items() if run.record.get("snapshots")}, sight)
    moments = sum(len(run.record["snapshots"]) for run in views.cases.values())
    if moments > MANY_MOMENTS:
        print(f"Packing {moments} shapes for the page (up to a minute) ...", file=sys.stderr, flush=True)
    views.pack(max(1, _fewest_characters(views.cases) // BUDGET_CHARACTERS))
    views.fit(BUDGET_CHARACTERS)
    return views


def fit_together(views: list[Views], less: int) -> None:
    """Leaves out moments of the views of one page until they have so many characters less."""
    total = sum(one.characters for one in views)
    for one in views:
        one.fit(max(1.0, one.characters * (1 - less / total)))


def _shots(run: Run, stride: int) -> list[Snapshot]:
    shots = read_snapshots(run, kept_moments(run, stride))
    for shot in shots[1:]:
        if np.array_equal(shot.mesh.triangles, shots[0].mesh.triangles):
            shot.mesh.triangles = shots[0].mesh.triangles  # hundreds of the same fill gigabytes
    return shots


def kept_moments(run: Run, stride: int) -> list[dict]:
    """Of the record's snapshots every so many; the one that is turned farthest and the last always stay."""
    entries = sorted(run.record["snapshots"], key=lambda entry: entry["frame"])
    farthest = max(range(len(entries)), key=lambda index: abs(entries[index]["angle_deg"] - entries[0]["angle_deg"]))
    return [entries[index] for index in sorted({*range(0, len(entries), stride), farthest, len(entries) - 1})]


def _fewest_characters(cases: Cases) -> int:
    """Of all moments: no muscle that moves takes fewer, so that what surely does not fit is not read."""
    return math.floor(FEWEST_OF_A_NODE * sum(len(run.record["snapshots"]) * _nodes(run) for run in cases.values()))


def _nodes(run: Run) -> int:
    return len(read_ply(run.folder / run.record["snapshots"][0]["file"]).vertices_m)


def _ordinal(number: int) -> str:
    return "every second" if number == 2 else f"every {number}th" if number != 3 else "every third"
