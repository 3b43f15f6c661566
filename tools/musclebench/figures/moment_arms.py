"""Moment arms over the angle: a panel a muscle, its band beside the published ones."""

from pathlib import Path

import pandas as pd

from ..moment_arms.published import Published
from . import style
from .style import muscle_label, plt

OURS, TAUT, SAME_HIP, ELEMENTS, MEASURED = "#e8a37a", "#d55e00", "#0072b2", "#7f7f7f", "#000000"
MOST_ERROR_MM = 5.0  # of a slope that is drawn: a muscle that bursts would scale its panel


def draw_moment_arms(courses: dict[str, pd.DataFrame], active: dict[str, pd.DataFrame],
                     published: dict[str, Published], stem: Path) -> list[Path]:
    style.apply_style()
    figure, panels = plt.subplots(1, len(courses), figsize=(style.PAGE_INCHES, 3.4), squeeze=False, sharex=True)
    for axes, (muscle, course) in zip(panels[0], courses.items()):
        _draw_published(axes, published.get(muscle, Published()))
        axes.fill_between(course["angle_deg"], course["p10_mm"], course["p90_mm"], color=OURS, alpha=0.3, linewidth=0)
        axes.plot(course["angle_deg"], course["mean_mm"], color=OURS, label="here, passive: mean, 10th to 90th percentile")
        if muscle in active:
            taut = active[muscle][active[muscle]["error_mm"] < MOST_ERROR_MM]
            axes.plot(taut["angle_deg"], taut["mean_mm"], color=TAUT, label="here, active: mean dL/d(angle)")
            if "torque_mm" in taut:
                axes.plot(taut["angle_deg"], taut["torque_mm"], color=TAUT, linestyle=(0, (4, 1.5)),
                          label="here, active: torque over fibre force")
        axes.axhline(0, color="0.7", linewidth=0.6, zorder=0)
        axes.set_title(muscle_label(muscle), loc="left")
        axes.set_xlabel("flexion (degrees)")
    panels[0, 0].set_ylabel("moment arm dL/d(flexion) (mm)")
    handles = {label: handle for axes in panels[0] for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="upper left", ncol=2, frameon=False, fontsize=7)
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    return style.save_figure(figure, stem)


def _draw_published(axes, published: Published) -> None:
    if published.same_hip:
        low, mean, high = (published.same_hip[name] for name in ("p10", "mean", "p90"))
        axes.fill_between(mean.angles_deg, low.values_mm, high.values_mm, color=SAME_HIP, alpha=0.2, linewidth=0)
        axes.plot(mean.angles_deg, mean.values_mm, color=SAME_HIP, linestyle="--",
                  label="the same hip, Modenese and Kohout 2020")
    if published.finite_elements:
        for bound in published.finite_elements.values():
            axes.plot(bound.angles_deg, bound.values_mm, color=ELEMENTS, linestyle=":",
                      label="finite elements, bounds, Blemker and Delp 2005")
    if published.measured:
        axes.plot(published.measured.angles_deg, published.measured.values_mm, color=MEASURED, linestyle="-.",
                  linewidth=0.8, label="measured, other subjects")
