"""Moment arms over the angle, a muscle at a time, passive and active."""

from pathlib import Path

import pandas as pd

from ..figures.style import muscle_label
from .effects_part import tables_in
from .parts import Axis, Chart, Section
from .written import read_rows, written_table

NAME, ACTIVE = "moment_arms", "_active"
LOOKS = {"passive": {"label": "passive", "dash": "solid", "colour": "#D55E00"},
         "active": {"label": "active", "dash": "dashed", "colour": "#0072B2"}}


def is_moment_arms(folder: Path) -> bool:
    return (tables_in(folder) / f"{NAME}.csv").is_file()


def moment_arms_section(folder: Path) -> Section:
    tables = tables_in(folder)
    rows = [_course(path) for path in sorted(tables.glob(f"{NAME}_*.csv"))]
    charts = [_chart(pd.concat(rows, ignore_index=True))] if rows else []
    muscles = list(dict.fromkeys(muscle_label(course["muscle"].iloc[0]) for course in rows))
    return Section(NAME, "Moment arms in flexion", [("Muscles", ", ".join(muscles))], [],
                   [*charts, *written_table(tables, NAME, "Moment arms and published values")], LOOKS, folder)


def _course(path: Path) -> pd.DataFrame:
    name = path.stem.removeprefix(f"{NAME}_")
    return read_rows(path).assign(muscle=name.removesuffix(ACTIVE), backend="active" if name.endswith(ACTIVE) else "passive")


def _chart(rows: pd.DataFrame) -> Chart:
    return Chart("courses", "Moment arm over the angle", "Mean over the fibres of a muscle. Hover over a point for the 10th and 90th percentile.",
                 "lines", rows, Axis("angle_deg", "flexion (degrees)"), Axis("mean_mm", "moment arm dL/d(flexion) (mm)"),
                 {"p10_mm": "10th percentile (mm)", "p90_mm": "90th percentile (mm)"})
