"""Where the time of a frame goes: update, detect, respond and the constraints, as stacked bars a backend."""

from pathlib import Path

import pandas as pd

from ..accuracy.aggregates import NANOSECONDS_TO_MS, Aggregate, find, stage_ns
from ..results.run_folder import COLLISION_STAGES, NOT_OF_THE_LOOP
from ..results.statistics import pooled_median
from ..tables.choices import best_right
from . import style
from .style import plt

NOT_STAGES = {*COLLISION_STAGES, *NOT_OF_THE_LOOP, "frame_ns"}
# The three of collision are warm, so that their share is seen at once; no stage has a backend's colour.
COLOURS = {"update_ns": "#F0E442", "detect_ns": "#D55E00", "respond_ns": "#8C2D04"}
OTHER_COLOURS = ["#23395B", "#6A8CAF", "#A9C5DE", "#4d4d4d", "#999999", "#c7c7c7",
                 "#4A3B66", "#8F7DB0", "#CBC0DF", "#3E5C4B", "#86A593", "#C6D6CB"]
LEGEND_INCHES = 0.5
WORDS_INCHES = 0.1  # right of what stands beside the bars
STAGE_ORDER = ["edge_length_ns", "bending_ns", "volume_ns", "attachment_ns", "gravity_ns", "predict_ns", "finish_ns"]


def stage_rows(coupled: list[Aggregate], replays: list[Aggregate]) -> pd.DataFrame:
    """One row a scene, chosen configuration and stage: milliseconds a frame, share of the frame's stages."""
    rows = []
    for scene in dict.fromkeys(aggregate.scene for aggregate in coupled):
        for aggregate in chosen_aggregates(coupled, replays, scene):
            for stage in stages_of(aggregate):
                series = [stage_ns(case, stage) for case in aggregate.ok]
                time = pooled_median(series).scaled(NANOSECONDS_TO_MS)
                rows.append({"scene": scene, "configuration": aggregate.configuration.name,
                             "spoken": aggregate.configuration.spoken, "stage": stage,
                             "ms": time.value, "ms_low": time.low, "ms_high": time.high})
    table = pd.DataFrame(rows, columns=["scene", "configuration", "spoken", "stage", "ms", "ms_low", "ms_high"])
    table["share"] = table["ms"] / table.groupby(["scene", "configuration"], sort=False)["ms"].transform("sum")
    return table


def chosen_aggregates(coupled: list[Aggregate], replays: list[Aggregate], scene: str) -> list[Aggregate]:
    """The default of each backend, and of one with many choices the fastest right configuration that has driven the
    muscle."""
    driven = [one for one in replays if find(coupled, scene, one.configuration) is not None]
    wanted = [one.configuration for one in coupled if one.scene == scene and one.configuration.is_default]
    for backend in dict.fromkeys(one.backend for one in driven if one.configuration.about.has_many_choices):
        best = best_right(driven, scene, backend)
        wanted += [best.configuration] if best else []
    found = [find(coupled, scene, one) for one in dict.fromkeys(wanted)]
    return [aggregate for aggregate in found if aggregate is not None]


def stages_of(aggregate: Aggregate) -> list[str]:
    """Constraints first, in one order for all, collision last."""
    columns = [key for key in aggregate.ok[0].run.frames.columns if key.endswith("_ns") and key not in NOT_STAGES]
    return [*style.in_order(columns, STAGE_ORDER), *COLLISION_STAGES]


def draw_stages(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """One panel a muscle: shares as stacked bars, milliseconds in words beside them."""
    if rows.empty:
        return []
    style.apply_style()
    scenes, names = list(dict.fromkeys(rows["scene"])), list(dict.fromkeys(rows["stage"]))
    bars = max(rows[rows["scene"] == scene]["configuration"].nunique() for scene in scenes)
    height = len(scenes) * (0.22 * bars + 0.55) + LEGEND_INCHES
    figure, panels = plt.subplots(len(scenes), 1, figsize=(style.PAGE_INCHES, height), squeeze=False)
    colours = _colours(names)
    for axes, scene in zip(panels[:, 0], scenes):
        _draw_bars(axes, rows[rows["scene"] == scene], names, colours)
        axes.set_title(style.muscle_label(scene.split("/")[-1]), loc="left")
    panels[-1, 0].set_xlabel("share of the frame's stages (%), medians")
    figure.tight_layout(rect=(0, 0, 1 - WORDS_INCHES / style.PAGE_INCHES, 1 - LEGEND_INCHES / height), h_pad=0.8)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colours[name]) for name in names]
    figure.legend(handles, [_words(name) for name in names], ncols=5, loc="upper left", bbox_to_anchor=(0.0, 1.0),
                  frameon=False)
    table = stem.with_suffix(".csv")
    rows.to_csv(table, index=False)
    return [*style.save_figure(figure, stem), table]


def _draw_bars(axes, rows: pd.DataFrame, names: list[str], colours: dict) -> None:
    configurations = list(dict.fromkeys(rows["configuration"]))
    for height, name in enumerate(configurations):
        left, mine = 0.0, rows[rows["configuration"] == name].set_index("stage")
        for stage in (stage for stage in names if stage in mine.index):
            width = 100 * mine.loc[stage, "share"]
            axes.barh(height, width, left=left, height=0.74, color=colours[stage], edgecolor="white", linewidth=0.5)
            left += width
        collision = mine.loc[[s for s in COLLISION_STAGES if s in mine.index], "ms"].sum()
        axes.text(101, height, f"{_ms(mine['ms'].sum())} ms, collision {_ms(collision)} ms", va="center",
                  fontsize=7)
    spoken = dict(zip(rows["configuration"], rows["spoken"]))
    axes.set_yticks(range(len(configurations)), [spoken[name] for name in configurations])
    axes.set(xlim=(0, 100), ylim=(len(configurations) - 0.45, -0.55))
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)


def _colours(names: list[str]) -> dict[str, str]:
    others = [name for name in names if name not in COLOURS]
    return COLOURS | {name: OTHER_COLOURS[i % len(OTHER_COLOURS)] for i, name in enumerate(others)}


def _words(stage: str) -> str:
    words = stage.removesuffix("_ns").replace("_", " ")
    return f"collision: {words}" if stage in COLLISION_STAGES else words


def _ms(value: float) -> str:
    """Three digits, no more than microseconds."""
    return f"{value:.3g}" if 0.01 <= value < 1000 else f"{value:.0f}" if value >= 1000 else "below 0.01"
