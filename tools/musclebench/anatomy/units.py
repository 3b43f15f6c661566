"""The unit of a folder of meshes, by their sizes."""

import numpy as np

from ..program.cli import Problem
from .anatomy_map import UNITS

LARGEST_PART_MM = (25.0, 700.0)  # a bone or muscle of a hand to a femur of a tall person
SAME_SCALE = 100.0  # the largest part of a body over its smallest


def unit_of(diagonals: dict[str, float], told: str) -> str:
    """`diagonals`: {file: diagonal of its box, in its unit}. Raises Problem where sizes do not tell, and lists what has another scale."""
    typical = float(np.median(list(diagonals.values())))
    odd = {name: size for name, size in diagonals.items() if not typical / SAME_SCALE < size < typical * SAME_SCALE}
    if odd:
        name, size = max(odd.items(), key=lambda one: float(abs(np.log(one[1] / typical))))
        raise Problem(f"{name}: is {size:.3g} large, where the others are some {typical:.3g}: another unit; convert it, or take it out of the folder"
                      + (f" ({len(odd)} files are like that)" if len(odd) > 1 else ""))
    largest = max(diagonals.values())
    if told:
        if not LARGEST_PART_MM[0] <= UNITS[told] * largest <= LARGEST_PART_MM[1]:
            raise Problem(f"the largest mesh is {largest:.3g} {told} large, which no bone or muscle is; give another unit")
        return told
    fitting = [unit for unit, factor in UNITS.items() if LARGEST_PART_MM[0] <= factor * largest <= LARGEST_PART_MM[1]]
    if len(fitting) != 1:
        raise Problem(f"the largest mesh is {largest:.3g} large, which " + (f"{' and '.join(fitting)} both fit" if fitting else "no unit fits") +
                      "; write unit = \"mm\", \"cm\" or \"m\" into the map, or give --unit")
    return fitting[0]
