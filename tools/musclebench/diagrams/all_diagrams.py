"""Every diagram by its file's name: its panels, width and height in inches."""

from pathlib import Path

from . import bounds, constraints, muscles, overviews, structures, words
from .shapes import panel, plt

DIAGRAMS = {
    "words": ((words.simulated, words.contact, words.judged), 9.0, 2.9),
    "frame": ((overviews.frame,), 7.0, 3.2),
    "folders": ((overviews.folders,), 8.4, 2.3),
    "fewer_at_each_step": ((overviews.fewer_at_each_step,), 6.0, 2.6),
    "constraints": ((constraints.colours_of_edges, constraints.blocks_of_lanes), 7.4, 2.8),
    "muscle_contact": ((muscles.moving_tree, muscles.both_sides), 7.0, 3.2),
    "triangle_bvh": ((structures.triangle_bvh,), 4.4, 3.0),
    "clearance_cache": ((structures.safe_sphere, structures.candidate_list, structures.order_of_questions), 7.4, 2.6),
    "distance_field": ((structures.distance_field,), 6.2, 2.9),
    "adaptive_field": ((structures.adaptive_field,), 4.4, 3.2),
    "batched_closest_point": ((structures.batched_points,), 4.8, 2.6),
    "surface_depth": ((bounds.surface_depth,), 5.0, 2.9),
    "field_bounds": ((bounds.signed_field,), 5.6, 2.9),
    "winding_number_bound": ((bounds.winding,), 5.0, 2.8),
    "bvh_error_bounds": ((bounds.triangle_frame,), 5.4, 2.1),
}


def draw(folder: Path) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    # The same bytes whenever and wherever they are drawn, so that a change is a change.
    plt.rcParams.update({"svg.hashsalt": "musclebench", "svg.fonttype": "none", "font.size": 8, "axes.titlesize": 9})
    paths = []
    for name, (parts, width, height) in DIAGRAMS.items():
        figure, axes = panel(width, height, len(parts))
        for one, part in zip(axes, parts):
            part(one)
        figure.tight_layout(pad=0.3)
        paths.append(folder / f"{name}.svg")
        figure.savefig(paths[-1], metadata={"Date": None})
        plt.close(figure)
    return paths
