"""Which sections a folder of results, or a history, gives. A new kind of results is a row here."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..figures import looks
from ..program.cli import Problem
from ..program.registry import FILE_NAME, saved_registry
from ..results.run_folder import ResultProblem
from .accuracy_part import accuracy_section, is_accuracy
from .effects_part import effects_section, is_effects
from .hard_part import hard_section, is_hard
from .history_part import history_section, is_history
from .moment_arms_part import is_moment_arms, moment_arms_section
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
    Kind("tools/moment-arms", is_moment_arms, moment_arms_section),
    Kind("tools/nightly", is_history, history_section),
)
OF_RUNS = Kind("musclebench run", is_runs, runs_section)  # of a folder that is nothing else


def sections_of(folders: list[Path]) -> list[Section]:
    """In the order of the folders, each a folder of results or the file of a history. What can't be read is a section that says
    so. Raises Problem for a folder that holds no results, and where nothing at all can be read."""
    made: list[Section] = []
    for folder in folders:
        kinds = [kind for kind in KINDS if kind.is_there(folder)] or [kind for kind in (OF_RUNS,) if kind.is_there(folder)]
        if not kinds:
            raise Problem(f"{folder}: holds no results of {', '.join(kind.name for kind in (*KINDS, OF_RUNS))}; name the --out "
                          "folder of one of these commands")
        _know_looks(folder)
        made += [_section(kind, folder) for kind in kinds]
    if all(section.is_left_out for section in made):
        raise Problem(made[0].problems[0])
    return _apart(made)


def _section(kind: Kind, folder: Path) -> Section:
    try:
        return kind.section(folder)
    except (Problem, ResultProblem) as problem:
        return Section("left-out", f"Left out: results of {kind.name}", [], [str(problem)], [], {}, folder, is_left_out=True)


def _know_looks(folder: Path) -> None:
    """From the registry beside the results, or beside the folder `raw` that a run lies in."""
    for place in (folder, folder.resolve().parent.parent):
        if (place / FILE_NAME).is_file():
            looks.know(saved_registry(place))
            return


def _apart(sections: list[Section]) -> list[Section]:
    """Links and titles that tell sections of one kind apart."""
    names = [section.name for section in sections]
    for number, section in enumerate(sections):
        if names.count(section.name) > 1:
            section.title += f" ({section.folder.name})"
            section.name += f"-{number + 1}"
    return sections
