"""Markdown pages whose tables, pictures and numbers are written between markers:

    <!-- generated: times paper-lhdl muscle=iliacus -->  a table and where it comes from       <!-- end -->
    <!-- value: paper-lhdl/table_2_times[muscle=iliacus].ratio max .0f -->  a number in a sentence  <!-- end -->
    <!-- picture: paper-synthetic fig_6_iliacus -->  a picture of a study, copied to reports/gallery  <!-- end -->
    <!-- claim: budget-lhdl/substeps[scene=a].rms_mm falls -->  the sentence after it holds only while the table says so

Of a study that was not measured yet they say so; the link of a picture is kept as a comment until then.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..program.cli import Problem
from .blocks import block
from .claims import check_claim
from .measured import Measured
from .selection import value_text

MARKED = re.compile(r"<!-- (generated|value|picture): ([^>]*?) -->(.*?)<!-- end -->", re.DOTALL)
OPENING = re.compile(r"<!-- (generated|value|picture): ")
CLAIM = re.compile(r"<!-- claim: (.*?) -->", re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
LINK = re.compile(r"!\[[^\]]*\]\((?P<path>[^)]*)\)|<img [^>]*?src=\"(?P<source>[^\"]*)\"[^>]*>")
TITLE = re.compile(r" title=\"[^\"]*\"")
NOT_YET = "not measured yet"
NOT_PAGES = {"experiments.md"}


@dataclass(frozen=True)
class Picture:
    study: str
    figure: str
    file: Path  # in the gallery


def pages_of(project: Path) -> list[Path]:
    """README and all reports; what was tried is history and quotes what it measured then."""
    reports = sorted((project / "reports").rglob("*.md"))
    inside = [path for path in reports if "out" not in path.relative_to(project / "reports").parts]
    return [project / "README.md", *(path for path in inside if path.name not in NOT_PAGES)]


def written(text: str, measured: Measured, page: str, problems: list[str] | None = None) -> str:
    """The page with everything between markers made anew. What can't be made, or claims what was not measured, stays as it
    was where `problems` is given, which then has a line of it."""
    if len(OPENING.findall(text)) != len(MARKED.findall(text)):
        raise Problem(f"{page}: a marker has no <!-- end -->; add it")

    def tell(problem: Problem) -> None:
        if problems is None:
            raise Problem(f"{page}: {problem}") from None
        problems.append(f"{page}: {problem}")

    def made(match: re.Match) -> str:
        kind, specification, old = match.groups()
        try:
            inside = MAKERS[kind](measured, specification, old) if measured.has(study_of(kind, specification)) \
                else _not_yet(kind, old)
        except Problem as problem:
            tell(problem)
            return match.group(0)
        return f"<!-- {kind}: {specification} -->{inside}<!-- end -->"

    for claim in CLAIM.findall(text):
        try:
            check_claim(measured, " ".join(claim.split()))
        except Problem as problem:
            tell(problem)
    return MARKED.sub(made, text)


def study_of(kind: str, specification: str) -> str:
    """Raises Problem where the marker names none."""
    named = {"generated": r"\s*\S+ (\S+)", "value": r"\s*([\w-]+)/", "picture": r"\s*(\S+) "}[kind]
    match = re.match(named, specification)
    if match is None:
        raise Problem(f"{kind} '{specification}': names no study")
    return match.group(1)


def studies_in(text: str) -> set[str]:
    return {study_of(kind, specification) for kind, specification, _ in MARKED.findall(text)}


def pictures_in(text: str, page: Path) -> Iterator[Picture]:
    """Those that the page shows: a link in a comment waits for its study."""
    for kind, specification, inside in MARKED.findall(text):
        link = LINK.search(COMMENT.sub("", inside))
        if kind == "picture" and link:
            study, _, figure = specification.strip().partition(" ")
            yield Picture(study, figure, (page.parent / (link["path"] or link["source"])).resolve())


def _table(measured: Measured, specification: str, _: str) -> str:
    return f"\n{block(measured, specification)}\n"


def _value(measured: Measured, specification: str, _: str) -> str:
    return value_text(measured, specification)


def _picture(measured: Measured, specification: str, old: str) -> str:
    """The link stays as it was written; what is under it says where the picture comes from. One that text flows around
    (`<img align=...>`) has no room for that: it says so when it is pointed at."""
    link = LINK.search(old)
    if link is None:
        raise Problem(f"picture '{specification}': there has to be a link ![...](...) or <img src=...> between the markers")
    source = measured.source(study_of("picture", specification))
    if link["source"]:
        told = re.sub("</?sub>|`", "", source.short_words())
        return f'\n{TITLE.sub("", link.group(0))[:-1]} title="{told}">\n'
    return f"\n{link.group(0)}<br>{source.short_words()}\n"


def _not_yet(kind: str, old: str) -> str:
    link = LINK.search(old)
    shown = f"<!-- {link.group(0)} -->\n" if kind == "picture" and link else ""
    return NOT_YET if kind == "value" else f"\n{shown}{NOT_YET.capitalize()}.\n"


MAKERS = {"generated": _table, "value": _value, "picture": _picture}
