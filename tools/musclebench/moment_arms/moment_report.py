"""Tables of moment arms: each muscle's band over the joint's range, and its figures beside the published ones."""

from pathlib import Path

import numpy as np
import pandas as pd

from ..results.run_folder import Run
from ..tables.table_formats import Column, Table
from .published import Curve, Published

COMPARED_DEG = (-10, 0, 10, 20, 30, 40, 50, 60)
GOAL_MM, GOAL_PERCENT = 5.0, 15.0
BAND = ("min", "p10", "mean", "p90", "max")

ARM_COLUMNS = [
    Column("muscle", "muscle"), Column("angle_deg", "flexion deg", 0), Column("mean_mm", "mean mm", 1),
    Column("min_mm", "least mm", 1), Column("max_mm", "largest mm", 1), Column("error_mm", "error of the mean mm", 2),
    Column("published_mm", "same hip, mean mm", 1), Column("published_min_mm", "least mm", 1),
    Column("published_max_mm", "largest mm", 1), Column("difference_mm", "difference mm", 1),
    Column("difference_percent", "difference %", 0), Column("holds", "goal"),
    Column("lower_mm", "finite elements, lower mm", 1), Column("upper_mm", "upper mm", 1),
    Column("measured_mm", "measured mm", 1),
]
CAPTION = (
    "Moment arms r = dL / d(flexion) of the fibres of each muscle, positive where they grow longer in flexion, beside those of "
    "the same hip (Modenese and Kohout 2020), of finite elements of another subject (Blemker and Delp 2005, unscaled) and of "
    f"measurements. Goal: the mean within {GOAL_MM:g} mm or {GOAL_PERCENT:g} % of that of the same hip."
)
NOTHING_PUBLISHED = (
    "Moment arms r = dL / d(flexion) of the fibres of each muscle, positive where they grow longer in flexion. Of the synthetic "
    "hip nothing is published that they could be held against."
)


def course_of(runs: list[Run]) -> pd.DataFrame:
    """Of one muscle, whose runs begin at rest and go apart: angle_deg and the band in mm, ascending."""
    rows = pd.concat([run.fibres if i == 0 else run.fibres[run.fibres["frame"] > 0] for i, run in enumerate(runs)])
    course = pd.DataFrame({"angle_deg": rows["angle_deg"], "error_mm": 1e3 * rows["moment_arm_error_m"]})
    for name in BAND:
        course[f"{name}_mm"] = 1e3 * rows[f"{name}_moment_arm_m"]
    return course.sort_values("angle_deg", kind="stable").reset_index(drop=True)


def arm_table(courses: dict[str, pd.DataFrame], published: dict[str, Published]) -> Table:
    rows = [_row(muscle, angle, course, published.get(muscle, Published()))
            for muscle, course in courses.items() for angle in COMPARED_DEG]
    keys = [column.key for column in ARM_COLUMNS]
    shown = [key for key in keys if key != "muscle"]
    return Table("moment_arms", CAPTION if published else NOTHING_PUBLISHED, ARM_COLUMNS, pd.DataFrame(rows, columns=keys), shown)


def _row(muscle: str, angle: float, course: pd.DataFrame, published: Published) -> dict:
    def ours(key: str) -> float:
        known = course[course[key].notna()]
        return Curve(known["angle_deg"].to_numpy(), known[key].to_numpy()).at(angle) if len(known) else np.nan

    def of(curves: dict[str, Curve] | None, name: str) -> float:
        return curves[name].at(angle) if curves else np.nan

    mean, wanted = ours("mean_mm"), of(published.same_hip, "mean")
    difference = mean - wanted
    percent = 100 * difference / abs(wanted) if wanted else np.nan
    held = abs(difference) <= GOAL_MM or abs(percent) <= GOAL_PERCENT
    return {
        "muscle": muscle, "angle_deg": angle, "mean_mm": mean, "min_mm": ours("min_mm"), "max_mm": ours("max_mm"),
        "error_mm": ours("error_mm"), "published_mm": wanted, "published_min_mm": of(published.same_hip, "min"),
        "published_max_mm": of(published.same_hip, "max"), "difference_mm": difference, "difference_percent": percent,
        "holds": "-" if np.isnan(difference) else "yes" if held else "no",
        "lower_mm": of(published.finite_elements, "lower"), "upper_mm": of(published.finite_elements, "upper"),
        "measured_mm": published.measured.at(angle) if published.measured else np.nan,
    }


def course_files(courses: dict[str, pd.DataFrame], out_dir: Path) -> list[Path]:
    """The whole courses, a file a muscle."""
    files = []
    for muscle, course in courses.items():
        path = out_dir / f"moment_arms_{muscle}.csv"
        course.to_csv(path, index=False)
        files.append(path)
    return files
