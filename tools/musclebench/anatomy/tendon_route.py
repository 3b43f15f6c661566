"""A way around bones, for a tendon whose straight way would lead through them."""

import itertools

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from .surface import Points, SignedDistance, Values

CELL_MM = 2.0
BESIDE_MM = 25.0  # of the box around both ends, in which a way is looked for
IN_BONE, TOO_NEAR = 1000.0, 10.0  # what a millimetre there costs
# One of each pair of opposite neighbours.
STEPS = [step for step in itertools.product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]


def route(start: Points, end: Points, fields: list[SignedDistance], room_mm: float) -> Points:
    """(n, 3) places from start to end, a cell apart: the shortest way that keeps `room_mm` from all surfaces, where there is one. Else it
    goes through a narrow place, or the shortest way through a bone."""
    low = np.minimum(start, end) - BESIDE_MM
    shape = np.ceil((np.maximum(start, end) + BESIDE_MM - low) / CELL_MM).astype(int) + 1
    numbers = np.arange(shape.prod()).reshape(shape)
    price = _prices(low + CELL_MM * np.argwhere(numbers >= 0), fields, room_mm).reshape(shape)
    rows, columns, costs = [], [], []
    for step in STEPS:
        ahead = tuple(slice(max(k, 0), size + min(k, 0)) for k, size in zip(step, shape))
        behind = tuple(slice(max(-k, 0), size + min(-k, 0)) for k, size in zip(step, shape))
        rows.append(numbers[behind].ravel())
        columns.append(numbers[ahead].ravel())
        costs.append((CELL_MM * np.linalg.norm(step) * (price[behind] + price[ahead]) / 2).ravel())
    graph = coo_matrix((np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(numbers.size, numbers.size)).tocsr()
    first, last = (int(numbers[tuple(np.rint((place - low) / CELL_MM).astype(int))]) for place in (start, end))
    before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
    way = [last]
    while way[-1] != first:
        way.append(int(before[way[-1]]))
    places = low + CELL_MM * np.column_stack(np.unravel_index(way[::-1], shape))
    return np.concatenate([start[None], places[1:-1], end[None]])


def _prices(places: Points, fields: list[SignedDistance], room_mm: float) -> Values:
    nearest = np.full(len(places), np.inf)
    for field in fields:
        nearest = np.minimum(nearest, field.within(places, room_mm))
    return np.where(nearest < 0, IN_BONE, np.where(nearest < room_mm, TOO_NEAR, 1.0))
