"""The cases of the convergence study: one scene with more and more substeps in a frame of the same time."""

from dataclasses import dataclass

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene
from ..program.cli import Problem
from ..program.registry import Backend, Registry

PRESET = "standard"
SECONDS_A_SUBSTEP = 0.003  # of the reference muscle: a first guess, which the progress bar corrects


@dataclass(frozen=True)
class ConvergenceCase(SceneCase):
    scene: Scene
    backend: str
    substeps: int

    @property
    def name(self) -> str:
        return f"{self.scene.key}-substeps={self.substeps}"

    @property
    def kind(self) -> str:
        return "substeps"

    @property
    def guessed_seconds(self) -> float:
        return 2.0 + SECONDS_A_SUBSTEP * self.scene.size * self.scene.frames * self.substeps

    @property
    def snapshot_frames(self) -> list[int]:
        return sorted({self.scene.full_flexion_frame, self.scene.frames})

    def arguments(self, folders: Folders) -> list[str]:
        return ["run", self.scene.name, "--backend", self.backend, *self.scene.preset_arguments(), "--threads", "1",
                "--loop", f"substeps={self.substeps}",
                "--loop", f"time_step_s={self.scene.frame_time_s / self.substeps!r}",
                "--snapshots", ",".join(map(str, self.snapshot_frames)), *self.scene.data_arguments(folders),
                *self.scene.frames_arguments()]

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "preset": self.scene.preset, "backend": self.backend,
                "parameters": {}, "threads": 1, "loop": {"substeps": self.substeps}}


def plan(scenes: list[Scene], backend: str, counts: list[int]) -> list[ConvergenceCase]:
    """The longest first, so that none runs alone at the end."""
    cases = [ConvergenceCase(scene, backend, count) for scene in scenes for count in counts]
    return sorted(cases, key=lambda case: -case.guessed_seconds)


def usual_backend(registry: Registry) -> Backend:
    """An exact one, so that substeps are all that differs; one with a clearance cache, since that is fast."""
    exact = [backend for backend in registry.backends if backend.is_exact]
    cached = [backend for backend in exact if backend.of_role("clearance_cache")]
    return (cached or exact or list(registry.backends))[0]


def backend_of(wanted: str | None, registry: Registry) -> str:
    if wanted and not registry.has(wanted):
        raise Problem(f"--backend {wanted}: not built; there are: {', '.join(registry.names)}")
    return wanted or usual_backend(registry).name
