"""Tables of moment arms: each muscle's band over the joint's range, and its figures beside the published ones."""

from pathlib import Path

import numpy as np
import pandas as pd

from ..program.cli import Problem
from ..results.run_folder import Run
from ..tables.table_formats import Column, Table
from .published import NEAR_DEG, Curve, Published

COMPARED_DEG = (-10, 0, 10, 20, 30, 40, 50, 60)
GOAL_MM, GOAL_PERCENT = 5.0, 15.0
BAND = ("min", "p10", "mean", "p90", "max")

ARM_COLUMNS = [
    Column("muscle", "muscle"), Column("angle_deg", "flexion deg", 0), Column("mean_mm", "passive, dL/dθ mm", 1),
    Column("min_mm", "least mm", 1), Column("max_mm", "largest mm", 1), Column("error_mm", "error of the mean mm", 2),
    Column("published_mm", "same hip, mean mm", 1), Column("published_min_mm", "least mm", 1),
    Column("published_max_mm", "largest mm", 1), Column("difference_mm", "difference mm", 1),
    Column("difference_percent", "difference %", 0), Column("holds", "goal"),
    Column("active_mm", "active, dL/dθ mm", 1), Column("torque_mm", "active, torque over fibre force mm", 1),
    Column("others_percent", "other effects along the pull, at the bone that turns %", 0), Column("active_difference_mm", "difference mm", 1),
    Column("active_holds", "goal, or why not"),
    Column("lower_mm", "finite elements, lower mm", 1), Column("upper_mm", "finite elements, upper mm", 1),
    Column("measured_mm", "measured by others mm", 1),
]
CAPTION = (
    "Moment arms r = dL / d(flexion) of the fibres of each muscle, positive where they grow longer in flexion, beside those of "
    "the same hip (Modenese and Kohout 2020), of finite elements of another subject (Blemker and Delp 2005, unscaled) and of "
    f"measurements. Goal: the mean within {GOAL_MM:g} mm or {GOAL_PERCENT:g} % of that of the same hip. A passive muscle falls slack where "
    "its ends come closer, as relaxed muscles do (Hoang et al. 2007, Herbert et al. 2015), and its fibres then keep their "
    "length; published arms are those of taut lines. Active: the same with fibres that pull; they draw taut while the joint goes "
    "to where its course begins. Beside their arm stands the joint's torque over their force: by virtual work the two are one where nothing but "
    "fibres bears force. Where they part by more than the goal, neither is compared with what is published."
)
NOTHING_PUBLISHED = (
    "Moment arms r = dL / d(flexion) of the fibres of each muscle, positive where they grow longer in flexion. Of the synthetic "
    "hip nothing is published that they could be held against."
)


def course_of(runs: list[Run]) -> pd.DataFrame:
    """Of one muscle, whose runs begin at rest and go apart, or which has one run that goes to one end first: angle_deg and the
    band in mm, ascending, and where forces are told torque_mm and others_percent. Of a run that comes to an angle twice the
    later time counts. Each run has an arm at rest, of its own side; taken is that of the run that turns farthest. Raises Problem
    where two tell of one angle."""
    fibres = sorted((_by_angle(run) for run in runs), key=lambda rows: -rows["angle_deg"].abs().max())
    rows = pd.concat([rows if i == 0 else rows[rows["frame"] > 0] for i, rows in enumerate(fibres)])
    twice = rows["angle_deg"][rows["angle_deg"].duplicated()]
    if len(twice):
        folders = ", ".join(str(run.folder.name) for run in runs)
        raise Problem(f"{folders}: more than one tells of {twice.iloc[0]:g} degrees; a muscle needs one run of flexion and one of extension")
    course = pd.DataFrame({"angle_deg": rows["angle_deg"], "error_mm": 1e3 * rows["moment_arm_error_m"]})
    for name in BAND:
        course[f"{name}_mm"] = 1e3 * rows[f"{name}_moment_arm_m"]
    for name in ("torque_mm", "others_percent"):
        if name in rows:
            course[name] = rows[name]
    return course.sort_values("angle_deg", kind="stable").reset_index(drop=True)


def _by_angle(run: Run) -> pd.DataFrame:
    """Rows of fibres.csv with what forces.csv tells of their frames. One angle is one number, on the way there and on the way
    back."""
    rows = run.fibres.assign(angle_deg=run.fibres["angle_deg"].round(6)).drop_duplicates("angle_deg", keep="last")
    told = _by_frame(run)
    return rows.join(told, on="frame") if len(told) else rows


def _by_frame(run: Run) -> pd.DataFrame:
    """torque_mm: the torque of the muscle's attachments and contacts over the force of its fibres, in the sign of dL/dθ.
    others_percent: what its other effects add along the pull of its fibres at the bone that turns, or take away. Frames whose contact does
    not tell its bone, and those in which another muscle pushes and so hands force on, are left out; empty where no fibres pull."""
    forces = run.forces
    if forces.empty or "fibres_n" not in forces or forces["fibres_n"].isna().all():
        return pd.DataFrame()
    pushed = forces["frame"][(forces["source"] == "muscle") & (forces["force_n"] > 0)]
    known = forces["frame"].isin(forces["frame"][forces["source"] == "joint"]) & ~forces["frame"].isin(pushed)
    turning = forces[known & (forces["muscle"] == run.fibres["muscle"].iloc[0]) & forces["torque_n_m"].notna()]
    attached = turning[turning["source"] == "attachment"].groupby("frame")
    force_n, active_n = attached["fibres_n"].first(), attached["active_n"].sum()
    return pd.DataFrame({"torque_mm": -1e3 * turning.groupby("frame")["torque_n_m"].sum() / force_n.where(force_n > 0),
                         "others_percent": 100 * attached["passive_n"].agg(lambda of_one: of_one.abs().sum()) / active_n.where(active_n > 0)})


def arm_table(passive: dict[str, pd.DataFrame], active: dict[str, pd.DataFrame],
              published: dict[str, Published]) -> Table:
    """The courses by muscle; `active` may lack some."""
    rows = [_row(muscle, angle, course, active.get(muscle), published.get(muscle, Published()))
            for muscle, course in passive.items() for angle in COMPARED_DEG]
    keys = [column.key for column in ARM_COLUMNS]
    shown = [key for key in keys if key != "muscle"]
    return Table("moment_arms", CAPTION if published else NOTHING_PUBLISHED, ARM_COLUMNS, pd.DataFrame(rows, columns=keys), shown)


def _row(muscle: str, angle: float, passive: pd.DataFrame, active: pd.DataFrame | None, published: Published) -> dict:
    def of(curves: dict[str, Curve] | None, name: str) -> float:
        return curves[name].at(angle) if curves else np.nan

    mean, wanted = _at(passive, "mean_mm", angle), of(published.same_hip, "mean")

    def taut(key: str) -> float:
        return _at(active, key, angle) if active is not None and key in active else np.nan

    with_tension, by_torque = taut("mean_mm"), taut("torque_mm")
    parted = "" if np.isnan(by_torque) or np.isnan(with_tension) or _holds(by_torque, with_tension) == "yes" else \
        f"dL/dθ and torque part by {abs(by_torque - with_tension):.1f} mm"
    return {
        "muscle": muscle, "angle_deg": angle, "mean_mm": mean, "min_mm": _at(passive, "min_mm", angle),
        "max_mm": _at(passive, "max_mm", angle), "error_mm": _at(passive, "error_mm", angle), "published_mm": wanted,
        "published_min_mm": of(published.same_hip, "min"), "published_max_mm": of(published.same_hip, "max"),
        "difference_mm": mean - wanted, "difference_percent": 100 * (mean - wanted) / abs(wanted) if wanted else np.nan,
        "holds": _holds(mean, wanted), "active_mm": with_tension, "torque_mm": by_torque, "others_percent": taut("others_percent"),
        "active_difference_mm": np.nan if parted else with_tension - wanted,
        "active_holds": parted or _holds(with_tension, wanted),
        "lower_mm": of(published.finite_elements, "lower"), "upper_mm": of(published.finite_elements, "upper"),
        "measured_mm": published.measured.at(angle) if published.measured else np.nan,
    }


def _at(course: pd.DataFrame, key: str, angle: float) -> float:
    """NaN beyond the angles that are known, and where those of the nearest frames are not."""
    known = course[course[key].notna()]
    frame_deg = course["angle_deg"].diff().median()
    if known.empty or (known["angle_deg"] - angle).abs().min() > max(NEAR_DEG, frame_deg):
        return np.nan
    return Curve(known["angle_deg"].to_numpy(), known[key].to_numpy()).at(angle)


def _holds(mean: float, wanted: float) -> str:
    off = abs(mean - wanted)
    return "-" if np.isnan(off) else "yes" if off <= GOAL_MM or off <= GOAL_PERCENT / 100 * abs(wanted) else "no"


def course_files(courses: dict[str, pd.DataFrame], out_dir: Path, word: str = "") -> list[Path]:
    """The whole courses, a file a muscle; `word` ends its name."""
    files = []
    for muscle, course in courses.items():
        path = out_dir / f"moment_arms_{muscle}{word}.csv"
        course.to_csv(path, index=False)
        files.append(path)
    return files
