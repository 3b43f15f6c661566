"""What words of a page mean: backends and effects as the program's list tells them, and how runs end."""

import re

from markupsafe import Markup, escape

from ..figures import looks
from ..results.status import MEANINGS


def helps() -> dict[str, str]:
    """{word: sentence} of every backend, by its name and its title, of every effect and of every status."""
    found = dict(MEANINGS)
    for backend in looks.known().backends:
        whose = f" Code: {backend.implementation}." if backend.implementation else ""
        text = f"{backend.title} ({backend.name}): {backend.help or 'no description'}.{whose}"
        found |= {backend.name: text, backend.title: text}
    for name, text in looks.known().effect_helps:
        found |= {name: f"Effect {name}: {text}.", name.replace("_", " "): f"Effect {name}: {text}."}
    return found


def slug(word: str) -> str:
    return re.sub(r"\W+", "-", word)


def explained(word: str, known: dict[str, str]) -> Markup:
    """A word that is known as a whole, which hovering, the keyboard and a screen reader explain; any other as it is."""
    key = word.rstrip("* ")
    if key not in known:
        return escape(word)
    return Markup('<span class="explained" tabindex="0" aria-describedby="help-{}">{}</span>').format(slug(key), word)


def explained_in(text: str, known: dict[str, str]) -> Markup:
    """Each first mention of a status in a sentence."""
    parts, done = re.split(rf"\b({'|'.join(map(re.escape, MEANINGS))})\b", text), set()
    made = []
    for part in parts:
        made.append(explained(part, known) if part in MEANINGS and part not in done else escape(part))
        done.add(part)
    return Markup("").join(made)
