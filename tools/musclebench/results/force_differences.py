"""How far the forces of two runs are apart."""

import numpy as np
import pandas as pd

from .run_folder import Run

RULE = (
    "Errors are over all frames: the root mean square of the difference from the exact run, in percent of the root mean square "
    "of the exact run. Joint torque: about the axis of a bone that turns, of all attachments and contacts. Contact force: of each "
    "muscle and bone, as a vector. Peak pressure: the largest of a node in a frame."
)


def force_differences(run: Run, reference: Run) -> dict[str, float]:
    """{torque_percent, contact_percent, pressure_percent}; NaN where the exact run has no such force, empty where one of the runs
    tells no forces."""
    if run.forces.empty or reference.forces.empty:
        return {}
    return {
        "torque_percent": _off_percent(*(_joints(one) for one in (run, reference))),
        "contact_percent": _off_percent(*(_contacts(one)[["force_x_n", "force_y_n", "force_z_n"]] for one in (run, reference))),
        "pressure_percent": _off_percent(*(_contacts(one)["peak_pressure_pa"].groupby("frame").max() for one in (run, reference))),
    }


def _joints(run: Run) -> pd.Series:
    return run.forces[run.forces["source"] == "joint"].set_index(["frame", "other"])["torque_n_m"]


def _contacts(run: Run) -> pd.DataFrame:
    return run.forces[run.forces["source"] == "bone"].set_index(["frame", "muscle", "other"])


def _off_percent(ours: pd.DataFrame | pd.Series, theirs: pd.DataFrame | pd.Series) -> float:
    both = theirs.index.intersection(ours.index)
    size = float(np.sqrt(np.mean(np.square(theirs.loc[both].to_numpy())))) if len(both) else 0.0
    if not size > 0:
        return float("nan")
    return 100 * float(np.sqrt(np.mean(np.square(ours.loc[both].to_numpy() - theirs.loc[both].to_numpy())))) / size
