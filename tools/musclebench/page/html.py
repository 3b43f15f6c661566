"""The page as one file that needs no network."""

from datetime import datetime, timezone
from pathlib import Path

import jinja2

from ..figures.style import muscle_label
from .bundle import SOURCES
from .packed import packed_bytes
from .parts import Section

TEMPLATE = "page.html.j2"


def page_html(sections: list[Section], folders: list[Path], script: str) -> str:
    """`script`: of bundle.page_script."""
    engine = jinja2.Environment(loader=jinja2.FileSystemLoader(SOURCES), autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                undefined=jinja2.StrictUndefined)
    engine.filters |= {"packed": lambda text: packed_bytes(text.encode()), "named": muscle_label}
    engine.policies["json.dumps_kwargs"] = {"sort_keys": False}  # their order is that in which the page tells them
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    css = (SOURCES / "style.css").read_text(encoding="utf-8")
    safe = jinja2.utils.markupsafe.Markup
    return engine.get_template(TEMPLATE).render(
        sections=sections, folders=[folder.name for folder in folders], script=safe(script), css=safe(css), made=made,
        title=sections[0].title if len(sections) == 1 else "Results of musclebench") + "\n"
