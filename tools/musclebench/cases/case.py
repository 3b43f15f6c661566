"""What the pool, the progress bar and the fingerprint know of a case, whatever its experiment is."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Folders:
    """Folders that a command line names and that may differ between machines."""

    out_dir: Path
    data_dir: Path | None = None  # None: no anatomical data are wanted
    structures_dir: Path | None = None  # shared with other experiments; None: each has its own, in out_dir

    def symbolic(self) -> "Folders":
        """Stands for these folders in a fingerprint, so that results may be moved and merged. Where structures are kept
        changes no answer."""
        return Folders(Path("OUT"), Path("DATA") if self.data_dir else None)


class Case(ABC):
    """One process to run. Cases are hashable and have names of their own."""

    threads: int = 1
    needs: tuple[str, ...] = ()  # names of cases that must have ended before this one starts

    @property
    @abstractmethod
    def name(self) -> str: ...

    @property
    @abstractmethod
    def kind(self) -> str:
        """Cases of a kind are slower or faster than guessed by about the same factor."""

    @property
    @abstractmethod
    def guessed_seconds(self) -> float: ...

    @abstractmethod
    def arguments(self, folders: Folders) -> list[str]:
        """Of `musclebench`, without the output: all that the result depends on."""

    @abstractmethod
    def record(self) -> dict:
        """`case` of the run.json of a case that left none."""

    @property
    def wants_machine(self) -> bool:
        """It runs while nothing else does."""
        return self.threads > 1

    @property
    def folder(self) -> str:
        """Of the results, below the experiment's."""
        return f"raw/{self.name}"

    def input_digests(self) -> dict[str, str]:
        """Of files beside the program and the data that its result depends on, by name."""
        return {}

    def output(self, folder: Path) -> list[str]:
        """Arguments that make `musclebench` write into `folder`."""
        return ["--out", str(folder), "--progress"]


class SceneCase(Case):
    """A case with a `scene`, which may be a file."""

    def input_digests(self) -> dict[str, str]:
        return {"scene_sha256": self.scene.digest} if self.scene.digest else {}
