"""A surface whose edges are springs, solved apart from the program: linear, in its natural modes, exact in time."""

import numpy as np


def edges_of(triangles: np.ndarray) -> np.ndarray:
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def stiffness_matrix(rest_m: np.ndarray, triangles: np.ndarray, fibre: np.ndarray, exponent: float,
                     compliance_m_per_n: float) -> np.ndarray:
    """(node, axis, node, axis). A spring counts by (1 - |cos|)^exponent of its angle to the fibre."""
    edges = edges_of(triangles)
    along = rest_m[edges[:, 1]] - rest_m[edges[:, 0]]
    along /= np.linalg.norm(along, axis=1)[:, None]
    factors = (1 - np.minimum(1, np.abs(along @ fibre))) ** exponent / compliance_m_per_n
    matrix = np.zeros((len(rest_m), 3, len(rest_m), 3))
    for (i, j), direction, factor in zip(edges, along, factors):
        block = factor * np.outer(direction, direction)
        for node, other, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            matrix[node, :, other] += sign * block
    return matrix


def displacement_m(stiffness: np.ndarray, free: np.ndarray, acceleration: np.ndarray, mass_kg: float,
                   damping_per_s: float, time_s: float) -> np.ndarray:
    """Of the free nodes (a mask), mean over them, from rest. Modes that no spring holds fall against the damping."""
    among_free = stiffness[free][:, :, free].reshape(3 * free.sum(), -1)
    squares, modes = np.linalg.eigh(among_free / mass_kg)
    force = modes.T @ np.tile(acceleration, free.sum())
    held = squares > 1e-6
    amplitudes = force * (time_s / damping_per_s - (1 - np.exp(-damping_per_s * time_s)) / damping_per_s**2)
    root = np.sqrt(np.asarray(damping_per_s**2 / 4 - squares[held], complex))
    first, second = -damping_per_s / 2 + root, -damping_per_s / 2 - root
    decay = (first * np.exp(second * time_s) - second * np.exp(first * time_s)) / (first - second)
    amplitudes[held] = force[held] / squares[held] * (1 - decay.real)
    return (modes @ amplitudes).reshape(-1, 3).mean(axis=0)
