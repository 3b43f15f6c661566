"""The matrix of hard cases as a picture, its counts, and a strip of each scene that they move."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.collections import PolyCollection
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke

from ..results.run_folder import Run
from ..results.snapshots import read_bones, read_snapshots
from . import looks, style
from .cuts import cut
from .effect_scenes import BONE_COLOUR, MUSCLE_COLOURS
from .style import plt

COLOURS = {"holds": "#5b9a68", "breaks": "#c4473a", "refused": "#d9a441", "not applicable": "#ededed"}
ROW_INCHES = 0.19
STRIP_INCHES = 1.5
SCENES_A_ROW = 2
MOMENTS = ("start", "worst", "end")
AROUND = 1.5  # of what is shown, over the size of the muscle: the bones beside it are seen, too
SHADOW_COLOUR, MUSCLE_EDGE, BONE_EDGE = "#EBCFCB", "#6b2a24", "#8a7c52"


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
    axes.set_xticks([i + 0.5 for i in range(len(backends))], [looks.title(name).replace(" ", "\n") for name in backends])
    axes.set_yticks([i + 0.5 for i in range(len(cases))], cases)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)
    figure.tight_layout()
    style.add_note(figure, "Empty: not applicable. Refused: the figure is beyond its bar, and the program says so.")
    return style.save_figure(figure, stem)


def draw_counts(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """How many cases each backend holds, breaks and refuses; of those that ask it. `rows`: those of matrix.csv."""
    style.apply_style()
    cells = rows.drop_duplicates(["case", "backend"])
    asked = [verdict for verdict in COLOURS if verdict != "not applicable"]
    table = pd.crosstab(cells["backend"], cells["verdict"]).reindex(index=cells["backend"].unique(), columns=asked, fill_value=0)
    figure, axes = plt.subplots(figsize=(style.PAGE_INCHES, ROW_INCHES * len(table) + 0.7))
    left = pd.Series(0, index=table.index)
    for verdict in asked:
        axes.barh(range(len(table)), table[verdict], left=left, color=COLOURS[verdict], height=0.85, label=verdict)
        for line, (start, count) in enumerate(zip(left, table[verdict])):
            if count:
                axes.text(start + count / 2, line, str(count), ha="center", va="center", fontsize=style.SMALLEST_POINTS,
                          color="black" if verdict == "refused" else "white")
        left += table[verdict]
    axes.set_yticks(range(len(table)), [looks.title(name) for name in table.index])
    axes.set(ylim=(len(table) - 0.4, -0.6), xlabel="cases that ask the backend")
    axes.tick_params(axis="y", length=0)
    axes.grid(False)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=len(asked), frameon=False)
    figure.tight_layout(pad=0.3)
    return style.save_figure(figure, stem)


def draw_strips(runs: list[Run], stem: Path) -> list[Path]:
    """Two scenes a row, each at its start, in its worst frame and at its end, cut through the middle of the muscle."""
    if not runs:
        return []
    style.apply_style()
    rows = math.ceil(len(runs) / SCENES_A_ROW)
    figure = plt.figure(figsize=(style.PAGE_INCHES, rows * STRIP_INCHES))
    halves = figure.add_gridspec(1, SCENES_A_ROW, wspace=0.06, left=0.01, right=0.99, top=0.98, bottom=0.01)
    for column, half in enumerate(halves):
        grid = half.subgridspec(rows, len(MOMENTS), wspace=0.06, hspace=0.3)
        for row, run in enumerate(runs[column::SCENES_A_ROW]):
            _draw_strip([figure.add_subplot(grid[row, moment]) for moment in range(len(MOMENTS))], run)
    backends = ", ".join(dict.fromkeys(looks.title_and_name(run.backend) for run in runs))
    style.add_note(figure, f"Cut through the middle of the muscle (red) and the bones (tan); pale: all of the muscle, from the "
                   f"side; dashed: where it begins. Moved with {backends}; beside the name stands how the run ended.", y=-0.005)
    return style.save_figure(figure, stem)


def _draw_strip(panels: list, run: Run) -> None:
    shown = read_snapshots(run)
    chosen = [shown[0], shown[len(shown) // 2], shown[-1]]
    bones = list(read_bones(run).values())
    start_m = shown[0].mesh.vertices_m
    at_y_m = (start_m[:, 1].min() + start_m[:, 1].max()) / 2
    start = cut(start_m, shown[0].mesh.triangles, at_y_m)
    name = f"{run.scene.split('/')[-1].replace('_', ' ')}: {run.status}"
    for number, (axes, snapshot, moment) in enumerate(zip(panels, chosen, MOMENTS)):
        muscle = snapshot.mesh
        axes.add_collection(PolyCollection(muscle.vertices_m[muscle.triangles][:, :, [0, 2]], facecolors=SHADOW_COLOUR,
                                           edgecolors=SHADOW_COLOUR, linewidths=0.2, rasterized=True, zorder=2))
        for bone, (rotation, translation_m) in zip(bones, snapshot.poses):
            outlines = cut(bone.vertices_m @ rotation.T + translation_m, bone.triangles, at_y_m)
            _add_outlines(axes, outlines, facecolor=BONE_COLOUR, linewidth=0, zorder=1)
            _add_outlines(axes, outlines, facecolor="none", edgecolor=BONE_EDGE, linewidth=0.8, zorder=4)
        outlines = cut(muscle.vertices_m, muscle.triangles, at_y_m)
        _add_outlines(axes, outlines, facecolor=MUSCLE_COLOURS[0], linewidth=0, zorder=3)
        # Over the bones' edges: a muscle that is squeezed flat is nothing but an edge.
        _add_outlines(axes, outlines, facecolor="none", edgecolor=MUSCLE_EDGE, linewidth=0.8, zorder=5)
        _add_outlines(axes, start, facecolor="none", edgecolor="black", linewidth=0.6, linestyle=(0, (2, 1.5)), zorder=6)
        _frame(axes, np.vstack([start_m, muscle.vertices_m])[:, [0, 2]])
        axes.set_title(f"{'' if number else name}\n{moment}, frame {snapshot.frame}", loc="left", fontsize=7, pad=2)


def _add_outlines(axes, outlines: list[np.ndarray], **look) -> None:
    """Those of one surface as one shape, so that a hole is one."""
    loops = [Outline(np.vstack([one, one[:1]]), closed=True) for one in outlines]
    if loops:
        axes.add_patch(PathPatch(Outline.make_compound_path(*loops), **look))


def _frame(axes, seen_m: np.ndarray) -> None:
    """Around these points, with a scale: a muscle that was thrown far away is drawn smaller."""
    middle, reach_m = (seen_m.max(axis=0) + seen_m.min(axis=0)) / 2, AROUND * np.ptp(seen_m, axis=0).max() / 2
    axes.set(xlim=middle[0] + np.array([-reach_m, reach_m]), ylim=middle[1] + np.array([-reach_m, reach_m]),
             aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for side in axes.spines.values():
        side.set(visible=True, color="#bbbbbb")
    length_m = 0.01 if reach_m < 0.1 else 0.1
    x, y = middle - 0.88 * reach_m
    halo = [withStroke(linewidth=3, foreground="white")]
    axes.plot([x, x + length_m], [y, y], color="black", linewidth=1.2, zorder=7, path_effects=halo)
    axes.text(x + length_m + 0.06 * reach_m, y, f"{1e3 * length_m:.0f} mm", fontsize=style.SMALLEST_POINTS,
              va="center_baseline", zorder=7, path_effects=halo)
