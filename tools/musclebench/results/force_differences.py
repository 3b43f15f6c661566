"""How far the forces of two runs are apart."""

import math

import numpy as np
import pandas as pd

from .run_folder import Run

FORCE = ["force_x_n", "force_y_n", "force_z_n"]
RULE = (
    "Errors are over all frames: the root mean square of the difference from the exact run, in percent of the root mean square "
    "of the exact run. Joint torque: about the axis of a bone that turns, of all attachments and contacts. Contact force: of each "
    "muscle and bone, as a vector. Peak pressure: the largest of a node in a frame. Map: pressure over the surfaces of bones, at the "
    "moments that were kept."
)


def force_differences(run: Run, reference: Run) -> dict[str, float]:
    """{torque_percent, contact_percent, pressure_percent, map_percent}; NaN where the exact run has no such force, empty where one of the runs
    tells no forces."""
    if run.forces.empty or reference.forces.empty:
        return {}
    return {
        "torque_percent": _off_percent(*(_joints(one) for one in (run, reference))),
        "contact_percent": _off_percent(*(_contacts(one)[FORCE] for one in (run, reference))),
        "pressure_percent": _off_percent(*(_contacts(one)["peak_pressure_pa"].groupby("frame").max() for one in (run, reference))),
        "map_percent": _maps_off_percent(run, reference),
    }


def _maps_off_percent(run: Run, reference: Run) -> float:
    """NaN where one of both tells none: its contacts have no forces."""
    is_told = all("bone_pressure" in entry for one in (run, reference) for entry in one.record.get("snapshots", []))
    if not is_told:
        return float("nan")
    kept = [{entry["frame"] for entry in one.record.get("snapshots", [])} for one in (run, reference)]
    return maps_off_percent(*(_at(kept[0] & kept[1], bone_pressures(one)) for one in (run, reference)))


def _at(frames: set[int], pressures: pd.DataFrame) -> pd.DataFrame:
    return pressures[pressures.index.get_level_values("frame").isin(frames)]


def bone_pressures(run: Run) -> pd.DataFrame:
    """pressure_pa and area_m2, by frame, bone and vertex, of what was pressed at the moments that the run kept."""
    tables = [pd.read_csv(run.folder / entry["bone_pressure"], dtype={"bone": str}).assign(frame=entry["frame"])
              for entry in run.record.get("snapshots", []) if "bone_pressure" in entry]
    rows = pd.concat(tables) if tables else pd.DataFrame(columns=["frame", "bone", "vertex", "pressure_pa", *FORCE])
    force_n = np.linalg.norm(rows[FORCE].to_numpy(dtype=float), axis=1)
    return rows.assign(area_m2=force_n / rows["pressure_pa"]).set_index(["frame", "bone", "vertex"])[["pressure_pa", "area_m2"]]


def maps_off_percent(ours: pd.DataFrame, theirs: pd.DataFrame) -> float:
    """Over the area, at the same moments. What one of both does not press has no pressure there."""
    both = ours.join(theirs, how="outer", lsuffix="_ours")
    area_m2 = both[["area_m2", "area_m2_ours"]].max(axis=1)
    exact_pa = both["pressure_pa"].fillna(0)
    size = float((area_m2 * exact_pa**2).sum())
    off = float((area_m2 * (both["pressure_pa_ours"].fillna(0) - exact_pa)**2).sum())
    return 100 * math.sqrt(off / size) if size > 0 else float("nan")


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
