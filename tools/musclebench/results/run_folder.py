"""Finished runs: run.json, frames.csv, muscles.csv, pairs.csv, fibres.csv and forces.csv of each case, and runs.csv with one row a run."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from .damage import damage

COLLISION_STAGES = ["update_ns", "detect_ns", "respond_ns"]
NOT_OF_THE_LOOP = ("recording_ns", "judging_ns", "collision_ns")  # times that are no stage of it
FRAME_COLUMNS = [
    "frame", "angle_deg", "warm_up", *COLLISION_STAGES, "frame_ns", "contacts", "nodes_inside", "max_depth_m",
    "mean_depth_m", "missed_contacts", "false_contacts", "resident_bytes",
]
REPLAY_COLUMNS = [
    "frame", "angle_deg", "warm_up", *COLLISION_STAGES, "contacts", "true_contacts", "missed_contacts",
    "false_contacts", "measured_contacts", "max_depth_error_m", "p99_depth_error_m", "mean_depth_error_m",
]
COLUMNS_OF_MODE = {"coupled": FRAME_COLUMNS, "replay": REPLAY_COLUMNS}


class ResultProblem(Exception):
    """A run folder that can't be read; the message is one line with the location and the problem."""


@dataclass
class Run:
    """A finished run. Tables are data frames; reports/reading_results.md tells their columns."""

    folder: Path
    record: dict  # run.json
    frames: pd.DataFrame  # frames.csv and collision_ns; empty where the run left none
    muscles: pd.DataFrame = field(default_factory=pd.DataFrame)  # muscles.csv; empty for a scene of one muscle
    pairs: pd.DataFrame = field(default_factory=pd.DataFrame)  # pairs.csv; empty for one muscle
    fibres: pd.DataFrame = field(default_factory=pd.DataFrame)  # fibres.csv; empty where none are followed
    forces: pd.DataFrame = field(default_factory=pd.DataFrame)  # forces.csv; empty without --forces
    shares_muscle: bool = False  # with another scene of the experiment: then it goes by the scene's name

    def __repr__(self) -> str:
        return f"Run({self.scene} with {self.backend}: {self.status}, {len(self.frames)} frames)"

    @property
    def mode(self) -> str:
        return self.record["case"].get("mode", "coupled")

    @property
    def scene(self) -> str:
        return self.record["case"]["scene"]

    @property
    def muscle(self) -> str:
        """As tables, figures and their files name it."""
        return self.scene.replace("/", "-") if self.shares_muscle else self.muscle_alone

    @property
    def muscle_alone(self) -> str:
        return self.scene.split("/")[-1]

    @property
    def backend(self) -> str:
        return self.record["case"]["backend"]

    @property
    def status(self) -> str:
        return self.record["status"]

    @property
    def timed_frames(self) -> pd.DataFrame:
        """Frames without warm-up, by frame number."""
        timed = self.frames[self.frames["warm_up"] != 1]
        return timed.set_index("frame", drop=False)

    @property
    def warm_up_count(self) -> int:
        return int((self.frames["warm_up"] == 1).sum())


def implementations(runs: list[Run]) -> dict[str, str]:
    """By backend, whose code it is."""
    return implementations_in([run.record for run in runs])


def implementations_in(records: list[dict]) -> dict[str, str]:
    """Of records of runs; those of an older program don't tell."""
    return {backend: told for record in records for backend, told in record.get("implementations", {}).items()}


def read_run(folder: Path) -> Run:
    """The run in a result folder. Raises ResultProblem where it is damaged or not whole."""
    folder = Path(folder)
    try:
        record = json.loads((folder / "run.json").read_text())
    except (OSError, ValueError) as problem:
        raise ResultProblem(f"{folder / 'run.json'}: can't be read ({problem}); run the case again") from None
    fault = damage(folder)
    if fault:
        raise ResultProblem(f"{folder}: {fault}; run the case again")
    columns = COLUMNS_OF_MODE.get(record["case"].get("mode"), FRAME_COLUMNS)
    tables = (folder / f"{name}.csv" for name in ("muscles", "pairs", "fibres", "forces"))
    muscles, pairs, fibres, forces = (pd.read_csv(path) if path.is_file() else pd.DataFrame() for path in tables)
    return Run(folder, record, read_frames(folder / "frames.csv", columns), muscles, pairs, fibres=fibres, forces=forces)


def read_frames(path: Path, columns: list[str]) -> pd.DataFrame:
    """Unknown is NaN. A run that failed before its first frame has no file and gives no rows."""
    if not path.is_file() or path.stat().st_size == 0:
        return no_frames(columns)
    try:
        frames = pd.read_csv(path)
    except ValueError as problem:
        raise ResultProblem(f"{path}: not a table of frames ({problem}); run the case again") from None
    missing = [column for column in columns if column not in frames.columns]
    if missing:
        raise ResultProblem(f"{path}: lacks the columns {', '.join(missing)}; run the case again")
    frames["collision_ns"] = frames[COLLISION_STAGES].sum(axis=1, min_count=1)
    return frames


def no_frames(columns: list[str]) -> pd.DataFrame:
    return pd.DataFrame(columns=[*columns, "collision_ns"], dtype=float)


def read_runs(raw_dir: Path) -> list[Run]:
    """Runs of every complete folder, in the order of their names."""
    return read_all(sorted(path.parent for path in raw_dir.glob("*/run.json") if not path.parent.name.startswith(".")))


def read_all(folders: list[Path]) -> list[Run]:
    """The runs of one experiment."""
    runs = [read_run(folder) for folder in folders]
    scenes: dict[str, set[str]] = {}
    for run in runs:
        scenes.setdefault(run.muscle_alone, set()).add(run.scene)
    for run in runs:
        run.shares_muscle = len(scenes[run.muscle_alone]) > 1
    return runs


def runs_table(runs: list[Run]) -> pd.DataFrame:
    return pd.DataFrame([_row(run) for run in runs])


def count_of_warnings(record: dict) -> int | None:
    """Of the scene, as the program noted them; none where it noted nothing: a replay, a case that failed, results of before."""
    warnings = record.get("warnings")
    return None if warnings is None else len(warnings)


def _row(run: Run) -> dict:
    record, frames = run.record, run.timed_frames
    build, machine, memory = (record.get(key, {}) for key in ("build", "machine", "memory"))
    return {
        "run_id": record.get("run_id"), "scene": run.scene, "muscle": run.muscle, "backend": run.backend,
        "preset": record["case"].get("preset"), "threads": record["case"].get("threads"),
        "status": run.status, "status_detail": record.get("status_detail", ""), "warnings": count_of_warnings(record),
        "muscle_vertices": record.get("muscle", {}).get("vertices"), "frames": record.get("frames"),
        "build_ns": record.get("build_ns"), "structure_bytes": record.get("structure_bytes"),
        "before_first_frame_bytes": memory.get("before_first_frame_bytes"),
        "after_last_frame_bytes": memory.get("after_last_frame_bytes"), "peak_bytes": memory.get("peak_bytes"),
        "median_collision_ns": frames["collision_ns"].median(), "median_frame_ns": frames["frame_ns"].median(),
        "max_depth_m": frames["max_depth_m"].max(), "missed_contacts": _total(frames["missed_contacts"]),
        "false_contacts": _total(frames["false_contacts"]), "wall_ns": record.get("wall_ns"),
        "state_hash": record.get("state_hash"), "git": build.get("git"), "compiler": build.get("compiler"),
        "cpu": machine.get("cpu"), "folder": run.folder.name,
    }


def _total(column: pd.Series) -> float:
    return column.sum(min_count=1)
