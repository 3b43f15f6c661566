"""The page as one file that needs no network."""

from datetime import datetime, timezone
from pathlib import Path

import jinja2
from markupsafe import Markup

from ..figures import looks
from ..figures.style import muscle_label
from .bundle import SOURCES
from .helps import explained, explained_in, helps, slug
from .packed import packed_bytes
from .parts import Section
from .plain import Picture, linked_rows

TEMPLATE = "page.html.j2"
MOST_TOGGLES, MOST_PROBLEMS = 10, 3  # in sight; the others are in a list that opens


def page_html(sections: list[Section], folders: list[Path], script: str) -> str:
    """`script`: of bundle.page_script."""
    return _filled(sections, folders, script=_safe(script))


def plain_html(sections: list[Section], folders: list[Path], why: str, pictures: dict[str, tuple[list[Picture], int]]) -> str:
    """Without a program: tables, links to rows, and pictures where charts would be. `why`: it is plain."""
    return _filled(sections, folders, why_plain=why, pictures=pictures)


def template_engine() -> jinja2.Environment:
    """Of the templates in tools/page: what is not told is a mistake, and all text is escaped."""
    engine = jinja2.Environment(loader=jinja2.FileSystemLoader(SOURCES), autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                undefined=jinja2.StrictUndefined)
    engine.filters["packed"] = lambda text: packed_bytes(text.encode())
    engine.policies["json.dumps_kwargs"] = {"sort_keys": False}  # their order is that in which the page tells them
    return engine


def _filled(sections: list[Section], folders: list[Path], script: str = "", why_plain: str = "", pictures: dict | None = None) -> str:
    engine = template_engine()
    engine.filters |= {"linked": linked_rows, "named": muscle_label}
    known = helps()
    engine.filters |= {"slug": slug, "titled": looks.title, "explained": lambda word: explained(str(word), known),
                       "explained_in": lambda text: explained_in(text, known)}
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    css = (SOURCES / "style.css").read_text(encoding="utf-8")
    return engine.get_template(TEMPLATE).render(
        sections=sections, helps={slug(word): text for word, text in known.items()},
        most_toggles=MOST_TOGGLES, most_problems=MOST_PROBLEMS, folders=[folder.name for folder in folders], script=script, css=_safe(css), made=made,
        title=title_of(sections), why_plain=why_plain, pictures=pictures or {}) + "\n"


def _safe(text: str) -> str:
    return Markup(text)


def title_of(sections: list[Section]) -> str:
    """What was run, and of one study on what."""
    if len(sections) > 1:
        return "; ".join(dict.fromkeys(section.title for section in sections))
    scenes = dict(sections[0].what).get("Scenes", "").split(", ")
    muscles = [muscle_label(scene.split("/")[-1]) for scene in scenes if scene]
    data = " and ".join(dict.fromkeys(scene.split("/")[0] for scene in scenes if "/" in scene))
    told = f"{', '.join(muscles)} ({data})" if data and len(muscles) <= 4 else data
    return f"{sections[0].title}: {told}" if told else sections[0].title
