"""The cases of the speed table: coupled runs of configurations, and groups of Google Benchmark kernels."""

from dataclasses import dataclass
from pathlib import Path

from ..cases.case import Folders, SceneCase
from ..cases.scene import Scene

STRUCTURES_DIR = "structures"  # of the distance fields, below the experiment's folder: built once, loaded by all
KERNELS_FILE = "kernels.json"
MICRO_PROGRAM = "musclebench_micro"
JUDGED_TIMES = 8.0  # what a run takes with the Referee
FRAMES_A_SECOND = 100.0  # of the loop without collision, at the reference


@dataclass(frozen=True)
class Setting:
    """One backend as it is raced."""

    label: str
    backend: str
    parameters: tuple[tuple[str, object], ...] = ()
    step_ms: float = 0.1  # guessed, at the reference
    storage: str = ""  # the parameter that says where structures are kept; empty: they are not
    at_most: float | None = None  # times the unit of price
    aim: float | None = None
    is_unit: bool = False


@dataclass(frozen=True)
class RaceCase(SceneCase):
    """A coupled run on one thread: without the Referee, or as a user starts it, for what such a run costs in all."""

    scene: Scene
    setting: Setting
    repetition: int = 0
    is_judged: bool = False

    @property
    def name(self) -> str:
        return f"{self.scene.key}-{self.setting.label}{'-judged' if self.is_judged else ''}-r{self.repetition}"

    @property
    def kind(self) -> str:
        return f"race {self.setting.label}"

    @property
    def guessed_seconds(self) -> float:
        a_frame = 1 / FRAMES_A_SECOND + self.scene.iterations * self.setting.step_ms * 1e-3
        return 2.0 + self.scene.size * self.scene.frames * a_frame * (JUDGED_TIMES if self.is_judged else 1)

    def arguments(self, folders: Folders) -> list[str]:
        words = ["run", self.scene.name, "--backend", self.setting.backend, *self.scene.preset_arguments(),
                 "--threads", "1", "--repetition", str(self.repetition)]
        words += [] if self.is_judged else ["--no-referee"]
        for key, value in self.setting.parameters:
            words += ["--param", f"{key}={value}"]
        if self.setting.storage:
            words += ["--param", f"{self.setting.storage}={folders.out_dir / STRUCTURES_DIR}"]
        return [*words, *self.scene.data_arguments(folders), *self.scene.frames_arguments()]

    def record(self) -> dict:
        return {"mode": "coupled", "scene": self.scene.name, "preset": self.scene.preset,
                "backend": self.setting.backend, "parameters": dict(self.setting.parameters), "threads": 1,
                "repetition": self.repetition}


@dataclass(frozen=True)
class KernelGroup:
    """Kernels that run in one process, their repetitions in random order among each other."""

    name: str
    seconds: float  # guessed
    pattern: str = ""  # regular expression of the kernels' names
    quick_sizes: tuple[int, ...] = ()  # of kernels of growing size, with --quick
    threads: int = 1
    scene_key: str = ""  # of the scene that the kernels measure, where it is among those asked for
    other_scene: str = ""  # or one of the same data set that is not raced
    varies: bool = True  # False: bytes and counts, which are the same in every repetition
    program: str = MICRO_PROGRAM  # or one beside it, which is only built where its library is installed


@dataclass(frozen=True)
class KernelCase(SceneCase):
    scene: Scene
    group: KernelGroup
    repetition: int = 0
    repetitions_inside: int = 5  # of each kernel, in the process
    least_seconds: float = 0.2  # of each of those

    @property
    def name(self) -> str:
        return f"kernels-{self.group.name}-r{self.repetition}"

    @property
    def kind(self) -> str:
        return f"kernels {self.group.name}"

    @property
    def threads(self) -> int:
        return self.group.threads

    @property
    def guessed_seconds(self) -> float:
        return self.group.seconds

    def environment(self, folders: Folders) -> list[str]:
        """Assignments of the variables that tell the kernels what to measure."""
        words = [f"MUSCLEBENCH_MICRO_SCENE={self.scene.name}",
                 f"MUSCLEBENCH_MICRO_STRUCTURES={folders.out_dir / STRUCTURES_DIR}"]
        return words + ([f"MUSCLEBENCH_DATA={folders.data_dir}"] if folders.data_dir is not None else [])

    def arguments(self, folders: Folders) -> list[str]:
        if not self.group.varies:
            return [f"--benchmark_filter={self.group.pattern}"]
        return [f"--benchmark_filter={self.group.pattern}", f"--benchmark_repetitions={self.repetitions_inside}",
                f"--benchmark_min_time={self.least_seconds}", "--benchmark_enable_random_interleaving=true",
                "--benchmark_report_aggregates_only=false"]

    def output(self, folder: Path) -> list[str]:
        return [f"--benchmark_out={folder / KERNELS_FILE}", "--benchmark_out_format=json"]

    def record(self) -> dict:
        return {"mode": "kernels", "scene": self.scene.name, "group": self.group.name, "threads": self.threads,
                "repetition": self.repetition}
