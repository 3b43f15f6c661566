"""Which coupled runs don't count as accurate, however little depth they leave."""

import math

from .aggregates import Aggregate

ALLOWED_NODES_SHARE = 0.01
ALLOWED_SHAPE_MM = 3.0  # above what rounding alone does to the shape: exact backends end up to 1.5 mm apart

RULE = (
    "Crossed out and not on the front is what answers wrongly on replayed positions, what holds nodes by false "
    f"contacts or lets them through a bone (more than {100 * ALLOWED_NODES_SHARE:g} % of the muscle's nodes stuck or "
    f"tunnelled), and what ends more than {ALLOWED_SHAPE_MM:g} mm (RMS over the nodes) from the exact run's shape at "
    "full flexion."
)


def faults_of(coupled: list[Aggregate], shapes: dict) -> dict[tuple, str]:
    """{(scene, configuration): why}, of the complete runs. `shapes` as tables.outcomes.shape_distances gives them."""
    found = {(e.scene, e.configuration): _faults(e, shapes.get((e.scene, e.configuration), {}))
             for e in coupled if e.is_shown and not e.configuration.about.is_control}
    return {key: ", ".join(words) for key, words in found.items() if words}


def told(faults: dict[tuple, str]) -> str:
    """For a caption; empty where nothing is at fault."""
    texts = [f"{scene.split('/')[-1].replace('_', ' ')} with {chosen.name} ({why})"
             for (scene, chosen), why in faults.items()]
    return f"At fault: {'; '.join(texts)}." if texts else ""


def _faults(aggregate: Aggregate, shape: dict) -> list[str]:
    nodes = aggregate.number("muscle", "vertices")
    counts = {word: aggregate.number("outcome", f"{word}_nodes") for word in ("stuck", "tunnelled")}
    words = [f"{count:.0f} nodes {word}" for word, count in counts.items() if count > ALLOWED_NODES_SHARE * nodes]
    distance = shape.get("full_rms_mm", math.nan)
    return words + ([f"shape {distance:.1f} mm off"] if distance > ALLOWED_SHAPE_MM else [])
