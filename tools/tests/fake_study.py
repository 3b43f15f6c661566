"""Folders of an accuracy study with known numbers, as `musclebench replay`, `run` and `probe` write them."""

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import fake_registry
import fake_runs
from musclebench.accuracy import cases
from musclebench.accuracy.aggregates import Aggregate, aggregates_of, of_mode
from musclebench.program.registry import save_registry

ROLES = fake_registry.roles()
FRAMES = 40
BAND_M = 0.01
TRUE_CONTACTS = 10_000
REPLAY_COLUMNS = [
    "frame", "angle_deg", "warm_up", "iterations", "update_ns", "detect_ns", "respond_ns", "contacts", "true_contacts",
    "missed_contacts", "false_contacts", "measured_contacts", "max_depth_error_m", "p99_depth_error_m",
    "mean_depth_error_m", "max_normal_error_deg", "p99_normal_error_deg", "mean_normal_error_deg",
]
PROBE_COLUMNS = ["bone", "region", "points", "max_error_m", "p99_error_m", "mean_error_m", "rms_error_m", "wrong_side"]
EDGES_M = {"pelvis": 0.2, "femur": 0.1}  # of the bones' boxes
SMOOTH_ORDER, SHARP_ORDER, VOXEL_ORDER = 3.0, 1.0, 1.0


@dataclass
class Truth:
    """What a configuration does in each frame and in the whole run, in the units of the figures."""

    ms: float = 1.0
    p99_mm: float = 0.1
    missed: int = 0
    false: int = 0
    structure_bytes: int = 1_000_000
    build_s: float = 1.0
    is_asked: bool = True  # can be asked about single points
    remaining_mm: float = 0.1
    shift_mm: float = 0.0  # of the whole muscle against the exact run's
    arm_off_mm: float | None = None  # of the moment arm against the exact run's; None: no fibres are followed
    noise: float = 0.02  # of times, relative
    parameters: dict = field(default_factory=dict)
    threads: int = 1
    structures: str = "built"


NOT_OF_A_REPLAY = ("attachments", "cpu_ns", "memory", "state_hash", "snapshots")
NOT_OF_A_PROBE = (*NOT_OF_A_REPLAY, "wall_ns", "frames")


def record(mode: str, scene: str, backend: str, truth: Truth, repetition: int = 0, status: str = "ok",
           detail: str = "") -> dict:
    """run.json without what only one mode has."""
    made = fake_runs.run_record(scene, ROLES.field, FRAMES, status, detail)
    made["case"] |= {"mode": mode, "backend": backend, "parameters": truth.parameters, "threads": truth.threads,
                     "repetition": repetition}
    made |= {"implementations": {backend: f"library of {backend}"}}
    made |= {"structure_bytes": truth.structure_bytes, "build_ns": round(1e9 * truth.build_s),
             "structures": truth.structures, "snapshots": []}
    foreign = NOT_OF_A_REPLAY if mode == "replay" else NOT_OF_A_PROBE if mode == "probe" else ()
    return {key: value for key, value in made.items() if key not in foreign}


def frame_times_ns(truth: Truth, seed: int) -> list[int]:
    random = np.random.default_rng(seed)
    return [round(1e6 * truth.ms * (1 + truth.noise * value)) for value in random.normal(size=FRAMES)]


def write_replay(folder: Path, scene: str, backend: str, truth: Truth, repetition: int = 0, stride: int = 1) -> Path:
    """A tenth of the time is update, eight detect, one respond."""
    folder.mkdir(parents=True)
    note_registry(folder.parents[1])
    made = record("replay", scene, backend, truth, repetition)
    reported = TRUE_CONTACTS - truth.missed + truth.false
    made |= {
        "band_m": BAND_M, "contact_hash": f"hash-{backend}-{truth.parameters}",
        "recording": {"file": "a.recording", "sha256": "00aa", "bytes": 1000, "frames": FRAMES,
                      "iterations": 3 * FRAMES, "stride": stride},
    }
    if repetition == 0:  # the others are not judged
        made["accuracy"] = {
            "contacts": reported, "true_contacts": TRUE_CONTACTS, "missed_contacts": truth.missed,
            "false_contacts": truth.false, "measured_contacts": TRUE_CONTACTS + truth.false,
            "max_depth_error_m": 3e-3 * truth.p99_mm, "p99_depth_error_m": 1e-3 * truth.p99_mm,
            "mean_depth_error_m": 3e-4 * truth.p99_mm, "max_normal_error_deg": 3.0, "p99_normal_error_deg": 2.0,
            "mean_normal_error_deg": 1.0, "max_missed_depth_m": 1e-3 if truth.missed else 0.0,
            "max_false_distance_m": 1e-3 if truth.false else 0.0,
        }
        made["surface_offset"] = offsets(truth) if truth.is_asked else None
    times = frame_times_ns(truth, repetition)
    rows = [_replay_row(frame, times[frame - 1], truth) for frame in range(1, FRAMES + 1) if frame % stride == 0]
    made["frames"] = len(rows)
    fake_runs.write_rows(folder / "frames.csv", REPLAY_COLUMNS, rows)
    (folder / "run.json").write_text(json.dumps(made))
    return folder


def offsets(truth: Truth) -> dict:
    """Inwards; outwards half as far."""
    own = {"sites": 100, "open_sites": 0, "p99_offset_m": 1e-3 * truth.p99_mm, "max_offset_m": 3e-3 * truth.p99_mm,
           "p99_inward_m": 1e-3 * truth.p99_mm, "max_inward_m": 3e-3 * truth.p99_mm, "p99_outward_m": 5e-4 * truth.p99_mm,
           "max_outward_m": 5e-4 * truth.p99_mm}
    kinds = [{"difficulty": "ridge"} | own, {"difficulty": "flat"} | own | {"p99_offset_m": 1e-4 * truth.p99_mm}]
    return own | {"of_difficulties": kinds, "of_pairs": [{"muscle": "muscle", "bone": "pelvis"} | own]}


def _replay_row(frame: int, ns: int, truth: Truth) -> dict:
    row = dict.fromkeys(REPLAY_COLUMNS, "")
    return row | {
        "frame": frame, "angle_deg": _angle(frame), "warm_up": int(frame <= 2), "iterations": 3, "update_ns": ns // 10,
        "detect_ns": 8 * ns // 10, "respond_ns": ns - ns // 10 - 8 * ns // 10, "contacts": 10, "true_contacts": 10,
        "missed_contacts": truth.missed // FRAMES, "false_contacts": truth.false // FRAMES, "measured_contacts": 10, "max_depth_error_m": 3e-3 * truth.p99_mm,
        "p99_depth_error_m": 1e-3 * truth.p99_mm, "mean_depth_error_m": 3e-4 * truth.p99_mm,
    }


def write_coupled(folder: Path, scene: str, backend: str, truth: Truth, repetition: int = 0) -> Path:
    """The muscle is a sphere, in the first repetition with snapshots of rest, full flexion and the end."""
    folder.mkdir(parents=True)
    note_registry(folder.parents[1])
    made = record("coupled", scene, backend, truth, repetition)
    made["state_hash"] = f"hash-{backend}-{truth.parameters}"
    times = frame_times_ns(truth, repetition)
    if repetition == 0:
        depth = 1e-3 * truth.remaining_mm
        made["outcome"] = {
            "max_depth_m": 1.2 * depth, "p99_depth_m": depth, "p99_contact_depth_m": depth, "max_surface_depth_m": 2.4 * depth,
            "p99_surface_depth_m": 2 * depth, "max_volume_error": 0.02, "final_volume_error": 0.01,
            "tunnelled_nodes": truth.missed // 100, "stuck_nodes": 3, "collision_ns": sum(times),
            "loop_ns": sum(times) + FRAMES * 4_000_000,
        }
        ball = fake_runs.sphere((truth.shift_mm * 1e-3, 0, 0), 0.05)
        for frame in (0, FRAMES // 2, FRAMES):
            shot = fake_runs.Snapshot(frame, _angle(frame), ball.vertices_m, np.zeros(len(ball.vertices_m)),
                                      np.zeros(len(ball.vertices_m)))
            made["snapshots"].append(fake_runs._write_snapshot(folder, shot, ball.triangles))
    fake_runs.write_rows(folder / "frames.csv", fake_runs.COLUMNS, [_coupled_row(f, times[f - 1]) for f in range(1, FRAMES + 1)])
    if truth.arm_off_mm is not None:
        made["case"]["fibres"] = 100
        write_fibres(folder / "fibres.csv", scene, truth.arm_off_mm)
    (folder / "run.json").write_text(json.dumps(made))
    return folder


def write_fibres(path: Path, scene: str, arm_off_mm: float) -> None:
    """Of a muscle that lengthens by 50 mm and the error a radian; where the joint turns back the slope is nonsense."""
    rows, before = [], 0.0
    for frame in range(FRAMES + 1):
        angle = 45 * (1 - math.cos(2 * math.pi * frame / FRAMES))
        standing, before = abs(angle - before) < 1, angle
        rows.append({"frame": frame, "angle_deg": angle, "muscle": scene.split("/")[-1],
                     "mean_length_m": 0.2 + 1e-3 * (50 + arm_off_mm) * math.radians(angle),
                     "mean_moment_arm_m": 9.0 * arm_off_mm if standing else 1e-3 * (50 + arm_off_mm)})
    fake_runs.write_rows(path, list(rows[0]), rows)


def _coupled_row(frame: int, ns: int) -> dict:
    row = dict.fromkeys(fake_runs.COLUMNS, "")
    return row | {
        "frame": frame, "angle_deg": _angle(frame), "warm_up": int(frame <= 2), "attachment_ns": 20_000,
        "edge_length_ns": 800_000, "volume_ns": 330_000, "bending_ns": 2_800_000, "predict_ns": 30_000,
        "finish_ns": 20_000, "update_ns": ns // 10, "detect_ns": 8 * ns // 10,
        "respond_ns": ns - ns // 10 - 8 * ns // 10,
        "frame_ns": ns + 4_000_000, "recording_ns": 1000, "judging_ns": 9_000_000, "contacts": 10, "nodes_inside": 1, "max_depth_m": 1e-4, "mean_depth_m": 1e-5,
        "missed_contacts": 0, "false_contacts": 0, "resident_bytes": 100_000_000, "volume_m3": 1e-4,
    }


def write_probe(folder: Path, scene: str, backend: str, truth: Truth) -> Path:
    """Errors that fall with the powers of the cell size that stand above."""
    folder.mkdir(parents=True)
    note_registry(folder.parents[1])
    made = record("probe", scene, backend, truth)
    rows = []
    for bone, edge in EDGES_M.items():
        cell = edge / truth.parameters["cells"]
        orders = {"smooth": SMOOTH_ORDER, "sharp": SHARP_ORDER} if backend == ROLES.field else \
            {"smooth": VOXEL_ORDER, "sharp": VOXEL_ORDER}
        for region, order in (orders | {"all": min(orders.values())}).items():
            error = 0.5 * cell * (cell / edge) ** (order - 1)
            rows.append({"bone": bone, "region": region, "points": 1000, "max_error_m": 2 * error, "p99_error_m": error,
                         "mean_error_m": error / 3, "rms_error_m": error / 2, "wrong_side": 0.01})
    fake_runs.write_rows(folder / "probe.csv", PROBE_COLUMNS, rows)
    made["bones"] = [{"name": bone, "mesh_sha256": f"sha-{bone}"} for bone in EDGES_M]
    made["probed"] = [{"name": bone, "cell_edge_m": edge / truth.parameters["cells"]} for bone, edge in EDGES_M.items()]
    (folder / "run.json").write_text(json.dumps(made))
    return folder


def write_failure(folder: Path, mode: str, scene: str, backend: str, status: str, truth: Truth | None = None) -> Path:
    folder.mkdir(parents=True)
    note_registry(folder.parents[1])
    made = {"schema_version": 1, "status": status, "status_detail": f"why {status}",
            "case": record(mode, scene, backend, truth or Truth())["case"]}
    (folder / "run.json").write_text(json.dumps(made))
    return folder


def note_registry(out_dir: Path) -> None:
    save_registry(fake_registry.registry(), out_dir)


def write_plan(out_dir: Path, cases: list[dict]) -> None:
    note_registry(out_dir)
    (out_dir / "experiment.json").write_text(json.dumps({"schema_version": 1, "cases": cases}))


def _angle(frame: int) -> float:
    return 90.0 * (1 - abs(2 * frame / FRAMES - 1))


SURFACES = {"bounding_volume": "OBBRSS", "manager": "dynamic_aabb_tree", "update": "refit", "model": "replace",
            "query": "surfaces", "node_radius_m": 5e-4, "solver": "libccd"}


SCENES = ("lhdl/iliacus", "lhdl/gluteus_medius")
SIZES = {"lhdl/iliacus": 1.0, "lhdl/gluteus_medius": 0.5}
GRID_64 = {"cells": 64, "voxel_size_m": 0.0}
REPLAYED = {  # ms and p99 error in mm on the iliacus
    ROLES.unit: Truth(0.2, 3.0, false=5000, structure_bytes=65_536, build_s=0.3, noise=0, parameters=GRID_64),
    f"{ROLES.field} 64": Truth(0.3, 0.25, noise=0, structure_bytes=15_000_000, build_s=12, parameters={"cells": 64}),
    f"{ROLES.field} 128": Truth(0.4, 0.08, noise=0, build_s=90, parameters={"cells": 128}),
    ROLES.choices: Truth(72, 0.02, missed=50, noise=0, parameters=SURFACES),
    f"{ROLES.choices} OBB": Truth(36, 0.02, missed=50, noise=0, parameters=SURFACES | {"bounding_volume": "OBB"}),
    f"{ROLES.choices} RSS": Truth(10, 0.02, missed=9990, noise=0, parameters=SURFACES | {"bounding_volume": "RSS"}),
    f"{ROLES.choices} threads": Truth(20, 0.02, missed=50, noise=0, parameters=SURFACES, threads=2),
    ROLES.exact: Truth(15, 1e-14, noise=0, build_s=0.4),
}


def write_muscles(out_dir: Path, scenes=SCENES, with_own_runs: bool = False) -> None:
    """`REPLAYED` on the scenes, twice each; the RSS of the one with choices is fast and wrong. Own runs: each also moved its
    own muscle."""
    for scene in scenes:
        for name, truth in REPLAYED.items():
            scaled = Truth(**{**vars(truth), "ms": truth.ms * SIZES[scene]})
            for repetition in range(2):
                folder = out_dir / "raw" / f"{scene.split('/')[1]}-{name}-r{repetition}"
                write_replay(folder, scene, name.split()[0], scaled, repetition)
            if with_own_runs:
                write_own_run(out_dir / "raw" / f"{scene.split('/')[1]}-{name}-coupled", scene, name.split()[0], scaled)


def write_own_run(folder: Path, scene: str, backend: str, truth: Truth) -> Path:
    """A coupled run that leaves what the offset says."""
    return write_coupled(folder, scene, backend, replace(truth, remaining_mm=truth.p99_mm))


def replays_of(out_dir: Path) -> list[Aggregate]:
    return of_mode(aggregates_of(cases.read_cases(out_dir)), "replay")


def realistic_truths() -> list[tuple[str, Truth]]:
    """About what the iliacus of the LHDL data gives: (backend, truth) of each configuration."""
    made = [(ROLES.control, Truth(0.0005, 11.0, structure_bytes=0, remaining_mm=9.0, shift_mm=4.0))]
    for cells in (16, 32, 64, 128, 256):
        mm = 3.0 * (64 / cells) ** 0.9
        made.append((ROLES.unit, Truth(0.22 * (cells / 64) ** 0.1, mm, false=5000, structure_bytes=2 * cells**3 // 8,
                                       build_s=3e-7 * cells**3, remaining_mm=mm, shift_mm=mm / 2,
                                       parameters={"cells": cells, "voxel_size_m": 0.0})))
    for edge in (8e-3, 4e-3, 2e-3, 1e-3):
        made.append((ROLES.unit, Truth(0.2 * (2e-3 / edge) ** 0.1, 900 * edge, structure_bytes=round(0.0125 / edge**3 / 8),
                                       remaining_mm=900 * edge, shift_mm=500 * edge,
                                       parameters={"cells": 64, "voxel_size_m": edge})))
    for cells in (8, 16, 32, 64, 128):
        mm = 0.3 * (64 / cells) ** 1.4
        made.append((ROLES.field, Truth(0.2 * (cells / 64) ** 0.32, mm, structure_bytes=60 * cells**3,
                                        build_s=4.6e-5 * cells**3, remaining_mm=mm / 3, shift_mm=mm / 2,
                                        parameters={"cells": cells, "cell_size_m": 0.0, "margin": 0.001})))
    for edge in (8e-3, 4e-3, 2e-3):
        mm = 0.25 * (edge / 2e-3) ** 1.4
        made.append((ROLES.field, Truth(0.21 * (2e-3 / edge) ** 0.3, mm, structure_bytes=round(0.375 / edge**3),
                                        remaining_mm=mm / 3, shift_mm=mm / 2, parameters={
                                            "cells": 64, "cell_size_m": edge, "margin": 0.001})))
    for wanted in (0.3, 0.1, 0.03):
        made.append((ROLES.field, Truth(0.2, 1.1 * wanted, structure_bytes=round(3.6e5 / wanted), build_s=0.4 / wanted,
                                        remaining_mm=wanted, shift_mm=wanted, parameters={
                                            "cells": 64, "max_error_mm": wanted})))
    made.append((ROLES.field, Truth(0.3, 0.3, structure_bytes=15_000_000, remaining_mm=0.1, shift_mm=0.2, parameters={
        "cells": 64, "cell_size_m": 0.0, "clearance_cache": "off"})))
    for ms, mm, missed, threads, choices in (
        (72, 0.02, 150, 1, {}), (40, 0.02, 150, 1, {"bounding_volume": "OBB"}),
        (60, 4.0, 9990, 1, {"bounding_volume": "RSS"}), (110, 0.02, 150, 1, {"bounding_volume": "kIOS"}),
        (200, 0.02, 150, 1, {"bounding_volume": "AABB"}), (260, 0.02, 150, 1, {"bounding_volume": "KDOP24"}),
        (95, 0.02, 150, 1, {"update": "refit_top_down"}), (90, 0.02, 150, 1, {"update": "rebuild"}),
        (110, 0.02, 150, 1, {"model": "update"}), (72, 0.02, 150, 1, {"manager": "sweep_and_prune"}),
        (72, 0.02, 150, 1, {"manager": "none"}), (73, 0.02, 150, 1, {"solver": "indep"}),
        (55, 0.02, 150, 1, {"bounding_volume": "OBB", "update": "rebuild"}),
        (800, 1e-14, 0, 1, {"query": "node_distance"}),
        (620, 1e-14, 0, 1, {"query": "node_distance", "solver": "indep"}),
        (700, 1e-14, 0, 1, {"query": "node_distance", "bounding_volume": "RSS"}),
        (60, 1.9, 8100, 1, {"query": "node_collide"}), (38, 0.02, 150, 2, {}),
    ):
        made.append((ROLES.choices, Truth(ms, mm, missed, structure_bytes=200_000_000, build_s=2.0,
                                          remaining_mm=max(mm, 0.05), shift_mm=mm, parameters=SURFACES | choices, threads=threads)))
    for ms, choices in ((0.3, {}), (15, {"clearance_cache": "off"})):
        made.append((ROLES.exact, Truth(ms, 1e-14, structure_bytes=23_000_000, build_s=0.4, remaining_mm=0.02,
                                        parameters=choices)))
    made.append((ROLES.reference, Truth(75_000, 1e-14, structure_bytes=11_000_000, build_s=0.05, remaining_mm=0.02)))
    return made


def write_realistic_study(out_dir: Path, scenes: dict[str, float], repetitions: int = 2) -> None:
    """`scenes`: {name: size against the iliacus}. With failures of each kind, and planned cases that have not run."""
    raw = out_dir / "raw"
    for scene, size in scenes.items():
        muscle = scene.split("/")[-1]
        for number, (backend, like_iliacus) in enumerate(realistic_truths()):
            truth = Truth(**{**vars(like_iliacus), "ms": like_iliacus.ms * size})
            name, many = f"{muscle}-{{}}-{backend}-{number}", 1 if truth.ms > 1000 else repetitions
            for repetition in range(many):
                end = f"-r{repetition}"
                if backend != ROLES.control:
                    write_replay(raw / (name.format("replay") + end), scene, backend, truth, repetition,
                                 stride=8 if truth.ms > 1000 else 1)
                if truth.ms < 1000 and truth.threads == 1:
                    write_coupled(raw / (name.format("coupled") + end), scene, backend, truth, repetition)
            if backend in (ROLES.unit, ROLES.field) and not math.prod(
                    truth.parameters.get(key, 0) for key in ("voxel_size_m", "cell_size_m")) and not any(
                    truth.parameters.get(key) for key in ("voxel_size_m", "cell_size_m", "clearance_cache")):
                write_probe(raw / name.format("probe"), scene, backend, truth)
        refused = Truth(parameters=SURFACES | {"bounding_volume": "RSS", "update": "refit_top_down"})
        write_failure(raw / f"{muscle}-refused", "replay", scene, ROLES.choices, "unsupported", refused)
        write_failure(raw / f"{muscle}-slow", "coupled", scene, ROLES.reference, "timeout")
    first = next(iter(scenes))
    write_plan(out_dir, [{"name": "not-yet", "mode": "replay", "scene": first, "backend": ROLES.unit, "threads": 1,
                          "parameters": {"cells": 48}, "repetition": 0}])
