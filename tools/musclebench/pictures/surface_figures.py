"""Fig. 6 (shape and depth of the iliacus, or of the first muscle), all muscles at full flexion, and the attachments."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np
import pandas as pd
from matplotlib import cm, colors
from matplotlib.ticker import FuncFormatter, MaxNLocator

from ..figures import looks, style
from ..figures.paper_figures import caption, muscle_of_figures
from ..figures.style import plt
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_snapshots
from ..tables.paper_tables import by_case
from .surface_pictures import (
    ATTACHMENT_COLOURS, DEPTH_COLOURS, INSIDE_FROM_MM, MUSCLE_COLOURS, Studio, bound_nodes_by_bone, facing_inside,
)


DEEPEST_SHOWN_MM = 5
PICTURE_SHARE = 1.12  # height of a row of pictures, with its words, over their width


@dataclass
class Moments:
    """The snapshots that the pictures show."""

    rest: Snapshot
    half: Snapshot
    full: Snapshot


def draw_surface_figures(runs: list[Run], folder: Path, say: Callable[[str], None]) -> list[Path]:
    """Figures of the runs that left snapshots. Returns the files; `say` hears what is being drawn."""
    style.apply_style()
    cases = {case: run for case, run in by_case(runs).items() if run.record.get("snapshots")}
    moments = {case: choose_moments(read_snapshots(run)) for case, run in cases.items()}
    moments = {case: chosen for case, chosen in moments.items() if chosen is not None}
    muscles = list(dict.fromkeys(muscle for muscle, _ in moments))
    studios = {muscle: Studio(next(cases[case] for case in moments if case[0] == muscle)) for muscle in muscles}
    shown = [cases[case] for case in moments]
    files: list[Path] = []
    if moments:
        muscle = muscle_of_figures(muscles)
        of_muscle = {backend: chosen for (name, backend), chosen in moments.items() if name == muscle}
        files += _draw_muscle(studios[muscle], muscle, of_muscle, shown, folder, say)
        files += _draw_full_flexion(studios, moments, shown, folder, say)
        for name in muscles:
            run = _best_shaped([cases[case] for case in moments if case[0] == name])
            if len(run.record.get("muscles", [])) > 1:
                files += _draw_several(studios[name], name, run, folder, say)
        files += _draw_attachments(studios, cases, moments, shown, folder, say)
    return files


def choose_moments(snapshots: list[Snapshot]) -> Moments | None:
    """Rest is the first snapshot, full the one that is turned farthest from it, whichever way, half the one nearest to
    half of that turn."""
    if not snapshots:
        return None
    rest = snapshots[0]
    full = max(snapshots, key=lambda s: abs(s.angle_deg - rest.angle_deg))
    half = min(snapshots, key=lambda s: abs(s.angle_deg - (rest.angle_deg + full.angle_deg) / 2))
    return Moments(rest, half, full)


def depth_scale_mm(moments: dict) -> float:
    """Upper end of the colour scale: the greatest depth with collision handling, but no more than shows small ones."""
    depths = [
        snapshot.depth_mm.max()
        for case, chosen in moments.items()
        for snapshot in (chosen.rest, chosen.half, chosen.full)
        if not looks.backend(case if isinstance(case, str) else case[-1]).is_control
    ]
    return min(math.ceil(max([1.0, *depths])), DEEPEST_SHOWN_MM)


def _draw_muscle(studio: Studio, muscle: str, moments: dict[str, Moments], runs, folder: Path, say) -> list[Path]:
    deepest_mm = depth_scale_mm(moments)
    studio.hold_close([shot for chosen in moments.values() for shot in (chosen.half, chosen.full)])
    size = (style.PAGE_INCHES, 1.36 * len(moments) + 0.7)
    figure, panels = plt.subplots(len(moments), 5, figsize=size, squeeze=False)
    for row, (backend, chosen) in enumerate(moments.items()):
        say(f"Fig. 6, {backend}")
        pictures = [studio.overview(s, deepest_mm) for s in (chosen.rest, chosen.half, chosen.full)]
        pictures += [studio.close_up(s, deepest_mm) for s in (chosen.half, chosen.full)]
        for column, picture in enumerate(pictures):
            _show(panels[row, column], picture)
        _row_name(panels[row, 0], looks.title(backend), looks.colour(backend))
        for column, snapshot in ((3, chosen.half), (4, chosen.full)):
            _note_depth(panels[row, column], snapshot)
    first = next(iter(moments.values()))
    heads = [("rest", first.rest), ("half flexion", first.half), ("full flexion", first.full),
             ("half, joint", first.half), ("full, joint", first.full)]
    for column, (text, snapshot) in enumerate(heads):
        panels[0, column].set_title(f"{text} ({_degrees(snapshot.angle_deg)})", fontsize=7)
    title = f"Fig. 6  {style.muscle_label(muscle).capitalize()}; left the muscle, right the joint from the other side"
    _finish(figure, title, runs, deepest_mm, " and the muscle, in the two columns on the right")
    rows = _depth_rows({(muscle, backend): chosen for backend, chosen in moments.items()})
    return _save(figure, rows, folder / f"fig_6_{muscle}")


def _draw_full_flexion(studios, moments, runs, folder: Path, say) -> list[Path]:
    backends = list(dict.fromkeys(backend for _, backend in moments))
    deepest_mm = depth_scale_mm(moments)
    size = (style.PAGE_INCHES, PICTURE_SHARE * (style.PAGE_INCHES - 1.0) / len(backends) * len(studios) + 0.7)
    figure, panels = plt.subplots(len(studios), len(backends), figsize=size, squeeze=False)
    for row, (muscle, studio) in enumerate(studios.items()):
        say(f"full flexion, {style.muscle_label(muscle)}")
        facing = facing_inside([chosen.full for (name, _), chosen in moments.items() if name == muscle])
        for column, backend in enumerate(backends):
            chosen = moments.get((muscle, backend))
            if chosen is None:
                _show_missing(panels[row, column])
                continue
            _show(panels[row, column], studio.inside(chosen.full, deepest_mm, facing))
            _note_depth(panels[row, column], chosen.full)
        _row_name(panels[row, 0], style.muscle_label(muscle), "black")
    for column, backend in enumerate(backends):
        panels[0, column].set_title(looks.title(backend), fontsize=8, fontweight="bold", color=looks.colour(backend))
    angle = max((chosen.full.angle_deg for chosen in moments.values()), key=abs)
    _finish(figure, f"All muscles at full flexion ({_degrees(angle)})", runs, deepest_mm,
            " and the muscle, from the side on which most of them are")
    return _save(figure, _depth_rows(moments), folder / "muscles_at_full_flexion")


def _best_shaped(runs: list[Run]) -> Run:
    """With collisions, if there is one: the run that stretched its edges least."""
    colliding = [run for run in runs if not looks.backend(run.backend).is_control]
    return min(colliding or runs, key=lambda run: run.record.get("outcome", {}).get("max_edge_stretch") or math.inf)


def _draw_several(studio: Studio, scene: str, run: Run, folder: Path, say) -> list[Path]:
    """Each muscle in its colour, from both sides: at rest, half and full flexion and at the end of one run."""
    kept = read_snapshots(run)
    chosen = choose_moments(kept)
    snapshots = list({shot.frame: shot for shot in (chosen.rest, chosen.half, chosen.full, kept[-1])}.values())
    muscles = run.record["muscles"]
    counts, names = [muscle["vertices"] for muscle in muscles], [muscle["name"] for muscle in muscles]
    figure, panels = plt.subplots(2, len(snapshots), squeeze=False,
                                  figsize=(style.PAGE_INCHES, 2 * style.PAGE_INCHES / max(len(snapshots), 3) + 0.6))
    figure.subplots_adjust(left=0.05, right=0.99, top=0.88, bottom=0.11, wspace=0.02, hspace=0.02)
    for column, snapshot in enumerate(snapshots):
        say(f"{style.muscle_label(scene)}, {_degrees(snapshot.angle_deg)}")
        for row in range(2):
            picture = studio.muscles(snapshot, counts, from_behind=row == 1)
            _show(panels[row, column], picture)
            if snapshot is chosen.half and row == 0:
                paths = draw_half_flexion(picture, names, folder / f"half_flexion_of_{scene}")
        panels[0, column].set_title(f"frame {snapshot.frame}, {_degrees(snapshot.angle_deg)}", fontsize=7)
    for row, text in enumerate(("muscle's side", "other side")):
        _row_name(panels[row, 0], text, "black")
    _name_muscles(figure, names, len(names), (0.5, 0.03))
    figure.suptitle(f"{style.muscle_label(scene).capitalize()} with {looks.title_and_name(run.backend)}", x=0.02, ha="left", y=0.99, va="top")
    style.add_note(figure, caption([run]), y=0.0)
    rows = pd.DataFrame([{"frame": s.frame, "angle_deg": s.angle_deg} for s in snapshots])
    return [*paths, *_save(figure, rows, folder / f"muscles_of_{scene}")]


def draw_half_flexion(picture: np.ndarray, muscles: list[str], stem: Path) -> list[Path]:
    """One view of all muscles, small enough to stand beside text."""
    figure, panel = plt.subplots(figsize=(style.COLUMN_INCHES, style.COLUMN_INCHES))
    _show(panel, picture)
    figure.subplots_adjust(left=0, right=1, top=1, bottom=0.17)
    _name_muscles(figure, muscles, 2, (0.5, 0.0), points=9)
    return style.save_figure(figure, stem)


def _name_muscles(figure, names: list[str], columns: int, anchor: tuple[float, float], points: float = 7) -> None:
    marks = [plt.Line2D([], [], marker="o", linestyle="", color=MUSCLE_COLOURS[i % len(MUSCLE_COLOURS)] / 255)
             for i in range(len(names))]
    figure.legend(marks, [style.muscle_label(name) for name in names], ncols=columns, fontsize=points, loc="lower center",
                  bbox_to_anchor=anchor, frameon=False)


def _draw_attachments(studios, cases, moments, runs, folder: Path, say) -> list[Path]:
    width = style.PAGE_INCHES
    height = (width - 0.2) / max(len(studios), 3) + 0.9
    figure, panels = plt.subplots(1, len(studios), figsize=(width, height), squeeze=False)
    left, bottom, top = 0.1 / width, 0.35 / height, 0.55 / height
    figure.subplots_adjust(left=left, right=1 - left, top=1 - top, bottom=bottom, wspace=0.05)
    rows = []
    for panel, (muscle, studio) in zip(panels[0], studios.items()):
        say(f"attachments, {style.muscle_label(muscle)}")
        case = next(case for case in moments if case[0] == muscle)
        rest = moments[case].rest
        groups = bound_nodes_by_bone(rest, studio.bones)
        _show(panel, studio.attachments(rest, list(groups.values())))
        panel.set_title(style.muscle_label(muscle))
        listed = [{"muscle": muscle, **entry} for entry in cases[case].record.get("attachments", [])]
        rows += listed
        lines = [f"{entry['name']} ({entry['bone']}): {entry['nodes']} nodes" for entry in listed]
        panel.text(0.0, -0.03, "\n".join(lines), transform=panel.transAxes, va="top", fontsize=7)
    figure.suptitle("Bound nodes at rest, seen through the muscle", x=left, y=1 - 0.05 / height, ha="left", va="top")
    _bone_legend(figure, next(iter(studios.values())), (left, 1 - 0.2 / height))
    style.add_note(figure, caption(runs), y=0.0)
    return _save(figure, pd.DataFrame(rows), folder / "attachments")


def _bone_legend(figure, studio: Studio, anchor) -> None:
    marks = [plt.Line2D([], [], marker="o", linestyle="", color=c) for c, _ in zip(ATTACHMENT_COLOURS, studio.bones)]
    names = [f"nearest to {name}" for name in studio.bones]
    figure.legend(marks, names, ncols=len(names), loc="upper left", bbox_to_anchor=anchor, borderaxespad=0,
                  frameon=False)


def _degrees(angle_deg: float) -> str:
    """Of a frame: seldom the round number that was aimed at."""
    return f"{round(angle_deg, 1) + 0.0:g}°"


def _show(panel, picture: np.ndarray) -> None:
    panel.imshow(picture, interpolation="antialiased")
    panel.set_axis_off()


def _show_missing(panel) -> None:
    panel.text(0.5, 0.5, "no snapshot", ha="center", va="center", color="#888888", transform=panel.transAxes)
    panel.set_axis_off()


def _row_name(panel, text: str, colour) -> None:
    panel.text(-0.04, 0.5, text, rotation=90, ha="right", va="center", fontsize=8, fontweight="bold", color=colour,
               transform=panel.transAxes)


def _note_depth(panel, snapshot: Snapshot) -> None:
    depth = snapshot.depth_mm
    inside = int(np.count_nonzero(depth > INSIDE_FROM_MM))
    text = f"{inside} inside, {max(depth.max(), 0.0):.2f} mm" if inside else "no node inside"
    panel.text(0.5, -0.01, text, ha="center", va="top", fontsize=7, transform=panel.transAxes)


def _finish(figure, title: str, runs, deepest_mm: float, where: str = "") -> None:
    """`where`: in which of the pictures."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(wspace=0.03, hspace=0.12, left=0.25 / width, right=1 - 0.75 / width, bottom=0.2 / height,
                           top=1 - 0.4 / height)
    figure.suptitle(title, x=0.05 / width, y=1 - 0.05 / height, ha="left", va="top")
    scale = cm.ScalarMappable(colors.Normalize(0, deepest_mm), DEPTH_COLOURS)
    bar = figure.colorbar(scale, cax=figure.add_axes([1 - 0.66 / width, 0.3, 0.1 / width, 0.4]), extend="max",
                          ticks=MaxNLocator(5, steps=[1, 2, 5, 10]), format=FuncFormatter(lambda mm, _: f"{mm:g}"))
    bar.set_label(f"depth in a bone (mm)\nred: outside or less than {INSIDE_FROM_MM} mm")
    style.add_note(figure, f"{caption(runs)}. Bones are cut beside the muscle for sight. "
                   f"Balls: nodes inside a bone, seen through it{where}.", y=0.0)


def _depth_rows(moments: dict) -> pd.DataFrame:
    rows = []
    for (muscle, backend), chosen in moments.items():
        for moment in ("rest", "half", "full"):
            snapshot = getattr(chosen, moment)
            inside = snapshot.depth_mm[snapshot.depth_mm > 0]
            rows.append({
                "muscle": muscle, "backend": backend, "moment": moment, "frame": snapshot.frame,
                "angle_deg": snapshot.angle_deg, "nodes_inside": len(inside),
                "largest_depth_mm": inside.max() if len(inside) else 0.0,
                "mean_depth_mm": inside.mean() if len(inside) else 0.0,
            })
    return pd.DataFrame(rows)


def _save(figure, rows: pd.DataFrame, stem: Path) -> list[Path]:
    table = stem.with_suffix(".csv")
    rows.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]
