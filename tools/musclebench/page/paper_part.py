"""The paper's experiment: Fig. 6 in space, Figs 7 and 8, depths, Table I and the times, beside the paper's."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

from ..figures import looks
from ..figures.paper_figures import muscle_of_figures
from ..figures.style import muscle_label
from ..paper.published import Published, read_published
from ..results.run_folder import read_runs
from ..tables import muscle_tables, paper_tables
from ..tables.smoothness_table import smoothness_table
from ..tables.table_formats import as_ratio
from .frame_charts import Cases, depth_chart, memory_chart, time_charts
from .looks_of import looks_of_names
from .parts import Chart, Part, Section, table_part
from .told_of_runs import problems_of, what_was_run
from .views import views_of

NAN = float("nan")


def is_paper(folder: Path) -> bool:
    return (folder / "runs.csv").is_file() and (folder / "tables" / "table_1_memory.csv").is_file()


def paper_section(folder: Path) -> Section:
    runs, paper = read_runs(folder / "raw"), read_published()
    with_frames = {case: run for case, run in paper_tables.by_case(runs).items() if not run.frames.empty}
    first = muscle_of_figures(muscle for muscle, _ in with_frames) if with_frames else ""
    cases = dict(sorted(with_frames.items(), key=lambda item: item[0][0] != first))
    parts: list[Part] = [views_of(cases, "Fig. 6: shape and depth, in 3D"), *figure_7(cases, paper), figure_8(cases, paper),
             depth_chart(cases),
             table_part(paper_tables.memory_table(runs, paper), "Table I: memory, measured and in the paper"),
             table_part(paper_tables.time_table(runs, paper), "Times and accuracy, measured and in the paper")]
    smoothness = smoothness_table(runs)
    if smoothness is not None:
        parts.append(table_part(smoothness, "Smoothness at the joint, against the exact run"))
    several = muscle_tables.of_several_muscles(runs)
    if several:
        parts += [table_part(muscle_tables.frame_time_table(several), "Time of each stage in a frame"),
                  table_part(muscle_tables.depth_table(several), "Depths of several muscles"),
                  table_part(muscle_tables.pair_table(several), "Pairs of several muscles")]
    return Section("paper", "The paper's experiment", what_was_run(runs), problems_of(runs), parts, looks_of_names(name for _, name in cases), folder)


def figure_7(cases: Cases, paper: Published) -> list[Chart]:
    """The paper names ratios over the frames."""
    return [replace(chart, name="fig_7_collision_time", title=f"Fig. 7: {chart.title.lower()}",
                    words=f"{chart.words} The paper gives ratios over the frames; the table shows both.",
                    beside=ratios_beside(cases, paper)) for chart in time_charts(cases)]


def ratios_beside(cases: Cases, paper: Published) -> dict:
    """A line a muscle."""
    backends = [name for name in dict.fromkeys(name for _, name in cases) if not looks.backend(name).is_control]
    lines = []
    for muscle in dict.fromkeys(muscle for muscle, _ in cases):
        ratios = {backend: paper_tables.collision_ratio(cases, muscle, backend).value
                  for backend in backends if (muscle, backend) in cases}
        lines.append([muscle_label(muscle), *(_with_paper(ratios.get(backend, NAN), paper.time_ratio(backend)) for backend in backends)])
    return {"caption": "Collision time over the voxel grid's time, median over the frames. In brackets: the paper's ratio.",
            "heads": ["muscle", *map(looks.title, backends)], "lines": lines}


def _with_paper(ours: float, theirs: str) -> str:
    return f"{as_ratio(ours) if ours == ours else '-'} ({theirs or 'none'})"


def figure_8(cases: Cases, paper: Published) -> Chart:
    """With the paper's first and last memory of the same muscle."""
    chart = memory_chart(cases)
    theirs = []
    for (muscle, backend), run in cases.items():
        frames = run.frames["frame"]
        for frame, column in ((frames.iloc[0], "first_mb"), (frames.iloc[-1], "last_mb")):
            theirs.append({"muscle": muscle, "backend": backend, "frame": frame, "source": "paper",
                           "resident_mb": paper.memory(run.muscle_alone, backend, column)})
    rows = pd.concat([chart.rows.assign(source="here"), pd.DataFrame(theirs).dropna()], ignore_index=True)
    return replace(chart, name="fig_8_memory", title=f"Fig. 8: {chart.title.lower()}", rows=rows,
                   words=f"{chart.words} Diamonds: the paper's memory before the first and after the last iteration, with its program and build.",
                   options={**chart.options, "apart": "source"})
