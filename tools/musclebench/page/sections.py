"""Which sections a folder of results gives. A new kind of results, such as a history of nights, is a row here."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..figures import looks
from ..program.cli import Problem
from ..program.registry import FILE_NAME, saved_registry
from .accuracy_part import accuracy_section, is_accuracy
from .effects_part import effects_section, is_effects
from .hard_part import hard_section, is_hard
from .paper_part import is_paper, paper_section
from .parts import Section
from .runs_part import is_runs, runs_section


@dataclass(frozen=True)
class Kind:
    name: str
    is_there: Callable[[Path], bool]
    section: Callable[[Path], Section]


KINDS = (
    Kind("tools/paper", is_paper, paper_section),
    Kind("tools/accuracy", is_accuracy, accuracy_section),
    Kind("tools/effects", is_effects, effects_section),
    Kind("tools/hard", is_hard, hard_section),
)
OF_RUNS = Kind("musclebench run", is_runs, runs_section)  # of a folder that is nothing else


def sections_of(folders: list[Path]) -> list[Section]:
    """In the order of the folders. Raises Problem for a folder that holds no results."""
    made: list[Section] = []
    for folder in folders:
        kinds = [kind for kind in KINDS if kind.is_there(folder)] or [kind for kind in (OF_RUNS,) if kind.is_there(folder)]
        if not kinds:
            raise Problem(f"{folder}: holds no results of {', '.join(kind.name for kind in (*KINDS, OF_RUNS))}; name the folder that "
                          "such a command wrote (its --out)")
        _know_looks(folder)
        made += [kind.section(folder) for kind in kinds]
    return _apart(made, folders)


def _know_looks(folder: Path) -> None:
    """From the registry beside the results, or beside the folder `raw` that a run lies in."""
    for place in (folder, folder.resolve().parent.parent):
        if (place / FILE_NAME).is_file():
            looks.know(saved_registry(place))
            return


def _apart(sections: list[Section], folders: list[Path]) -> list[Section]:
    """Links and titles that tell sections of one kind apart."""
    names = [section.name for section in sections]
    for number, section in enumerate(sections):
        if names.count(section.name) > 1:
            section.title += f" ({section.folder.name})"
            section.name += f"-{number + 1}"
    return sections
