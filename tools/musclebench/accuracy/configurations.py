"""Configurations: a backend with what differs from its defaults, and the names that figures and tables give them."""

from collections.abc import Mapping
from dataclasses import dataclass

DEFAULTS = {
    "voxel": {"cells": 64, "voxel_size_m": 0},
    "sdf": {
        "cells": 64, "cell_size_m": 0, "precision": "float", "band_m": 0, "max_error_mm": 0, "margin": 0.001,
        "discregrid": "", "clearance_cache": "on",
    },
    "bvh": {"clearance_cache": "on"},
    "fcl": {
        "bounding_volume": "OBBRSS", "manager": "dynamic_aabb_tree", "update": "refit", "model": "replace",
        "query": "surfaces", "node_radius_m": 0.0005, "solver": "libccd",
        "clearance_cache": "off",
    },
}
EDGE_OF_CUBES = {"voxel": "voxel_size_m", "sdf": "cell_size_m"}
WANTED_ERROR = "max_error_mm"
SIZES = {"cells", *EDGE_OF_CUBES.values(), WANTED_ERROR}
NO_CHOICE = {"structures"}  # where fields are kept changes no answer and no time of a frame
WORDS = {
    ("manager", "none"): "no manager", ("manager", "sweep_and_prune"): "sweep and prune",
    ("update", "refit_top_down"): "refit top-down", ("update", "rebuild"): "rebuild",
    ("model", "update"): "update model",
    ("query", "node_distance"): "node distance", ("query", "node_collide"): "node spheres",
    ("solver", "indep"): "own solver", ("precision", "double"): "double",
    ("clearance_cache", "on"): "budgets", ("clearance_cache", "off"): "no budgets",
}


@dataclass(frozen=True)
class Configuration:
    backend: str
    choices: tuple[tuple[str, str], ...] = ()  # parameters that differ from the defaults, by name
    threads: int = 1

    @property
    def is_default(self) -> bool:
        return not self.choices and self.threads == 1

    @property
    def factors(self) -> int:
        """How many choices differ from the default."""
        return len(self.choices) + (self.threads != 1)

    @property
    def cells(self) -> int | None:
        """Along each axis; None for cubes, for adaptive cells and for backends without a grid."""
        if self.backend not in EDGE_OF_CUBES or self.cube_edge_m is not None or self.wanted_error_mm is not None:
            return None
        return int(float(self.choice("cells")))

    @property
    def cube_edge_m(self) -> float | None:
        key = EDGE_OF_CUBES.get(self.backend)
        edge = float(self.choice(key)) if key else 0.0
        return edge if edge > 0 else None

    @property
    def wanted_error_mm(self) -> float | None:
        """Of adaptive cells."""
        error = float(self.choice(WANTED_ERROR) or 0)
        return error if error > 0 else None

    @property
    def series(self) -> str | None:
        """Name of the curve over resolutions on which the configuration lies; None for a single point."""
        if self.backend not in EDGE_OF_CUBES:
            return None
        precision = f" {self.choice('precision')}" if self.backend == "sdf" else ""
        others = [text for key, text in self._spoken() if key not in SIZES and key != "precision"]
        kind = "adaptive" if self.wanted_error_mm is not None else "cubes" if self.cube_edge_m is not None else "cells"
        return " ".join([f"{self.backend}{precision}", kind, *others])

    @property
    def fineness(self) -> float:
        """Grows with resolution along a series."""
        size = self.wanted_error_mm or self.cube_edge_m
        return 1.0 / size if size is not None else float(self.cells or 0)

    @property
    def short(self) -> str:
        """Resolution, or the choices that make the point."""
        if self.wanted_error_mm is not None:
            return f"to {self.wanted_error_mm:g} mm"
        if self.cube_edge_m is not None:
            return f"{1e3 * self.cube_edge_m:g} mm"
        if self.cells is not None:
            return str(self.cells)
        return ", ".join(text for _, text in self._spoken()) or "default"

    @property
    def name(self) -> str:
        """Unambiguous and short, such as `sdf 128 double`, `fcl OBB, rebuild`, `bvh`."""
        if self.series is None:
            return f"{self.backend} {self.short}" if self.choices or self.threads != 1 or self.backend == "fcl" \
                else self.backend
        return " ".join([self.backend, self.short, *(text for key, text in self._spoken() if key not in SIZES)])

    def choice(self, key: str) -> str:
        return dict(self.choices).get(key, str(DEFAULTS.get(self.backend, {}).get(key, "")))

    def _spoken(self) -> list[tuple[str, str]]:
        ordered = sorted(self.choices, key=lambda choice: choice[0] == "clearance_cache")
        words = [(key, _word(key, value)) for key, value in ordered]
        return words + ([("threads", f"{self.threads} threads")] if self.threads != 1 else [])


def configuration(backend: str, parameters: Mapping, threads: int = 1) -> Configuration:
    """Of resolved parameters or of those that were asked for: the same."""
    defaults = DEFAULTS.get(backend, {})
    told = {key: _plain(value) for key, value in parameters.items() if key not in NO_CHOICE}
    choices = {key: value for key, value in told.items() if value != _plain(defaults.get(key)) or key not in defaults}
    if backend == "fcl" and choices.get("query") != "node_collide":
        choices.pop("node_radius_m", None)
    if float(choices.get(WANTED_ERROR, 0)) > 0:
        choices.pop(EDGE_OF_CUBES[backend], None)
    if float(choices.get(WANTED_ERROR, 0)) > 0 or float(choices.get(EDGE_OF_CUBES.get(backend), 0)) > 0:
        choices.pop("cells", None)
    return Configuration(backend, tuple(sorted(choices.items())), threads)


def _plain(value) -> str:
    try:
        return f"{float(value):.12g}"
    except (TypeError, ValueError):
        return str(value)


def _word(key: str, value: str) -> str:
    if key.endswith("_m"):
        return f"{key.removesuffix('_m').replace('_', ' ')} {1e3 * float(value):g} mm"
    if key == "bounding_volume":
        return value
    return WORDS.get((key, value), f"{key.replace('_', ' ')} {value}")
