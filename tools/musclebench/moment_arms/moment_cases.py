"""The cases of the moment arms: each muscle, passive and active, is turned from rest to both ends of the joint's range."""

from dataclasses import dataclass

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene

PRESET = "standard"
ENDS_DEG = (-10.0, 90.0)
DEGREES_A_FRAME = 2.0
SHORTENING = 0.5  # of free fibres: active force ends at half of their best length (Gordon, Huxley, Julian 1966; Zajac 1989)
# Before the joint turns. Passive: what overlaps as the meshes are is laid apart. Active: the muscle has contracted to where it
# balances; with 500 the iliacus' arm at 0 degrees is still 17 mm too large.
SETTLE_SUBSTEPS = {False: 100, True: 2000}
SHOWN_DEG = (0, 45, 90)  # of the pictures
SUBSTEPS_A_FRAME = 10  # of the preset, near enough for a guess
SECONDS_A_FRAME = 0.3  # of the reference muscle, with its fibres: a first guess, which the progress bar corrects


@dataclass(frozen=True)
class MomentCase(SceneCase):
    scene: Scene
    backend: str
    to_deg: float
    fibres: int
    degrees_a_frame: float = DEGREES_A_FRAME
    activation: float = 0.0  # its level; 0: passive

    @property
    def name(self) -> str:
        return f"{self.scene.key}-to={self.to_deg:g}" + (f"-active={self.activation:g}" if self.activation else "")

    @property
    def kind(self) -> str:
        return "moment_arms"

    @property
    def frames(self) -> int:
        """Three at least: a slope takes as many."""
        return max(3, round(abs(self.to_deg) / self.degrees_a_frame))

    @property
    def guessed_seconds(self) -> float:
        settling = SETTLE_SUBSTEPS[bool(self.activation)] / SUBSTEPS_A_FRAME
        return 4.0 + SECONDS_A_FRAME * self.scene.size * (self.frames + settling)

    @property
    def snapshot_frames(self) -> list[int]:
        """Those nearest to the angles that are shown."""
        share = [degrees / self.to_deg for degrees in SHOWN_DEG]
        return sorted({round(self.frames * part) for part in share if 0 <= part <= 1})

    def arguments(self, folders: Folders) -> list[str]:
        return ["run", self.scene.name, "--backend", self.backend, *self.scene.preset_arguments(), "--threads", "1",
                "--effects", "auto", "--motion", "course=there", "--motion", f"to_deg={self.to_deg!r}",
                "--frames", str(self.frames), "--fibres", str(self.fibres), *self._effects(),
                "--loop", f"settle_substeps={SETTLE_SUBSTEPS[bool(self.activation)]}",
                "--snapshots", ",".join(map(str, self.snapshot_frames)), *self.scene.data_arguments(folders)]

    def _effects(self) -> list[str]:
        """From before the first frame on: a muscle that takes up its tension while it is turned has lengths of both."""
        told = f"activation:level={self.activation!r},shortening={SHORTENING!r},rise_s=0.0"
        return ["--effect", told] if self.activation else []

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "preset": self.scene.preset, "backend": self.backend,
                "parameters": {}, "threads": 1}


def plan(scenes: list[Scene], backend: str, fibres: int, degrees_a_frame: float, activation: float) -> list[MomentCase]:
    """Passive and active; the longest first, so that none runs alone at the end."""
    cases = [MomentCase(scene, backend, end, fibres, degrees_a_frame, level) for scene in scenes for end in ENDS_DEG
             for level in dict.fromkeys((0.0, activation))]
    return sorted(cases, key=lambda case: -case.guessed_seconds)
