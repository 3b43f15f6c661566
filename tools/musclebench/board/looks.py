"""Names and colours of backends on the board: this project's own, then what bundles tell."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

from ..page.looks_of import COLOURS
from .bundle import Bundle, Told

BACKENDS = Path(__file__).resolve().parents[3] / "backends"
COLOUR = re.compile(r"#[0-9A-Fa-f]{6}")


def looks_of(bundles: Sequence[Bundle]) -> dict[str, Told]:
    """{backend: label, colour}, also of what has no row; this project's and the libraries that it measures first."""
    own = {path.parent.name: tomllib.loads(path.read_text()) for path in sorted(BACKENDS.glob("*/study.toml"))}
    told: Told = {name: {} for name in own}
    for bundle in reversed(bundles):  # what stands first speaks
        told |= bundle.header["backends"]
    names = sorted(told, key=lambda name: (name not in own, own.get(name, {}).get("external", False), name))
    strange = [name for name in names if name not in own]
    return {name: {"label": str(own.get(name, {}).get("title") or told[name].get("title") or name.replace("_", " "))[:60],
                   "colour": _colour(own.get(name, told[name]), COLOURS[strange.index(name) % len(COLOURS)] if name in strange else "#888888")}
            for name in names}


def _colour(about: Told, spare: str) -> str:
    colour = about.get("colour")
    return colour if isinstance(colour, str) and COLOUR.fullmatch(colour) else spare
