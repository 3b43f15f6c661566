"""The figure of speed: how far each measured figure is from its target."""

import re
from pathlib import Path

import pandas as pd
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from . import style
from .style import plt

HELD, NOT_HELD = "#009E73", "#D55E00"
ROW_INCHES = 0.185
BOUND = re.compile(r"([<>]=) ([\d.]+)")


def draw_targets(rows: pd.DataFrame, stem: Path) -> list[Path]:
    """`rows` as in speed.csv. Of every row with a target the measured value over it, or the other way round where more is
    better: left of 1 the target is held. A target of 0 has no such ratio."""
    shown = _over_target(rows)
    if shown.empty:
        return []
    style.apply_style()
    figure, axes = plt.subplots(figsize=(style.PAGE_INCHES, ROW_INCHES * len(shown) + 0.75))
    for line, row in enumerate(shown.itertuples()):
        colour = HELD if row.held == "yes" else NOT_HELD
        axes.plot([row.low, row.high], [line, line], color=colour, linewidth=1)
        axes.plot(row.ratio, line, "o", color=colour, markersize=4, markerfacecolor=colour if row.held == "yes" else "white")
    axes.axvline(1, color=style.NOTE_COLOUR, linewidth=0.8)
    axes.set(xscale="log", ylim=(len(shown) - 0.4, -0.6), xlabel="measured over target (left of 1: held)")
    axes.set_yticks(range(len(shown)), [f"{row.what}  {row.target}" for row in shown.itertuples()])
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    figure.tight_layout(pad=0.3)
    return style.save_figure(figure, stem)


def _over_target(rows: pd.DataFrame) -> pd.DataFrame:
    whole = rows[rows["part"].isna() | (rows["part"] == "")]
    bound = whole["target"].fillna("").astype(str).str.extract(BOUND)
    limit = pd.to_numeric(bound[1])
    at_most = bound[0] == "<="
    shown = whole.assign(target=bound[0].str.replace("=", "") + bound[1], limit=limit)[limit.gt(0) & whole["measured"].gt(0)]

    def over(key: str) -> pd.Series:
        return (shown[key] / shown["limit"]).where(at_most[shown.index], shown["limit"] / shown[key])

    shown = shown.assign(ratio=over("measured"), low=over("low"), high=over("high"))
    return shown.assign(what=shown["what"].str.replace("`", ""), target=shown["target"].str.replace("<", "≤ ").str.replace(">", "≥ "))
