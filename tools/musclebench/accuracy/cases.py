"""Cases of an accuracy study: what each folder under raw/ measured, and what was planned and has no folder."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from ..experiments.manifest import FILE_NAME, read_manifest
from ..program.registry import Registry, saved_registry
from ..results.disturbance import disturbed
from ..results.run_folder import REPLAY_COLUMNS, ResultProblem, Run, no_frames, read_run
from .configurations import Configuration, configuration
from ..results.status import MEASURED

PROBE_COLUMNS = ["bone", "region", "points", "max_error_m", "p99_error_m", "mean_error_m"]
FORMER_NAMES = {"place": "region"}  # of probes that were measured before
MISSING = "missing"


@dataclass
class StudyCase:
    name: str
    run: Run  # of a missing case: without frames, status `missing`
    configuration: Configuration
    probe: pd.DataFrame  # probe.csv; empty but for probes
    disturbance: str = ""  # why the machine was too busy for its times to count; empty: it was not

    planned_mode: str = ""  # empty: of a study whose plan is gone

    @property
    def mode(self) -> str:
        """replay, probe, coupled; arms: coupled with fibres; forces: coupled with forces; floor, arms_floor, forces_floor:
        coupled, from a start that is displaced by as much as rounding does."""
        if self.planned_mode or self.run.mode != "coupled":
            return self.planned_mode or self.run.mode
        case = self.run.record["case"]
        modes = ("coupled", "floor")
        for what, name in (("fibres", "arms"), ("forces", "forces")):
            if case.get(what):
                modes = (name, f"{name}_floor")
        return modes[bool((case.get("loop") or {}).get("start_noise_m"))]

    @property
    def scene(self) -> str:
        return self.run.scene

    @property
    def repetition(self) -> int:
        return int(self.run.record["case"].get("repetition") or 0)

    @property
    def is_ok(self) -> bool:
        return self.run.status in MEASURED


def read_cases(out_dir: Path) -> list[StudyCase]:
    """All cases, those that are planned and absent as well. A folder that can't be read is a failed case."""
    raw = out_dir / "raw"
    folders = sorted(path.parent for path in raw.glob("*/run.json") if not path.parent.name.startswith("."))
    planned = {case["name"]: case for case in read_plan(out_dir)}
    registry = saved_registry(out_dir) if folders or planned else Registry(())
    cases = [_read_case(folder, planned.get(folder.name), registry) for folder in folders]
    read = {case.name for case in cases}
    absent = [_absent(raw / name, case, registry) for name, case in planned.items() if name not in read]
    found = disturbed({case.name: case.run.record for case in cases})
    for case in cases:
        case.disturbance = found.get(case.name, "")
    return sorted([*cases, *absent], key=lambda case: case.name)


def read_plan(out_dir: Path) -> list[dict]:
    """Name, mode, scene, backend, parameters, threads, repetition of each planned case. Empty without a plan. The groups of
    the experiment are named by their modes."""
    if not (out_dir / FILE_NAME).is_file():
        return []
    return [case | {"mode": case.get("group", case["mode"])} for case in read_manifest(out_dir)["cases"]]


def _read_case(folder: Path, planned: dict | None, registry: Registry) -> StudyCase:
    try:
        run = read_run(folder)
        _complete(run.record["case"], planned)
        probe = _read_probe(folder / "probe.csv") if run.mode == "probe" else pd.DataFrame()
        return _case(folder.name, run, probe, registry, (planned or {}).get("mode", ""))
    except (ResultProblem, KeyError) as problem:
        if planned is None:
            raise problem if isinstance(problem, ResultProblem) else ResultProblem(
                f"{folder / 'run.json'}: its case has no {problem}; run the case again") from None
        return _absent(folder, planned, registry, "failed", str(problem))


def _complete(case: dict, planned: dict | None) -> None:
    """A case that was stopped from outside may have said less about itself than the plan did."""
    for key, value in (planned or {}).items():
        if key != "name" and case.get(key) in (None, {}):
            case[key] = value


def _case(name: str, run: Run, probe: pd.DataFrame, registry: Registry, planned_mode: str = "") -> StudyCase:
    told = run.record["case"]
    about, parameters = registry.backend(told["backend"]), told.get("parameters") or {}
    chosen = configuration(about, parameters, int(told.get("threads") or 1))
    return StudyCase(name, run, chosen, probe, planned_mode=planned_mode)


def _absent(folder: Path, planned: dict, registry: Registry, status: str = MISSING,
            detail: str = "not run yet") -> StudyCase:
    case = {key: value for key, value in planned.items() if key != "name"}
    run = Run(folder, {"status": status, "status_detail": detail, "case": case}, no_frames(REPLAY_COLUMNS))
    return _case(folder.name, run, pd.DataFrame(), registry)


def _read_probe(path: Path) -> pd.DataFrame:
    """Without rows where the probe left none."""
    if not path.is_file() or path.stat().st_size == 0:
        return pd.DataFrame(columns=PROBE_COLUMNS)
    try:
        rows = pd.read_csv(path, keep_default_na=False, na_values=[""])
    except ValueError as problem:
        raise ResultProblem(f"{path}: not a table of errors ({problem}); run the case again") from None
    rows = rows.rename(columns=FORMER_NAMES)
    missing = [column for column in PROBE_COLUMNS if column not in rows.columns]
    if missing:
        raise ResultProblem(f"{path}: lacks the columns {', '.join(missing)}; run the case again")
    return rows
