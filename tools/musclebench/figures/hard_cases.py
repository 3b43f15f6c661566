"""The matrix of hard cases as a picture, and a strip of each scene that they move."""

from pathlib import Path

import pandas as pd
from matplotlib.patches import Rectangle

from ..pictures.surface_pictures import read_snapshots
from ..results.run_folder import Run
from . import style
from .effect_scenes import draw_snapshot
from .style import plt

COLOURS = {"holds": "#5b9a68", "breaks": "#c4473a", "refused": "#d9a441", "not applicable": "#ededed"}
ROW_INCHES = 0.19
PANEL_INCHES = 1.75
MOMENTS = ("at rest", "worst frame", "at the end")


def draw_matrix(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """`rows`: those of matrix.csv."""
    style.apply_style()
    cells = rows.drop_duplicates(["case", "backend"])
    cases, backends = list(cells["case"].unique()), list(cells["backend"].unique())
    figure, axes = plt.subplots(figsize=(style.PAGE_INCHES, ROW_INCHES * (len(cases) + 4)))
    for cell in cells.itertuples():
        x, y = backends.index(cell.backend), cases.index(cell.case)
        axes.add_patch(Rectangle((x + 0.04, y + 0.06), 0.92, 0.88, color=COLOURS[cell.verdict]))
        if cell.verdict != "not applicable":
            axes.text(x + 0.5, y + 0.5, cell.verdict, ha="center", va="center", fontsize=style.SMALLEST_POINTS,
                      color="black" if cell.verdict == "refused" else "white")
    axes.set(xlim=(0, len(backends)), ylim=(len(cases), 0))
    axes.set_xticks([i + 0.5 for i in range(len(backends))], [name.replace("_", " ") for name in backends])
    axes.set_yticks([i + 0.5 for i in range(len(cases))], cases)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)
    figure.tight_layout()
    style.add_note(figure, "Empty: not applicable. Refused: the figure is beyond its bar, and the program says so.")
    return style.save_figure(figure, stem)


def draw_strips(runs: list[Run], stem: Path) -> list[Path]:
    """A row each: at rest, in the worst frame, at the end."""
    if not runs:
        return []
    style.apply_style()
    size = (3 * PANEL_INCHES + 0.3, len(runs) * PANEL_INCHES)
    figure, panels = plt.subplots(len(runs), len(MOMENTS), figsize=size, squeeze=False)
    for row, run in zip(panels, runs):
        shown = read_snapshots(run)
        chosen = [shown[0], shown[len(shown) // 2], shown[-1]]
        for axes, snapshot, moment in zip(row, chosen, MOMENTS):
            draw_snapshot(axes, run, snapshot)
            axes.set_title(f"{run.scene.split('/')[-1].replace('_', ' ')}, {moment}", loc="left", fontsize=7)
    figure.tight_layout(w_pad=0.3, h_pad=0.5)
    return style.save_figure(figure, stem)
