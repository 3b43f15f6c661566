"""The configurations of the accuracy study: each backend with its resolutions or choices, and what a step may cost.

Times are guesses for the LHDL iliacus (6,931 nodes, 2 bones) on one thread of a 2.5 GHz core. They choose strides and
repetitions, deal the parts of a split study, and feed the progress bar, which corrects them.
"""

from dataclasses import dataclass, replace

VOXEL_CELLS = (16, 32, 64, 128, 256)
VOXEL_EDGES_M = (8e-3, 4e-3, 2e-3, 1e-3)
SDF_CELLS = (8, 16, 32, 64, 128)
SDF_PRECISIONS = ("float", "double")
SDF_EDGES_M = (8e-3, 4e-3, 2e-3)
SDF_ADAPTIVE = (  # wanted error in mm, seconds to build, bytes
    (0.3, 1.5, 1.2e6), (0.1, 2.4, 4.1e6), (0.05, 3.6, 9.8e6), (0.03, 6.4, 2.3e7), (0.02, 11.0, 4.6e7),
)
BUDGETS_BY_DEFAULT = {"sdf": "on", "bvh": "on"}
QUICK_VOXELS = {"cells": (16, 64, 256), "voxel_size_m": (4e-3,)}
QUICK_SDFS = {"cells": (16, 32, 64), "cell_size_m": (4e-3,)}
QUICK_ADAPTIVE = (0.1,)

BONES = 2
BOXES_M3 = 0.0125  # of a pelvis and a femur together
SDF_SECONDS_A_CELL = 6e-6
SDF_BYTES_A_CELL = 30  # float
VOXEL_SECONDS_A_CELL = 1e-7

FCL_BUILD_SECONDS = 1.5
FCL = (
    # ms a step, runs with --quick, drives the muscle there, parameters
    (25, True, True, {}),  # the paper's way
    (13, True, True, {"bounding_volume": "OBB"}),
    (60, False, False, {"bounding_volume": "RSS"}),
    (20, False, False, {"bounding_volume": "kIOS"}),
    (53, False, False, {"bounding_volume": "AABB"}),
    (134, False, False, {"bounding_volume": "KDOP24"}),
    (27, False, False, {"update": "refit_top_down"}),
    (30, False, False, {"update": "rebuild"}),
    (45, False, False, {"model": "update"}),
    (25, False, False, {"manager": "sweep_and_prune"}),
    (25, True, False, {"manager": "none"}),
    (25, False, False, {"solver": "indep"}),
    (15, False, False, {"bounding_volume": "OBB", "update": "rebuild"}),
    (60, False, False, {"bounding_volume": "RSS", "update": "rebuild"}),
    (60, False, False, {"bounding_volume": "RSS", "update": "refit_top_down"}),
    (87, True, False, {"query": "node_distance"}),
    (0.5, True, True, {"query": "node_distance", "clearance_cache": "on"}),
    (82, False, False, {"query": "node_distance", "bounding_volume": "RSS"}),
    (85, False, False, {"query": "node_distance", "bounding_volume": "kIOS"}),
    (87, False, False, {"query": "node_distance", "manager": "none"}),
    (87, False, False, {"query": "node_distance", "solver": "indep"}),
    (13, True, True, {"query": "node_collide"}),
    (4, False, True, {"query": "node_collide", "bounding_volume": "OBB"}),
    (17, False, False, {"query": "node_collide", "node_radius_m": 2e-3}),
)
FCL_THREADS = ((20, {}), (9, {"bounding_volume": "OBB"}), (45, {"query": "node_distance"}))  # with 2 threads


@dataclass(frozen=True)
class Configuration:
    backend: str
    parameters: tuple[tuple[str, object], ...] = ()
    threads: int = 1
    step_ms: float = 0.0
    build_seconds: float = 0.0
    stored_bytes: float = 0.0  # 0: it stores no structures
    in_quick: bool = True
    replays: bool = True
    drives: bool = True  # coupled with --quick, too
    is_probed: bool = False

    @property
    def label(self) -> str:
        """Unique, and fit for a folder's name: sdf-cells=64,precision=float."""
        words = [f"{key}={value}" for key, value in self.parameters]
        words += [f"threads={self.threads}"] if self.threads > 1 else []
        return "-".join([self.backend, *([",".join(words)] if words else [])])

    @property
    def has_budgets(self) -> bool:
        """Motion budgets are spent by motion: they are worth nothing where steps are left out."""
        return dict(self.parameters).get("clearance_cache", BUDGETS_BY_DEFAULT.get(self.backend)) == "on"

    @property
    def stores(self) -> bool:
        return self.stored_bytes > 0


def configurations() -> list[Configuration]:
    return [
        Configuration("null", replays=False),
        *_voxels(), *_sdfs(), *_adaptive_sdfs(), *_fcls(),
        Configuration("bvh", step_ms=0.3, build_seconds=0.7),
        Configuration("bvh", (("clearance_cache", "off"),), step_ms=5.0, build_seconds=0.7),
        Configuration("brute_force", step_ms=60_000.0, in_quick=False),
    ]


def _voxels() -> list[Configuration]:
    sizes = [("cells", cells) for cells in VOXEL_CELLS] + [("voxel_size_m", edge) for edge in VOXEL_EDGES_M]
    return [Configuration("voxel", ((key, size),), step_ms=0.05, is_probed=True, in_quick=size in QUICK_VOXELS[key],
                          build_seconds=0.1 + VOXEL_SECONDS_A_CELL * _cells(key, size)) for key, size in sizes]


def _sdfs() -> list[Configuration]:
    sizes = [("cells", cells, precision) for cells in SDF_CELLS for precision in SDF_PRECISIONS]
    sizes += [("cell_size_m", edge, "float") for edge in SDF_EDGES_M]
    cells_64 = _sdf("cells", 64, "float")
    no_budgets = replace(cells_64, parameters=(*cells_64.parameters, ("clearance_cache", "off")), step_ms=0.1,
                         stored_bytes=0.0, is_probed=False)  # the probe would be that of `cells_64`
    return [*(_sdf(key, size, precision) for key, size, precision in sizes), no_budgets]


def _sdf(key: str, size: float, precision: str) -> Configuration:
    cells, width = _cells(key, size), 2 if precision == "double" else 1
    return Configuration(
        "sdf", ((key, size), ("precision", precision)), step_ms=0.05, build_seconds=SDF_SECONDS_A_CELL * cells,
        stored_bytes=SDF_BYTES_A_CELL * width * cells, is_probed=True,
        in_quick=size in QUICK_SDFS[key] and (precision == "float" or size == 32))


def _adaptive_sdfs() -> list[Configuration]:
    return [Configuration("sdf", (("max_error_mm", error), ("precision", "float")), step_ms=0.05, build_seconds=seconds,
                          stored_bytes=stored, is_probed=True, in_quick=error in QUICK_ADAPTIVE)
            for error, seconds, stored in SDF_ADAPTIVE]


def _fcls() -> list[Configuration]:
    one = [Configuration("fcl", tuple(parameters.items()), step_ms=ms, in_quick=quick, drives=coupled,
                         build_seconds=FCL_BUILD_SECONDS) for ms, quick, coupled, parameters in FCL]
    two = [Configuration("fcl", tuple(parameters.items()), threads=2, step_ms=ms, in_quick=False, drives=False,
                         build_seconds=FCL_BUILD_SECONDS) for ms, parameters in FCL_THREADS]
    return one + two


def _cells(key: str, size: float) -> float:
    """Of all bones: of fixed count along the axes, or cubes of an edge in metres."""
    return BONES * size**3 if key == "cells" else BOXES_M3 / size**3
