"""What belongs where: the columns of a frame, the folders of the project, the nodes that reach a search."""

from .shapes import ASKED, BONE, FREE, NOTE, WRONG, Axes, arrow, box, double_arrow

STAGES = (
    ("predict", "predict_ns", 1.5, NOTE),
    ("effects:\nedge length, volume, ...", "EFFECT_ns", 2.6, FREE),
    ("update, detect,\nrespond", "collision time\nwith bones", 2.3, ASKED),
    ("muscle contact,\nfriction, guard, ...", "STAGE_ns", 2.3, WRONG),
    ("finish", "finish_ns", 1.3, NOTE),
)


def frame(axes: Axes) -> None:
    """A frame's substeps; one of them, stage by stage, over the columns that tell its time; what is not timed."""
    width = sum(stage[2] for stage in STAGES)
    substeps = 5
    for step in range(substeps):
        box(axes, (step * width / substeps, 3.0), width / substeps - 0.08, 0.5, "substep" if step else "a substep", FREE, 0.3 if step == 0 else 0.12)
    for x, end in ((0, 0), (width / substeps - 0.08, width)):
        axes.plot([x, end], [3.0, 2.5], ":", color=NOTE, linewidth=0.8)
    left = 0.0
    for words, column, share, colour in STAGES:
        box(axes, (left, 1.75), share - 0.06, 0.75, words, colour, 0.22)
        axes.text(left + share / 2, 1.62, column, ha="center", va="top", fontsize=8, color=colour)
        left += share
    double_arrow(axes, (0, 3.85), (width, 3.85))
    axes.text(width / 2, 3.93, "frame_ns", ha="center", va="bottom", fontsize=8, color=NOTE)
    axes.text(0, 0.72, "not in frame_ns:", fontsize=8, color=NOTE)
    for x, share, words in ((0, 2.6, "recording_ns: copies\nfor the Referee"), (3.0, 3.2, "the Referee: depths, missed\nand false contacts"),
                            (6.6, 3.4, "reading meshes,\nwriting frames.csv")):
        box(axes, (x, -0.15), share, 0.75, words, BONE, 0.8)
    axes.set(xlim=(-0.1, width + 0.1), ylim=(-0.25, 4.3))


def folders(axes: Axes) -> None:
    """Who may include whom, and what passes between the program and the tools."""
    box(axes, (0, 2.0), 2.3, 0.9, "core/\nmeshes, loop, Referee", FREE, 0.25)
    box(axes, (3.2, 2.0), 2.3, 0.9, "backends/\none folder each", ASKED, 0.25)
    box(axes, (6.4, 2.0), 2.3, 0.9, "bench/\nthe program", WRONG, 0.2)
    for right in (3.2, 6.4):
        arrow(axes, (right, 2.45), (right - 0.9, 2.45))
        axes.text(right - 0.45, 2.53, "includes", ha="center", fontsize=8, color=NOTE)
    box(axes, (9.6, 2.0), 2.3, 0.9, "datasets/\nscenes, made meshes", BONE, 0.8)
    arrow(axes, (9.6, 2.45), (8.7, 2.45))
    axes.text(9.15, 2.53, "scenes", ha="center", fontsize=8, color=NOTE)
    box(axes, (6.4, 0.1), 2.3, 0.9, "run.json,\nframes.csv", BONE, 0.8)
    box(axes, (3.2, 0.1), 2.3, 0.9, "tools/\nstudies, tables, figures", NOTE, 0.18)
    box(axes, (0, 0.1), 2.3, 0.9, "reports/\npages", NOTE, 0.18)
    arrow(axes, (7.55, 2.0), (7.55, 1.0))
    axes.text(7.65, 1.45, "writes", fontsize=8, color=NOTE)
    arrow(axes, (6.4, 0.55), (5.5, 0.55))
    axes.text(5.95, 0.63, "read", ha="center", fontsize=8, color=NOTE)
    arrow(axes, (3.2, 0.55), (2.3, 0.55))
    axes.text(2.75, 0.63, "publish", ha="center", fontsize=8, color=NOTE)
    arrow(axes, (4.6, 1.0), (6.4, 2.0))
    axes.text(5.25, 1.62, "start", ha="right", fontsize=8, color=NOTE)
    axes.set(xlim=(-0.1, 12.0), ylim=(0, 3.0))


def fewer_at_each_step(axes: Axes) -> None:
    """Widths show that there are fewer, not how many."""
    steps = (("all nodes of the muscle", 9.0, NOTE), ("left their safe sphere: the cache lets the others go", 6.0, FREE),
             ("asked of the field or the tree", 3.4, ASKED), ("in contact", 1.5, WRONG))
    for row, (words, width, colour) in enumerate(steps):
        axes.text(4.5, 3.72 - 1.1 * row, words, ha="center", va="bottom", fontsize=8, color=colour)
        box(axes, (4.5 - width / 2, 3.3 - 1.1 * row), width, 0.36, "", colour, 0.35)
    axes.set(xlim=(-0.1, 9.1), ylim=(-0.1, 4.2))
