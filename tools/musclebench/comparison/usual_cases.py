"""What is compared and followed where nobody names cases."""

from dataclasses import dataclass, replace
from pathlib import Path

from ..program.cli import Problem
from ..program.registry import Registry

SMALL_SCENE, LARGE_SCENE = "hard/resting_contact", "synthetic/iliacus"
USUAL_FRAMES = 20


@dataclass(frozen=True)
class What:
    """A case without its repetitions."""

    scene: str
    backend: str
    frames: int
    parameters: tuple[tuple[str, object], ...] = ()
    preset: str = ""
    repetitions: int = 10
    counted_frames: int = 0  # by callgrind; 0: not counted
    is_judged: bool = True
    seconds: float = 3.0  # of one process, guessed

    @property
    def name(self) -> str:
        words = [f"{key}={value}" for key, value in self.parameters]
        return "-".join([Path(self.scene).stem, self.backend, *words])


def usual_cases(registry: Registry, repetitions: int) -> list[What]:
    """All backends on a small scene, whose frames are shorter than the scheduler's slices, and those that are not too slow
    for it on a muscle of the synthetic hip."""
    known, wanted = {scene.name for scene in registry.scenes}, []
    for backend in registry.backends:
        is_slow = "longest_stride" in backend.study
        if SMALL_SCENE in known:
            wanted.append(What(SMALL_SCENE, backend.name, 12 if is_slow else 60, repetitions=repetitions,
                               counted_frames=3 if is_slow else 6, seconds=0.6))
        if LARGE_SCENE in known and not is_slow:
            wanted.append(What(LARGE_SCENE, backend.name, 16, preset="paper", repetitions=repetitions, seconds=3.0))
    return wanted


def chosen_cases(registry: Registry, repetitions: int, scenes: list[str] | None = None, backends: list[str] | None = None,
                 frames: int | None = None) -> list[What]:
    """The usual ones, or of these scenes and backends."""
    for backend in backends or []:
        if not registry.has(backend):
            raise Problem(f"--backend {backend}: not a backend of the program; there are: {', '.join(registry.names)}")
    known = [scene.name for scene in registry.scenes]
    for scene in scenes or []:
        if scene not in known and not (scene.endswith(".toml") and Path(scene).is_file()):
            raise Problem(f"--scene {scene}: neither a scene of the program nor a .toml file")
    wanted = usual_cases(registry, repetitions)
    if scenes:
        names = [str(Path(scene).resolve()) if scene not in known else scene for scene in scenes]
        usual = {(what.scene, what.backend): what for what in wanted}
        wanted = [usual.get((scene, backend.name), What(scene, backend.name, USUAL_FRAMES, repetitions=repetitions))
                  for scene in dict.fromkeys(names) for backend in registry.backends]
    wanted = [what for what in wanted if not backends or what.backend in backends]
    return [replace(what, frames=frames) for what in wanted] if frames else wanted
