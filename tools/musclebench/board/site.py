"""Writes the board: a folder of static pages that load nothing from elsewhere, ready for any host or for a double click."""

import itertools
import json
import math
import re
from collections.abc import Iterable, Sequence
from csv import QUOTE_NONNUMERIC
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from urllib.parse import quote

import pandas as pd

from ..accuracy.front import EXACT_MM
from ..page.bundle import BOARD, SHAPES, SOURCES, page_script
from ..page.html import template_engine
from ..program.cli import Problem
from ..program.whole_folder import whole_folder
from ..tables.difficulties import TITLES
from .bundle import Bundle, Told
from .columns import FLAGS
from .hard_cases import HardCase
from .looks import looks_of
from .made import OURS
from .page_column import PageColumn
from .standing import CLAIMED, FEWEST_CONTACTS, LARGEST_BOUND_MM, OTHER, REFUTED, UNHASHED, VERIFIED, board_rows, machines_of

MARK, ROWS = "board.json", "board.csv"  # the first tells which files are the board's
LARGEST_BYTES = 20_000_000
LONGEST_NAME = 80  # of a page's file
TITLE = "What collision accuracy costs in a muscle simulation"
WORDS = {
    VERIFIED: "The same answers, to the last bit, and the same errors at contacts were computed here. Times, moment arms, pressures and torques are always "
              "claimed.",
    CLAIMED: "Nobody computed the answers here.",
    OTHER: "This version gives other answers or errors. That one may have given its own, which nobody can see here: the row can't win.",
    UNHASHED: "The results are of before answers had a hash.",
    REFUTED: "The same version gave other answers or errors here, or the row goes by another setting's name. It can't win.",
    "closed": f"A scene that everyone can have, all frames of it, the questions that it asks now, and a declared bound of at most {LARGEST_BOUND_MM:g} mm that "
              f"was held at {FEWEST_CONTACTS} contacts or more.",
    "open": "All other rows.",
    "surface offset": "How far the backend's surface is from the true one at contacts: 99 of 100 have a smaller one.",
    "moment arm, peak pressure, joint torque": "Root mean square over the motion of the difference from the run with exact collision. No figure is better than "
                                               "what rounding does by itself. Times are of the run in which the backend drives the muscle.",
    "pays after frames": "Then the setting has made up for its build: it is ahead of all that hold the error and are ready sooner.",
    "other query set": "The row is grey: it answers other questions than the scene asks now. It can't win.",
    "every 4th frame": "A slow library is asked about some of the frames only. Its errors are those of these frames.",
    "*": "The machine was busy with something else while it was measured.",
}


@dataclass
class Part:
    """A table or a list of a page, or its runs in space."""

    title: str
    words: list[str] = field(default_factory=list)
    pairs: dict[str, str] = field(default_factory=dict)
    rows: list[Told] = field(default_factory=list)
    columns: list[PageColumn] = field(default_factory=list)
    views: Told | None = None  # as view.html.j2 reads them


@dataclass
class Page:
    path: str
    title: str
    words: list[str] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    script: str = ""
    index: Told | None = None  # of the page with the ranking
    menu: dict[str, list[Told]] = field(default_factory=dict)

    @property
    def root(self) -> str:
        return "../" * self.path.count("/")


COLUMNS = [
    PageColumn("setting", "setting"), PageColumn("backend", "backend", link="backend_page"), PageColumn("scene", "scene", link="scene_page"),
    PageColumn("time", "ms a frame", True), PageColumn("offset", "surface offset (mm)", True), PageColumn("arm", "moment arm off (mm)", True),
    PageColumn("pressure", "peak pressure off (%)", True), PageColumn("build", "build (s)", True), PageColumn("memory", "MB", True),
    PageColumn("standing", "answers"), PageColumn("bound", "declared bound"), PageColumn("division", "division"),
    PageColumn("machine_name", "bundle", link="machine_page"),
    PageColumn("measured", "measured"), PageColumn("why_not", "why it can't win"),
]


def write_site(bundles: Sequence[Bundle], hard: Sequence[HardCase], out: Path, recomputed: Sequence[pd.DataFrame] = (), commit: str = "") -> pd.DataFrame:
    """The rows of the board. `recomputed`, `commit`: see standing. Into a new folder, or in place of an older board, which goes when
    the new one is whole. Raises Problem where `out` is something else, or where the scripts can't be made."""
    rows = board_rows(bundles, recomputed, commit)
    scripts = {name: page_script(entry=name) for name in (BOARD, SHAPES)}
    with whole_folder(out, MARK, "board") as folder:
        _write(folder, rows, bundles, hard, scripts)
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        if size > LARGEST_BYTES:
            largest = max(bundles, key=lambda bundle: len(json.dumps(bundle.shapes or {})) + len(bundle.rows))
            raise Problem(f"the board would have {size / 1e6:.1f} MB, more than {LARGEST_BYTES / 1e6:g}; leave out bundles, such as {largest.source}")
    return rows


def _write(folder: Path, rows: pd.DataFrame, bundles: Sequence[Bundle], hard: Sequence[HardCase], scripts: dict[str, str]) -> None:
    template = template_engine().get_template("board.html.j2")
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d")
    told = {"made": made, "sources": [bundle.header["title"] for bundle in bundles], "looks": looks_of(bundles)}
    csv = rows.drop(columns=["title", "refutation"]).astype({flag: int for flag in (*FLAGS, "is_old", "is_open")}).to_csv(index=False, quoting=QUOTE_NONNUMERIC)
    for page in _pages(rows, bundles, hard, csv):
        path = folder / page.path
        path.parent.mkdir(exist_ok=True)
        path.write_text(template.render(told | vars(page), root=page.root), encoding="utf-8")
    (folder / "style.css").write_text((SOURCES / "style.css").read_text(encoding="utf-8"), encoding="utf-8")
    for name, script in scripts.items():
        (folder / name).write_text(script, encoding="utf-8")
    (folder / ROWS).write_text(csv, encoding="utf-8")


def _pages(rows: pd.DataFrame, bundles: Sequence[Bundle], hard: Sequence[HardCase], csv: str) -> list[Page]:
    looks, libraries = looks_of(bundles), _libraries(bundles)
    paths = {"backends": _paths("backends", [name for name in looks if name in set(rows["backend"])]), "scenes": _paths("scenes", rows["scene"]),
             "libraries": _paths("libraries", libraries), "hard": _paths("hard", [case.name for case in hard]),
             "machines": {name: f"machines/{index}.html" for index, name in enumerate(dict.fromkeys(rows["machine"]), 1)}}
    cells = _cells(rows, looks, paths)
    backends = [_backend_page(name, cells, looks, bundles, hard, paths) for name in paths["backends"]]
    scenes = [_scene_page(name, path, cells, bundles) for name, path in paths["scenes"].items()]
    of_libraries = [Page(paths["libraries"][text], text, [f"Its backends: {', '.join(sorted(names))}."],
                         [_table("All settings", [cell for cell in cells if cell["name"] in names])]) for text, names in libraries.items()]
    of_machines = [_machine_page(name, path, cells, bundles) for name, path in paths["machines"].items()]
    of_cases = [Page(paths["hard"][case.name], f"Hard case {case.name}", [case.what, case.why, f"Bar: {case.bar}."],
                     [Part("What each backend does", rows=case.cells, columns=HardCase.COLUMNS)]) for case in hard]
    menu = {kind: [{"href": quote(page.path), "title": page.title} for page in pages] for kind, pages in
            {"Backends": backends, "Libraries": of_libraries, "Scenes": scenes, "Machines": of_machines, "Hard cases": of_cases}.items() if pages}
    by_cost = rows.groupby("scene")["time_ms"].median().sort_values(ascending=False, kind="stable").index  # where there is most contact first
    index = {"scenes": {name: name for name in by_cost}, "machines": {name: name for name in paths["machines"]}, "csv": csv,
             "meanings": WORDS, "contacts": {"all": "all"} | {kind: f"{'easy' if kind == 'flat' else 'hard'}: {title}" for kind, title in TITLES.items()},
             "looks": {name: looks[name] | {"page": quote(path)} for name, path in paths["backends"].items()}}
    words = ["Every backend answers the same questions: is a node of a muscle inside a bone, and how deep? Say which error you can live with, and read what "
             "it costs."]
    return [Page("index.html", TITLE, words, [], BOARD, index, menu), *backends, *of_libraries, *scenes, *of_machines, *of_cases]


def _paths(folder: str, names: Iterable[str]) -> dict[str, str]:
    """{name: file that any host can have}, each file once."""
    found: dict[str, str] = {}
    taken: set[str] = set()  # some hosts do not tell large letters from small ones
    for name in dict.fromkeys(names):
        stem = re.sub(r"[^A-Za-z0-9_.-]+", "-", name)[:LONGEST_NAME].strip(".-") or "unnamed"
        tries = (f"{stem}{f'.{number}' if number > 1 else ''}" for number in itertools.count(1))
        chosen = next(one for one in tries if one.lower() not in taken)
        taken.add(chosen.lower())
        found[name] = f"{folder}/{chosen}.html"
    return found


def _cells(rows: pd.DataFrame, looks: Told, paths: dict[str, dict[str, str]]) -> list[Told]:
    """As people read them."""
    return [{
        "name": row["backend"], "backend": looks[row["backend"]]["label"],
        "setting": (row["spoken"] or row["configuration"]) + (f", every {row['stride']:.0f}th frame" if row["stride"] > 1 else ""),
        "backend_page": quote(paths["backends"][row["backend"]]), "scene": row["scene"], "scene_page": quote(paths["scenes"][row["scene"]]),
        "time": _figure(row["time_ms"]) + (" *" if row["is_disturbed"] else ""), "offset": _figure(row["offset_mm"], EXACT_MM),
        "arm": _figure(_floored(row, "arm_mm", "arm_floor_mm")),
        "pressure": _figure(_floored(row, "pressure_percent", "pressure_floor_percent")), "build": _figure(row["build_s"]),
        "memory": _figure(row["structure_bytes"], 0, 1e-6),
        "standing": row["standing"], "bound": row["bound"], "division": row["division"], "machine": row["machine"],
        "machine_name": row["title"], "machine_page": paths["machines"][row["machine"]],
        "measured": f"{row['measured']}, {row['commit'][:7]}{', other query set' if row['is_old'] else ''}", "is_old": row["is_old"], "why_not": row["why_not"],
    } for row in rows.to_dict("records")]


def _backend_page(name: str, cells: list[Told], looks: Told, bundles: Sequence[Bundle], hard: Sequence[HardCase], paths: Told) -> Page:
    about = _first(bundles, "backends", name)
    told = {"code": about["implementation"], "source": about["source"], "licence": about["licence"]}
    verdicts = [{"case": case.name, "page": quote(paths["hard"][case.name]), **cell} for case in hard for cell in case.cells if cell["backend"] == name]
    parts = [Part("Whose code it is", pairs=told), _table("All settings", [cell for cell in cells if cell["name"] == name], {"backend"})]
    if verdicts:
        columns = [PageColumn("case", "case", link="page"), *HardCase.COLUMNS[1:]]
        parts.append(Part("Hard cases", rows=verdicts, columns=columns))
    return Page(paths["backends"][name], looks[name]["label"], [about.get("help", "")] if about.get("help") else [], parts)


def _scene_page(name: str, path: str, cells: list[Told], bundles: Sequence[Bundle]) -> Page:
    parts = [Part("Licence of the anatomy", [_first(bundles, "scenes", name)["licence"]]),
             _table("All settings", [cell for cell in cells if cell["scene"] == name], {"scene"})]
    shapes = next((bundle.shapes[name] for bundle in bundles if bundle.shapes and name in bundle.shapes), None)
    if shapes:
        words = "Drag to turn. Keyboard: arrow keys turn, plus and minus zoom, 0 shows the first view, space plays. The address keeps camera and frame."
        views = {"title": "Shapes, pressure and forces", "words": words, "scenes": shapes["scenes"], "data": shapes,
                 "muscle": shapes["scenes"][0]["muscle"]}
        parts.insert(1, Part("Shapes", views=views))
    return Page(path, name, [], parts, SHAPES if shapes else "")


def _machine_page(name: str, path: str, cells: list[Told], bundles: Sequence[Bundle]) -> Page:
    lines = []
    for bundle, machine in zip(bundles, machines_of(bundles)):
        if machine == name:
            about = bundle.header
            state = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in about["state"].items() if value is not None)
            lines.append({"title": about["title"], "measured": about["measured"], "commit": about["commit"], "command": about["command"], "state": state})
    columns = [PageColumn("title", "bundle"), PageColumn("measured", "measured"), PageColumn("commit", "commit"), PageColumn("command", "command"),
               PageColumn("state", "state of the machine")]
    return Page(path, name, ["Times of these bundles compare with each other, and with no others."],
                [Part("Bundles", rows=lines, columns=columns), _table("All settings", [cell for cell in cells if cell["machine"] == name])])


def _libraries(bundles: Sequence[Bundle]) -> dict[str, set[str]]:
    """{whose code: backends}, of others."""
    found: dict[str, set[str]] = {}
    for bundle in bundles:
        for name, about in bundle.header["backends"].items():
            if not about["implementation"].startswith(OURS):
                found.setdefault(about["implementation"].split(",")[0], set()).add(name)
    return found


def _first(bundles: Sequence[Bundle], table: str, name: str) -> Told:
    """What stands first speaks for a name: a stranger's bundle rewrites nothing of what is known."""
    told: Told = next(bundle.header[table][name] for bundle in bundles if name in bundle.header[table])
    return told


def _table(title: str, rows: list[Told], without: set[str] | None = None) -> Part:
    """Columns that say nothing here are left out."""
    columns = [column for column in COLUMNS if column.name not in (without or set()) and any(row[column.name] not in ("", "-") for row in rows)]
    return Part(title, rows=rows, columns=columns)


def _floored(row: Told, error: str, floor: str) -> float:
    """Nothing is better than what rounding does by itself."""
    return math.nan if pd.isna(row[error]) or pd.isna(row[floor]) else max(float(row[error]), float(row[floor]))


def _figure(value: float, exact: float = 0.0, factor: float = 1.0) -> str:
    if pd.isna(value):
        return "-"
    return "exact" if value < exact else f"{factor * value:.4g}"
