"""Figures drawn from frames.csv: collision time (Fig. 7), memory (Fig. 8) and true depth by frame."""

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from ..paper.published import Published
from ..results.disturbance import waits
from ..results.licences import licences_of
from ..results.run_folder import Run
from ..tables.paper_tables import MEGABYTE, by_case, collision_ratio
from ..tables.table_formats import as_ratio
from . import looks, style
from .style import plt

MUSCLE_OF_FIGURES = "iliacus"  # the paper's; of scenes without it the first
PLAIN_NUMBERS = FuncFormatter(lambda value, _: f"{value:g}")


def caption(runs: list[Run]) -> str:
    """What was run, on what, how often."""
    first = runs[0].record
    case, build, machine = first["case"], first.get("build", {}), first.get("machine", {})
    frames = max((run.record.get("frames") or 0) for run in runs)
    data, threads = case["scene"].split("/")[0], case.get("threads", "?")
    git = build.get("git", "unknown")
    known = [
        f"{data} data, {case.get('preset', '?')} preset, {frames} frames, one run a case, threads: {threads}",
        machine.get("cpu"), build.get("compiler"), f"git {git}" if git != "unknown" else None,
        *(f"shapes: {licence}" for licence in licences_of(run.record for run in runs)),
    ]
    return "; ".join(text for text in known if text)


def draw_figures(runs: list[Run], published: Published, folder: Path) -> list[Path]:
    """Figures of the runs that left frames; each with its rows as CSV. Returns the files."""
    style.apply_style()
    with_frames = [run for run in runs if not run.frames.empty]
    cases = by_case(with_frames)
    if not cases:
        return []
    chosen = muscle_of_figures(muscle for muscle, _ in cases)
    of_muscle = {backend: run for (muscle, backend), run in cases.items() if muscle == chosen}
    return [*_draw_times(cases, chosen, of_muscle, published, folder), *_draw_memory(chosen, of_muscle, folder),
            *_draw_depths(cases, folder)]


def muscle_of_figures(muscles) -> str:
    muscles = list(muscles)
    return next((name for name in muscles if name == MUSCLE_OF_FIGURES or name.endswith(f"-{MUSCLE_OF_FIGURES}")),
                muscles[0])


def _draw_times(cases, muscle: str, runs: dict[str, Run], published: Published, folder: Path) -> list[Path]:
    shown = {backend: run for backend, run in runs.items() if not looks.backend(backend).is_control}
    figure, axes = _column_axes()
    labels, waiting = [], 0
    for backend, run in shown.items():
        frames = run.timed_frames
        milliseconds, waited = frames["collision_ns"] / 1e6, waits(frames["collision_ns"])
        _line(axes, backend, frames["frame"][~waited], milliseconds[~waited])
        axes.scatter(frames["frame"][waited], milliseconds[waited], marker="x", s=9, linewidth=0.6,
                     color=looks.colour(backend), alpha=0.5)
        waiting += int(waited.sum())
        ratio = collision_ratio(cases, muscle, backend)
        paper = published.time_ratio(backend)
        note = "" if backend == "voxel" else f"\n{as_ratio(ratio.value)} x voxel" + (f"\n(paper {paper})" if paper else "")
        labels.append((milliseconds.iloc[-30:].median(), f"{looks.title(backend)}{note}", backend))
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(PLAIN_NUMBERS)
    axes.yaxis.set_minor_formatter(style.PlainLogFormatter(minor_thresholds=(1, 0.4)))
    axes.set(xlabel="frame", ylabel="collision time a frame (ms)")
    figure.suptitle(f"Fig. 7  Collision time, {style.muscle_label(muscle)}", x=0.02, ha="left", y=0.99)
    _label_ends(axes, labels)
    _angle_axis(axes, next(iter(shown.values())))
    crosses = f"; crosses: {waiting} frame{'s' if waiting > 1 else ''} in which the process waited for the processor" if waiting else ""
    _footnote(figure, list(shown.values()), crosses)
    rows = _rows(shown, ["update_ns", "detect_ns", "respond_ns", "collision_ns"])
    return _save(figure, rows, folder / "fig_7_collision_time")


def _draw_memory(muscle: str, runs: dict[str, Run], folder: Path) -> list[Path]:
    figure, axes = _column_axes()
    labels = []
    for backend, run in runs.items():
        megabytes = run.frames["resident_bytes"] / MEGABYTE
        _line(axes, backend, run.frames["frame"], megabytes)
        growth = megabytes.iloc[-1] - megabytes.iloc[0]
        labels.append((megabytes.iloc[-1], f"{looks.title(backend)}\n{megabytes.iloc[0]:.0f} MB, {growth:+.1f}", backend))
    axes.set_ylim(bottom=0)
    axes.set(xlabel="frame", ylabel="resident memory (MB)")
    figure.suptitle(f"Fig. 8  Memory of the process, {style.muscle_label(muscle)}", x=0.02, ha="left", y=0.99)
    _label_ends(axes, labels)
    _angle_axis(axes, next(iter(runs.values())))
    _footnote(figure, list(runs.values()))
    return _save(figure, _rows(runs, ["resident_bytes"]), folder / "fig_8_memory")


def _draw_depths(cases, folder: Path) -> list[Path]:
    muscles = list(dict.fromkeys(muscle for muscle, _ in cases))
    figure, panels = plt.subplots(
        2, len(muscles), figsize=(style.PAGE_INCHES, 3.6), sharex=True, sharey="row", squeeze=False
    )
    for column, muscle in enumerate(muscles):
        for (name, backend), run in cases.items():
            if name == muscle:
                _line(panels[0, column], backend, run.frames["frame"], 1e3 * run.frames["max_depth_m"], label=looks.title(backend))
                _line(panels[1, column], backend, run.frames["frame"], 1e3 * run.frames["mean_depth_m"])
        panels[0, column].set_title(style.muscle_label(muscle))
        panels[1, column].set_xlabel("frame")
    for row, text in ((0, "largest\ndepth (mm)"), (1, "mean depth of\nnodes inside (mm)")):
        panels[row, 0].set_ylabel(text)
        panels[row, 0].set_yscale("symlog", linthresh=0.1)
        panels[row, 0].set_ylim(bottom=0)
        panels[row, 0].yaxis.set_major_formatter(PLAIN_NUMBERS)
    figure.suptitle("True depth of the muscle's nodes in the bones (linear below 0.1 mm)", x=0.01, ha="left", y=1.02)
    handles = {h.get_label(): h for panel in panels[0] for h in panel.get_lines()}
    figure.legend(handles.values(), handles.keys(), ncols=len(handles), loc="upper left", bbox_to_anchor=(0.005, 0.985),
                  frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 0.96), w_pad=0.6)
    runs = list(cases.values())
    _footnote(figure, runs)
    columns = ["nodes_inside", "max_depth_m", "p99_depth_m", "mean_depth_m"]
    return _save(figure, frame_rows(cases, columns), folder / "depth_by_frame")


def _column_axes():
    """A panel at the width of a column, with room for the lines' names on the right."""
    figure, axes = plt.subplots(figsize=(style.COLUMN_INCHES, 2.5))
    figure.subplots_adjust(left=0.15, right=0.73, bottom=0.16, top=0.83)
    return figure, axes


def _line(axes, backend: str, x, y, label=None) -> None:
    axes.plot(x, y, color=looks.colour(backend), linestyle=looks.dash(backend), label=label)


def _label_ends(axes, labels: list[tuple[float, str, str]]) -> None:
    """Names beside the right ends of the lines, pushed apart so that none covers another."""
    axes.figure.canvas.draw()
    renderer, to_axes, lowest = axes.figure.canvas.get_renderer(), axes.transAxes.inverted(), 0.0
    for value, text, backend in sorted(label for label in labels if pd.notna(label[0])):
        drawn = axes.text(1.02, 0.0, text, transform=axes.transAxes, va="bottom", fontweight="bold", linespacing=1.1,
                          color=looks.colour(backend), fontsize=style.SMALLEST_POINTS)
        height = drawn.get_window_extent(renderer).height / axes.get_window_extent(renderer).height
        wanted = to_axes.transform(axes.transData.transform((0, value)))[1] - height / 2
        lowest = max(wanted, lowest)
        drawn.set_y(lowest)
        lowest += height + 0.02


def _angle_axis(axes, run: Run) -> None:
    """Flexion at the frames of the ticks, above the panel."""
    angles = run.frames.set_index("frame")["angle_deg"].dropna()
    if angles.empty:
        return
    top = axes.secondary_xaxis("top")
    ticks = angles.index[[round(i * (len(angles) - 1) / 4) for i in range(5)]]
    top.set_xticks(ticks, [f"{angles[frame]:.0f}°" for frame in ticks])
    top.spines["top"].set_visible(False)
    top.tick_params(length=0, colors="#666666", labelsize=7, pad=0)


def _footnote(figure: Figure, runs: list[Run], more: str = "") -> None:
    style.add_note(figure, caption(runs) + more)


def _rows(runs: dict[str, Run], columns: list[str]) -> pd.DataFrame:
    return frame_rows({(run.muscle, backend): run for backend, run in runs.items()}, columns)


def frame_rows(cases: dict[tuple[str, str], Run], columns: list[str]) -> pd.DataFrame:
    """Of {(muscle, backend): run}: one row a run and frame."""
    parts = []
    for (muscle, backend), run in cases.items():
        part = run.frames.reindex(columns=["frame", "angle_deg", "warm_up", *columns])
        part.insert(0, "backend", backend)
        part.insert(0, "muscle", muscle)
        parts.append(part)
    return pd.concat(parts, ignore_index=True)


def _save(figure: Figure, rows: pd.DataFrame, stem: Path) -> list[Path]:
    table = stem.with_suffix(".csv")
    rows.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]
