"""The muscles that experiments are about, and the motion that all of them go through."""

from dataclasses import dataclass, replace

from .case import Places

VERTICES = {"adductor_brevis": 502, "gluteus_maximus": 9878, "gluteus_medius": 5313, "iliacus": 6931}
REFERENCE_NODES = VERTICES["iliacus"]  # of the muscle that guessed times are of
PAPER_FRAMES = 314  # 157 of 0.573 degrees to full flexion, and back
PRESET = "paper"
ITERATIONS_A_FRAME = 3  # of the preset


@dataclass(frozen=True)
class MuscleScene:
    """What all cases of a muscle share: the scene and how much of its motion."""

    data_set: str  # synthetic or lhdl
    muscle: str
    frames_limit: int | None = None  # None: as many as the preset has
    probed_on: str = ""  # the muscle whose scene is probed; the bones are those of the data set. Empty: this one

    @property
    def name(self) -> str:
        return f"{self.data_set}/{self.muscle}"

    @property
    def probed(self) -> "MuscleScene":
        return replace(self, muscle=self.probed_on or self.muscle)

    @property
    def frames(self) -> int:
        return self.frames_limit or PAPER_FRAMES

    @property
    def full_flexion_frame(self) -> int:
        """Any number of frames is the whole motion, there and back."""
        return self.frames // 2

    @property
    def steps(self) -> int:
        return ITERATIONS_A_FRAME * self.frames

    @property
    def nodes(self) -> int:
        return VERTICES[self.muscle]

    @property
    def size(self) -> float:
        """Nodes over those of the reference muscle."""
        return self.nodes / REFERENCE_NODES

    def data_arguments(self, places: Places) -> list[str]:
        return ["--data", str(places.data_dir)] if places.data_dir is not None else []

    def frames_arguments(self) -> list[str]:
        return ["--frames", str(self.frames_limit)] if self.frames_limit is not None else []
