"""Bundles of results that are here: a folder of tools/accuracy, or a published study."""

import json
import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from ..accuracy.cases import read_cases
from ..experiments.manifest import FILE_NAME as PLAN
from ..experiments.manifest import read_manifest
from ..lhdl.data_folder import LICENCE as LHDL_LICENCE
from ..program.cli import Problem
from ..program.registry import FILE_NAME as REGISTRY
from ..program.registry import saved_registry
from ..page.views import views_of
from ..publish.measured import SOURCE, Measured, Source, source_of
from ..results.records import inner
from .bundle import Bundle, Told
from .columns import COLUMNS, MOST_CHARACTERS, NAME, TEXTS
from .project_scenes import is_of_project
from .study_rows import study_rows

OURS = "this project"
OWN_LICENCE = "MIT"
LICENCES_OF_DATA = {"synthetic": f"{OWN_LICENCE}: made by code of this project", "lhdl": f"{LHDL_LICENCE}: not for commercial use"}
LICENCE = re.compile(r"(?<![\w.-])(?:MIT|ISC|Zlib|zlib|BSL-1\.0|Apache-2\.0|BSD-[1-4]-Clause|[AL]?GPL-\d[\w.+-]*|MPL-\d[\w.]*|CC-?BY[\w. -]*)(?![\w-])")
RELEASE = re.compile(r"\d|@")
OWN_BACKENDS = Path(__file__).resolve().parents[3] / "backends"
UNKNOWN = "not told"


def bundle_of(folder: Path, told: Mapping[str, str] | None = None, sources: Mapping[str, str] | None = None, with_shapes: bool = True) -> Bundle:
    """`told`: licences, `sources`: commits, by backend or scene. Raises Problem where one is missing or the study is not there."""
    told, sources, folder = told or {}, sources or {}, folder.resolve()
    is_published = (folder / SOURCE).is_file()
    rows = _clean(study_rows(folder))
    rows = rows[rows.groupby("backend")["time_ms"].transform("count") > 0]  # of the others no run is there that would tell whose they are
    if is_published:
        source, run, plan = Measured(folder.parent).source(folder.name), {}, {}
    else:
        plan = read_manifest(folder) if (folder / PLAN).is_file() else {}
        source, run = source_of(folder, _command(plan)), _a_run(folder)
    if unknown := sorted((set(told) | set(sources)) - set(rows["backend"]) - set(rows["scene"])):
        raise Problem(f"{unknown[0]}: no backend and no scene of {folder} is called so")
    rows["scene"] = rows["scene"].map(_scene_name)
    if strange := [name for name in (folder.name, *rows["scene"], *rows["backend"], *rows["configuration"]) if not NAME.fullmatch(name)]:
        raise Problem(f"{folder}: {strange[0]!r} is no name that a bundle can hold; use letters, digits and _ . - and run the study again")
    titles = _titles(folder)
    scenes = {name: {"licence": told.get(name) or (LICENCES_OF_DATA.get(name.split("/")[0], UNKNOWN) if is_of_project(name) else UNKNOWN)}
              for name in sorted(set(rows["scene"]))}
    header: Told = {
        "title": folder.name, "measured": (plan.get("started") or source.date)[:10], "commit": source.commit, "command": source.command,
        "machine": {"cpu": source.machine, "cores": inner(run, "machine", "cores") or 0},
        "build": {"compiler": source.build, "flags": inner(run, "build", "flags") or UNKNOWN},
        "state": {"disturbed_runs": source.disturbed, "governor": str(inner(run, "machine_state", "governor") or UNKNOWN),
                  "load_average_1m": inner(run, "machine_state", "load_average_1m", "before"), "smt": inner(run, "machine_state", "smt")},
        "backends": {name: _of_backend(name, source, told, sources) | titles.get(name, {}) for name in sorted(set(rows["backend"]))},
        "scenes": scenes,
    }
    return Bundle(header, rows, _shapes(folder, scenes) if with_shapes and not is_published else None, str(folder))


def _scene_name(scene: str) -> str:
    """Of an own one, not its path."""
    return Path(scene).stem if scene.endswith(".toml") else scene


def _shapes(folder: Path, scenes: Iterable[str]) -> Told | None:
    """{scene: runs in space}: of each backend as it is by default, the run that told forces where it kept its shapes."""
    found = {}
    cases = [case for case in read_cases(folder) if case.is_ok and case.configuration.is_default and case.run.record.get("snapshots")]
    for scene in scenes:
        for mode in ("forces", "coupled"):
            runs = {(case.run.muscle, case.run.backend): case.run for case in cases
                    if case.mode == mode and _scene_name(case.run.scene) == scene}
            if runs:
                found[scene] = views_of(runs, scene).data
                break
    return found or None


def _of_backend(name: str, source: Source, told: Mapping[str, str], sources: Mapping[str, str]) -> Told:
    """Whose code it is, of which commit or release, under which licence."""
    text = source.implementations.get(name, "")
    if text.startswith(OURS) and (OWN_BACKENDS / name).is_dir():
        return {"implementation": text, "source": sources.get(name, f"musclebench {source.commit}"), "licence": told.get(name, OWN_LICENCE)}
    found = LICENCE.search(text)
    licence, release = told.get(name) or (found[0] if found else ""), sources.get(name) or text.split(",")[0]
    if not licence or not RELEASE.search(release):
        raise Problem(f"backend {name} does not say its licence and its source: add --licence {name}=MIT --source {name}=URL@COMMIT, each "
                      "with your own")
    return {"implementation": text or name, "source": release, "licence": licence}


def _titles(folder: Path) -> dict[str, Told]:
    """As the registry beside the results tells them; a published study has none."""
    if not (folder / REGISTRY).is_file():
        return {}
    known = saved_registry(folder).backends
    return {one.name: {"title": one.title, "help": one.help or UNKNOWN} | ({"colour": one.colour} if one.colour else {}) for one in known}


def _command(plan: Told) -> str:
    """Without the path of the script, which is of that machine."""
    words = [str(word) for word in plan.get("command_line", [])]
    return shlex.join(["tools/accuracy", *(words[1:] if words and words[0].endswith(".py") else words)])


def _a_run(folder: Path) -> Told:
    """One of those that count; all are of one machine and build."""
    for path in sorted((folder / "raw").glob("*-replay-*/run.json")):
        try:
            run: Told = json.loads(path.read_text())
        except ValueError:
            continue
        if isinstance(run, dict) and run.get("build"):
            return run
    return {}


def _clean(rows: pd.DataFrame) -> pd.DataFrame:
    """Sentences of runs on one line, and no longer than a bundle's texts."""
    counts = [column.name for column in COLUMNS if column.kind == "count"]
    rows = rows.assign(**{name: rows[name].fillna("").astype(str).map(lambda text: " ".join(text.split())[:MOST_CHARACTERS]) for name in TEXTS})
    return rows.assign(**{name: rows[name].astype("Int64") for name in counts})
