"""Words of --shape: in which way the members of a population differ. Imports nothing but Python's own library."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

from ..program.cli import Problem

MOST_MEMBERS = 100_000
MODES = 5  # of correspondence meshes, those that explain most
KINDS = {  # {kind: (numbers that a member draws, largest amount, unit)}
    "size": (1, 100.0, "percent"), "scale": (3, 100.0, "percent"), "bend": (2, 60.0, "degrees"), "twist": (1, 90.0, "degrees"),
    "modes": (MODES, 4.0, "standard deviations"),
}
WORDS = re.compile(r"(\w+)=([^@:]+)(?:@([\w.-]+))?(?::(.+))?")


@dataclass(frozen=True)
class Shape:
    """One way in which members differ."""

    kind: str  # of KINDS
    amount: float  # at most so much: percent, degrees, standard deviations
    bone: str = ""  # that alone; empty: the whole anatomy
    folder: Path | None = None  # of correspondence meshes

    @property
    def count(self) -> int:
        return KINDS[self.kind][0]

    @property
    def words(self) -> str:
        """As --shape takes it."""
        return f"{self.kind}={self.amount:g}" + (f"@{self.bone}" if self.bone else "") + (f":{self.folder}" if self.folder else "")

    @property
    def columns(self) -> list[str]:
        """Of the numbers that `amounts` gives."""
        own = {"size": ["size"], "scale": ["scale_x", "scale_y", "scale_z"], "bend": ["bend_deg", "bend_towards_deg"], "twist": ["twist_deg"],
               "modes": [f"mode_{number}" for number in range(1, MODES + 1)]}[self.kind]
        return [f"{name}@{self.bone}" if self.bone else name for name in own]


def read_shape(text: str) -> Shape:
    """Raises Problem."""
    known = ", ".join(KINDS)
    found = WORDS.fullmatch(text.strip())
    if found is None:
        raise Problem(f"--shape '{text}': is not like KIND=AMOUNT, KIND=AMOUNT@BONE or modes=AMOUNT@BONE:FOLDER; kinds are {known}")
    kind, told, bone, folder = found.groups()
    if kind not in KINDS:
        raise Problem(f"--shape '{text}': there is no kind '{kind}'; there are {known}")
    _, largest, unit = KINDS[kind]
    try:
        amount = float(told)
    except ValueError:
        amount = math.nan
    if not 0 < amount <= largest:
        raise Problem(f"--shape '{text}': '{told}' has to be a number above 0 and at most {largest:g} {unit}")
    if (kind == "modes") != (folder is not None):
        raise Problem(f"--shape '{text}': " + ("modes need a folder: modes=2@BONE:FOLDER" if kind == "modes" else "only modes have a folder"))
    if kind == "modes" and not bone:
        raise Problem(f"--shape '{text}': say whose shape the folder has: modes={told}@BONE:{folder}")
    return Shape(kind, amount, bone or "", Path(folder) if folder else None)
