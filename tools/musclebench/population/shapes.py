"""The numbers that each member of a population draws for its shape."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, qmc

from .shape_words import Shape

Numbers = NDArray[np.float64]


def amounts_of(shape: Shape, drawn: Numbers) -> list[float]:
    """Factors, degrees or standard deviations. `drawn`: from 0 to 1."""
    if shape.kind in ("size", "scale"):
        # As often so many times larger as so many times smaller.
        return [float((1 + shape.amount / 100) ** (2 * one - 1)) for one in drawn]
    if shape.kind == "bend":
        return [float(shape.amount * drawn[0]), float(360 * drawn[1])]
    if shape.kind == "twist":
        return [float(shape.amount * (2 * drawn[0] - 1))]
    low, high = norm.cdf(-shape.amount), norm.cdf(shape.amount)
    return [float(norm.ppf(low + one * (high - low))) for one in drawn]


def drawn_amounts(shapes: list[Shape], member: int, seed: int) -> list[list[float]]:
    """A list for each shape. Member 0 is the scene as it is, and draws nothing; the others fill the range evenly, and each stays
    the same however many there are. Source: Sobol's sequence, scrambled by the seed (Owen 1998, J. Complexity 14, 466)."""
    sequence = qmc.Sobol(sum(shape.count for shape in shapes), scramble=True, seed=seed)
    if member > 1:
        sequence.fast_forward(member - 1)
    drawn, amounts = sequence.random(1)[0], []
    for shape in shapes:
        mine, drawn = drawn[:shape.count], drawn[shape.count:]
        amounts.append(amounts_of(shape, np.clip(mine, 1e-9, 1 - 1e-9)))
    return amounts
