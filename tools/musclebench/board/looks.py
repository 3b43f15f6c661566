"""Names and colours of backends on the board: this project's own, then what bundles tell."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

from .bundle import Bundle, Told

BACKENDS = Path(__file__).resolve().parents[3] / "backends"
SPARE = ("#8C510A", "#E7298A", "#666666", "#B3DE69", "#BC80BD", "#FB8072")
COLOUR = re.compile(r"#[0-9A-Fa-f]{6}")


def looks_of(bundles: Sequence[Bundle]) -> dict[str, Told]:
    """{backend: label, colour}, also of what has no row; this project's and the libraries that it measures first."""
    own = {path.parent.name: tomllib.loads(path.read_text()) for path in sorted(BACKENDS.glob("*/study.toml"))}
    told: Told = {name: {} for name in own}
    for bundle in reversed(bundles):  # what stands first speaks
        told |= bundle.header["backends"]
    names = sorted(told, key=lambda name: (name not in own, own.get(name, {}).get("external", False), name))
    found: dict[str, Told] = {}
    for name in names:
        title = own.get(name, {}).get("title") or told[name].get("title") or name.replace("_", " ")
        found[name] = {"label": str(title)[:60], "colour": _colour(own.get(name, told[name]), {look["colour"] for look in found.values()})}
    return found


def _colour(about: Told, taken: set[str]) -> str:
    """One that no other has, as long as there are."""
    wanted = about.get("colour")
    colours = [wanted] if isinstance(wanted, str) and COLOUR.fullmatch(wanted) else []
    return next((colour for colour in [*colours, *SPARE] if colour not in taken), SPARE[0])
