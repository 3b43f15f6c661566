"""A way around bones, for a tendon whose straight way would lead through them."""

import itertools

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from .surface import Points, SignedDistance, Values

CELL_MM = 2.0
MOST_CELLS = 1_000_000  # a long way has larger ones
SAMPLE_MM = 0.5  # where a straight way is looked at
BESIDE_MM = 25.0  # of the box around both ends, in which a way is looked for
IN_BONE, TOO_NEAR = 1000.0, 10.0  # what a millimetre there costs
# One of each pair of opposite neighbours.
STEPS = [step for step in itertools.product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]


def route(start: Points, end: Points, fields: list[SignedDistance], room_mm: float) -> Points:
    """(n, 3) places from start to end: a short way that keeps `room_mm` from all surfaces, where there is one. Else it goes through a
    narrow place, or the shortest way through a bone."""
    low = np.minimum(start, end) - BESIDE_MM
    size = np.maximum(start, end) + BESIDE_MM - low
    cell = max(CELL_MM, float(size.prod() / MOST_CELLS) ** (1 / 3))
    shape = np.ceil(size / cell).astype(int) + 1
    numbers = np.arange(shape.prod(), dtype=np.int32).reshape(shape)
    price = _prices(low + cell * np.argwhere(numbers >= 0), fields, room_mm).reshape(shape)
    rows, columns, costs = [], [], []
    for step in STEPS:
        ahead = tuple(slice(max(k, 0), count + min(k, 0)) for k, count in zip(step, shape))
        behind = tuple(slice(max(-k, 0), count + min(-k, 0)) for k, count in zip(step, shape))
        rows.append(numbers[behind].ravel())
        columns.append(numbers[ahead].ravel())
        costs.append((cell * np.linalg.norm(step) * (price[behind] + price[ahead]) / 2).ravel())
    graph = coo_matrix((np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(numbers.size, numbers.size)).tocsr()
    first, last = (int(numbers[tuple(np.rint((place - low) / cell).astype(int))]) for place in (start, end))
    before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
    way = [last]
    while way[-1] != first:
        way.append(int(before[way[-1]]))
    places = low + cell * np.column_stack(np.unravel_index(way[::-1], shape))
    return _straightened(np.concatenate([start[None], places[1:-1], end[None]]), fields, room_mm)


def _straightened(places: Points, fields: list[SignedDistance], room_mm: float) -> Points:
    """A way from cell to cell has bends of its own: from each place straight on to the last one that has room all along."""
    kept = [0]
    while kept[-1] < len(places) - 1:
        here = places[kept[-1]]
        following = range(len(places) - 1, kept[-1] + 1, -1)
        kept.append(next((k for k in following if (_prices(_between(here, places[k]), fields, room_mm) == 1).all()), kept[-1] + 1))
    return places[kept]


def _between(start: Points, end: Points) -> Points:
    found: Points = start + np.linspace(0, 1, max(2, int(np.linalg.norm(end - start) / SAMPLE_MM)))[:, None] * (end - start)
    return found


def _prices(places: Points, fields: list[SignedDistance], room_mm: float) -> Values:
    nearest = np.full(len(places), np.inf)
    for field in fields:
        nearest = np.minimum(nearest, field.within(places, room_mm))
    return np.where(nearest < 0, IN_BONE, np.where(nearest < room_mm, TOO_NEAR, 1.0))
