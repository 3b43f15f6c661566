"""Errors of the forces of each configuration."""

import pandas as pd

from ..accuracy.aggregates import Aggregate
from ..accuracy.force_errors import RULE
from ..results.disturbance import MARK
from .table_formats import Column, Table

COLUMNS = [
    Column("muscle", "muscle"), Column("configuration", "configuration"), Column("status", "status"),
    Column("time_ms", "ms a frame", 3, "ms a\nframe"),
    Column("torque_percent", "joint torque, RMS %", 2, "torque\nRMS %"),
    Column("torque_floor_percent", "floor of the torque %", 2, "floor\n%"),
    Column("contact_percent", "contact force, RMS %", 2, "contact\nRMS %"),
    Column("pressure_percent", "peak pressure, RMS %", 2, "pressure\nRMS %"),
    Column("pressure_floor_percent", "floor of the pressure %", 2, "floor\n%"),
    Column("map_percent", "pressure map, RMS %", 2, "map\nRMS %"), Column("map_floor_percent", "floor of the map %", 2, "floor\n%"),
    Column("detail", "detail"),
]


def force_table(timed: list[Aggregate], errors: dict) -> Table:
    """A row a muscle and configuration. `timed`: coupled runs that told no forces; `errors` as accuracy.force_errors gives them.
    Empty where no run told forces."""
    rows = [{"muscle": one.muscle, "configuration": one.configuration.name + (MARK if one.is_disturbed else ""),
             "status": one.status, "time_ms": one.collision_ms.value, "detail": one.detail, **errors[(one.scene, one.configuration)]}
            for one in timed if (one.scene, one.configuration) in errors]
    caption = (
        "Forces against those of the exact run, each configuration moving its own muscle. "
        f"{RULE} Scenes of the program with the preset standard: with the paper's constants forces mean nothing."
    )
    return Table("force_errors", caption, COLUMNS, pd.DataFrame(rows, columns=[column.key for column in COLUMNS]),
                 [column.key for column in COLUMNS if column.key not in ("muscle", "detail", "status")])
