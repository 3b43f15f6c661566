"""Surfaces cut by a plane across y: what lies in what is seen where a picture from outside hides it."""

import numpy as np


def cut(vertices_m: np.ndarray, triangles: np.ndarray, at_y_m: float) -> list[np.ndarray]:
    """The outlines (n, 2) in x and z, one a loop; where the surface is open, from border to border."""
    above = vertices_m[:, 1] >= at_y_m
    # Neighbours run through their common edge in opposite directions: where one goes up, the next one goes down.
    after = {}
    for triangle in triangles[above[triangles].any(axis=1) & ~above[triangles].all(axis=1)]:
        edges = [(int(triangle[i]), int(triangle[(i + 1) % 3])) for i in range(3)]
        down = next(edge for edge in edges if above[edge[0]] and not above[edge[1]])
        up = next(edge for edge in edges if above[edge[1]] and not above[edge[0]])
        after[down] = up[::-1]
    reached = set(after.values())
    outlines = []
    for edge in sorted(after, key=lambda one: one in reached):  # borders first
        walked = []
        while edge in after:
            walked.append(edge)
            edge = after.pop(edge)
        if walked:
            outlines.append(np.array([_crossing(vertices_m, one, at_y_m) for one in [*walked, edge]]))
    return outlines


def _crossing(vertices_m: np.ndarray, edge: tuple[int, int], at_y_m: float) -> np.ndarray:
    start, end = vertices_m[edge[0]], vertices_m[edge[1]]
    return (start + (at_y_m - start[1]) / (end[1] - start[1]) * (end - start))[[0, 2]]
