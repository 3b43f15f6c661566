"""Fibres in their muscle as tubes coloured by stretch, a row a muscle, from rest to full flexion."""

from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np
import pandas as pd
import vtk
from matplotlib import cm, colors
from vtk.util.numpy_support import vtk_to_numpy

from ..figures import style
from ..figures.paper_figures import caption
from ..figures.style import muscle_label, plt
from ..results.run_folder import ResultProblem, Run
from ..results.snapshots import Snapshot, read_snapshots
from .surface_pictures import Studio

STRETCH_COLOURS = colors.LinearSegmentedColormap.from_list("stretch", ["#2166ac", "#92c5de", "#f7f7f7", "#f4a582", "#b2182b"])
SMALLEST_RANGE = 0.1  # of the colours, about a stretch of 1


@dataclass
class Fibres:
    lines: list[np.ndarray]  # (n, 3) each, m
    stretch: np.ndarray  # of each: its length over that at rest


def read_fibres(path: Path) -> Fibres:
    """Of a snapshot: snapshots/fibres_FRAME.vtk."""
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(path))
    reader.ReadAllScalarsOn()
    reader.Update()
    data = reader.GetOutput()
    stretch = data.GetCellData().GetArray("stretch")
    if stretch is None or data.GetNumberOfLines() == 0:
        raise ResultProblem(f"{path}: holds no fibres; run the case again")
    points = vtk_to_numpy(data.GetPoints().GetData())
    ends = vtk_to_numpy(data.GetLines().GetOffsetsArray())[1:-1]
    corners = vtk_to_numpy(data.GetLines().GetConnectivityArray())
    return Fibres([points[part] for part in np.split(corners, ends)], vtk_to_numpy(stretch))


def fibres_of(run: Run) -> dict[int, Fibres]:
    """By frame, of the snapshots that have some."""
    return {entry["frame"]: read_fibres(run.folder / entry["fibres"])
            for entry in run.record.get("snapshots", []) if "fibres" in entry}


def stretch_colours(stretch: np.ndarray, scale: colors.Normalize) -> np.ndarray:
    """(n, 3) bytes."""
    return (255 * STRETCH_COLOURS(scale(stretch))[:, :3]).astype(np.uint8)


def stretch_scale(stretches: list[np.ndarray]) -> colors.Normalize:
    """White where a fibre is as long as at rest, the same to both sides."""
    most = max([SMALLEST_RANGE, *(float(np.abs(stretch - 1).max()) for stretch in stretches)])
    most = np.ceil(10 * most) / 10
    return colors.Normalize(1 - most, 1 + most)


def name_of(run: Run) -> str:
    """Its muscle, and whether it is active."""
    is_active = {"activation", "fibre_force"} & set(run.record["case"]["effects"])
    return f"{run.muscle}, active" if is_active else run.muscle


def draw_fibres(runs: dict[str, Run], stem: Path, say: Callable[[str], None]) -> list[Path]:
    """`runs`: by name, with snapshots; those without fibres are left out."""
    shown = {muscle: (read_snapshots(run), fibres_of(run)) for muscle, run in runs.items()}
    shown = {muscle: found for muscle, found in shown.items() if found[0] and found[1]}
    if not shown:
        return []
    style.apply_style()
    scale = stretch_scale([fibres.stretch for _, by_frame in shown.values() for fibres in by_frame.values()])
    columns = max(len(snapshots) for snapshots, _ in shown.values())
    width, left, right = style.PAGE_INCHES, 0.25, 0.75
    height = (width - left - right) / columns * len(shown) * 1.06 + 0.75
    figure, panels = plt.subplots(len(shown), columns, figsize=(width, height), squeeze=False)
    figure.subplots_adjust(left=left / width, right=1 - right / width, top=1 - 0.45 / height, bottom=0.25 / height,
                           wspace=0.03, hspace=0.1)
    rows = []
    for row, (muscle, (snapshots, by_frame)) in zip(panels, shown.items()):
        say(f"fibres, {muscle_label(muscle)}")
        studio = Studio(runs[muscle])
        for panel in row:
            panel.set_axis_off()
        for panel, snapshot in zip(row, snapshots):
            if snapshot.frame in by_frame:
                rows.append(_draw(panel, studio, muscle, snapshot, by_frame[snapshot.frame], scale))
        row[0].text(-0.04, 0.5, muscle_label(muscle), rotation=90, ha="right", va="center", fontsize=8, fontweight="bold",
                    transform=row[0].transAxes)
    figure.suptitle("Fibres, coloured by their length over that at rest", x=0.05 / width, y=1 - 0.05 / height, ha="left",
                    va="top")
    bar = figure.colorbar(cm.ScalarMappable(scale, STRETCH_COLOURS),
                          cax=figure.add_axes([1 - 0.66 / width, 0.3, 0.1 / width, 0.4]))
    bar.set_label("length / length at rest")
    style.add_note(figure, f"{caption(list(runs.values()))}. Bones are cut beside the muscle for sight.", y=0.0)
    table = stem.with_suffix(".csv")
    pd.DataFrame(rows).to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def _draw(panel, studio: Studio, muscle: str, snapshot: Snapshot, fibres: Fibres, scale: colors.Normalize) -> dict:
    panel.imshow(studio.fibres(snapshot, fibres.lines, stretch_colours(fibres.stretch, scale)), interpolation="antialiased")
    least, middle, most = fibres.stretch.min(), float(np.mean(fibres.stretch)), fibres.stretch.max()
    panel.text(0.5, -0.01, f"{round(snapshot.angle_deg, 1) + 0.0:g}°, stretch {least:.2f} to {most:.2f}", ha="center",
               va="top", fontsize=7, transform=panel.transAxes)
    return {"muscle": muscle, "frame": snapshot.frame, "angle_deg": snapshot.angle_deg, "fibres": len(fibres.lines),
            "min_stretch": least, "mean_stretch": middle, "max_stretch": most}
