"""Run folders with known numbers, as `musclebench run` writes them."""

import csv
import json
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

import fake_registry


@dataclass(frozen=True)
class Costs:
    detect_ns: int
    structure_bytes: int
    first_bytes: int  # of the process, before the first frame


MUSCLES = fake_registry.NODES
ROLES = fake_registry.roles()
COSTS = {
    ROLES.control: Costs(0, 0, 100_000_000),
    ROLES.unit: Costs(1_000_000, 70_000, 110_000_000),
    ROLES.field: Costs(3_000_000, 15_000_000, 125_000_000),
    ROLES.choices: Costs(200_000_000, 90_000_000, 200_000_000),
    ROLES.exact: Costs(20_000_000, 20_000_000, 130_000_000),
}
OTHER_NS = 1_000_000
STATIC = {"axis": [1, 0, 0], "centre_m": [0, 0, 0], "angles_rad": []}
COLUMNS = [
    "frame", "angle_deg", "warm_up", "edge_length_ns", "bending_ns", "volume_ns", "attachment_ns", "predict_ns",
    "update_ns", "detect_ns", "respond_ns", "finish_ns", "frame_ns", "recording_ns", "judging_ns", "contacts", "nodes_inside",
    "max_depth_m", "p99_depth_m", "mean_depth_m", "missed_contacts", "false_contacts", "volume_m3", "resident_bytes",
    "self_intersecting_triangles",
]
MUSCLE_COLUMNS = [
    "frame", "angle_deg", "muscle", "contacts", "nodes_inside", "max_depth_m", "p99_depth_m", "mean_depth_m",
    "nodes_inside_muscles", "max_muscle_depth_m", "volume_m3", "max_edge_stretch", "p99_edge_stretch",
]
PAIR_COLUMNS = ["frame", "angle_deg", "muscle", "other", "contacts", "detect_ns", "crossing_triangles"]


def backends() -> list[str]:
    """Those that fake_raw writes runs of. What it imports takes longer than the stand-in of the program itself, which does
    without."""
    from musclebench.paper.paper_backends import paper_backends

    return [name for name in paper_backends() if name in COSTS]


@dataclass
class Body:
    """A surface in the rest pose."""

    vertices_m: np.ndarray
    triangles: np.ndarray


@dataclass
class Snapshot:
    frame: int
    angle_deg: float
    vertices_m: np.ndarray
    depth_m: np.ndarray
    attached: np.ndarray
    poses: list = field(default_factory=list)  # (rotation (3, 3), translation_m (3,)) a bone


def sphere(centre_m, radius_m: float, rings: int = 12) -> Body:
    """A closed latitude-longitude sphere."""
    polar, turn = np.linspace(0, np.pi, rings + 1)[1:-1], np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    grid = [(np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)) for p in polar for t in turn]
    vertices = np.array([*grid, (0, 0, 1), (0, 0, -1)]) * radius_m + np.asarray(centre_m)
    wide, top, bottom = 2 * rings, len(grid), len(grid) + 1
    triangles = []
    for i in range(wide):
        j = (i + 1) % wide
        last = (rings - 2) * wide
        triangles += [(top, i, j), (bottom, last + j, last + i)]
        for ring in range(rings - 2):
            a, b = ring * wide + i, ring * wide + j
            triangles += [(a, a + wide, b), (b, a + wide, b + wide)]
    return Body(vertices, np.array(triangles))


def turn_about_x(angle_deg: float, centre_m) -> tuple[np.ndarray, np.ndarray]:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return rotation, np.asarray(centre_m) - rotation @ np.asarray(centre_m)


def frame_rows(backend: str, frames: int) -> list[dict]:
    """Detection takes what COSTS says in every frame; the rest of the loop OTHER_NS; depths grow to the middle."""
    rows, costs = [], COSTS[backend]
    for frame in range(1, frames + 1):
        flexion = 1 - abs(2 * frame / frames - 1)
        row = dict.fromkeys(COLUMNS, "")
        row |= {
            "frame": frame, "angle_deg": repr(90.0 * flexion), "warm_up": int(frame <= 2), "update_ns": 0,
            "edge_length_ns": OTHER_NS - 400_000, "bending_ns": 400_000, "volume_ns": 0, "attachment_ns": 0,
            "predict_ns": 0, "finish_ns": 0, "recording_ns": 1000, "judging_ns": 9_000_000,
            "detect_ns": costs.detect_ns, "respond_ns": 0, "frame_ns": costs.detect_ns + OTHER_NS,
            "contacts": 10, "nodes_inside": 5, "max_depth_m": repr(0.002 * flexion),
            "mean_depth_m": repr(0.001 * flexion),
            "p99_depth_m": repr(0.0015 * flexion), "missed_contacts": 1, "false_contacts": 2, "self_intersecting_triangles": 0,
            "resident_bytes": costs.first_bytes + 1000 * frame,
        }
        rows.append(row)
    return rows


def muscle_record(name: str, vertices: int) -> dict:
    return {"name": name, "vertices": vertices, "triangles": 2 * vertices - 4}


def muscle_rows(names: list[str], frames: int) -> list[dict]:
    """The n-th muscle is n mm deep in bones and n / 2 mm in muscles at most, and n % larger after the first frame."""
    rows = []
    for frame in range(1, frames + 1):
        flexion = 1 - abs(2 * frame / frames - 1)
        for n, name in enumerate(names, 1):
            rows.append({
                "frame": frame, "angle_deg": repr(90.0 * flexion), "muscle": name, "contacts": 10 * n,
                "nodes_inside": 3 * n, "max_depth_m": repr(1e-3 * n * flexion), "p99_depth_m": repr(8e-4 * n * flexion),
                "mean_depth_m": repr(5e-4 * n * flexion), "nodes_inside_muscles": 2 * n,
                "max_muscle_depth_m": repr(5e-4 * n * flexion),
                "volume_m3": repr(2e-4 * (1 if frame == 1 else 1 + n / 100)), "max_edge_stretch": 1 + n / 10,
                "p99_edge_stretch": 1 + n / 20,
            })
    return rows


def pair_rows(names: list[str], bones: list[str], frames: int) -> list[dict]:
    """Of each muscle with each bone, and of neighbours in the list: the n-th pair takes n ms a frame, 100 times that in
    warm-up, and has 4 n contacts."""
    pairs = [*((name, bone) for bone in bones for name in names), *pairwise(names)]
    return [{"frame": frame, "angle_deg": "0.0", "muscle": pair[0], "other": pair[1], "contacts": 4 * n, "crossing_triangles": 0,
             "detect_ns": n * (100_000_000 if frame <= 2 else 1_000_000)}
            for frame in range(1, frames + 1) for n, pair in enumerate(pairs, 1)]


def write_rows(path: Path, columns: list[str], rows: list[dict]) -> None:
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


BONE_PRESSURE_COLUMNS = ("bone", "vertex", "pressure_pa", "force_x_n", "force_y_n", "force_z_n")


def run_record(scene: str, backend: str, frames: int, status: str = "ok", detail: str = "") -> dict:
    muscle, costs = scene.split("/")[-1], COSTS[backend]
    case = {"scene": scene, "preset": "paper", "backend": backend, "parameters": {},
            "threads": 1, "repetition": 0}
    return {
        "schema_version": 1, "status": status, "status_detail": detail,
        "run_id": f"id-{muscle}-{backend}", "case": case, "implementations": {backend: f"library of {backend}"},
        "muscle": muscle_record(muscle, MUSCLES.get(muscle, 1000)),
        "bones": [{"name": "pelvis"}, {"name": "femur"}],
        "attachments": [{"name": "origin", "bone": "pelvis", "nodes": 7},
                        {"name": "insertion", "bone": "femur", "nodes": 3}],
        "build": {"git": "abc1234", "compiler": "GNU 12.2.0", "flags": "-O2", "type": "Release"},
        "machine": {"cpu": "A processor", "cores": 2, "governor": "performance"},
        "structure_bytes": costs.structure_bytes, "build_ns": 5_000_000,
        "cpu_ns": {"before_first_frame": 900_000_000, "after_last_frame": 2_000_000_000},
        "memory": {"before_first_frame_bytes": costs.first_bytes,
                   "after_last_frame_bytes": costs.first_bytes + 20_000_000,
                   "peak_bytes": costs.first_bytes + 30_000_000},
        "state_hash": "00ff", "wall_ns": 1_000_000_000, "frames": frames, "snapshots": [],
    }


def write_run(folder: Path, scene: str, backend: str, frames: int = 20, status: str = "ok", detail: str = "",
              bones: dict[str, Body] | None = None, triangles=None, snapshots=(), motions=MappingProxyType({}),
              loop=None, muscles=MappingProxyType({})) -> Path:
    """`muscles`: vertices of each of several muscles that touch, by name."""
    folder.mkdir(parents=True)
    record = run_record(scene, backend, frames, status, detail)
    if loop is not None:
        record["case"]["loop"] = loop
    write_rows(folder / "frames.csv", COLUMNS, frame_rows(backend, frames))
    if muscles:
        record["muscles"] = [muscle_record(name, vertices) for name, vertices in muscles.items()]
        record["case"]["muscle_contact"] = [{"muscles": list(pair)} for pair in pairwise(muscles)]
        write_rows(folder / "muscles.csv", MUSCLE_COLUMNS, muscle_rows(list(muscles), frames))
        write_rows(folder / "pairs.csv", PAIR_COLUMNS, pair_rows(list(muscles), [bone["name"] for bone in record["bones"]], frames))
    if bones:
        record["bones"] = [{"name": name, "motion": motions.get(name, STATIC)} for name in bones]
        (folder / "meshes").mkdir()
        for name, bone in bones.items():
            write_ply(folder / "meshes" / f"{name}.ply", bone.vertices_m, bone.triangles)
    for snapshot in snapshots:
        record["snapshots"].append(_write_snapshot(folder, snapshot, triangles))
    (folder / "run.json").write_text(json.dumps(record))
    return folder


def add_fibres(folder: Path, muscle: str, stretches) -> None:
    """One fibre of the muscle, with its largest stretch at rest and in each frame."""
    record = json.loads((folder / "run.json").read_text())
    record["fibres"] = [{"muscle": muscle, "asked": 1, "followed": 1}]
    (folder / "run.json").write_text(json.dumps(record))
    rows = [{"frame": frame, "muscle": muscle, "max_stretch": stretch} for frame, stretch in enumerate(stretches)]
    write_rows(folder / "fibres.csv", ["frame", "muscle", "max_stretch"], rows)
    write_rows(folder / "fibre_lengths.csv", ["frame", "muscle"], [{key: row[key] for key in ("frame", "muscle")} for row in rows])


def press_bones(folder: Path, pressures_pa: dict[tuple[str, int], float], area_m2: float = 1e-4) -> None:
    """At all moments that were kept. `pressures_pa`: by bone and vertex."""
    record = json.loads((folder / "run.json").read_text())
    rows = [{"bone": bone, "vertex": vertex, "pressure_pa": pa, "force_x_n": 0, "force_y_n": 0, "force_z_n": -pa * area_m2}
            for (bone, vertex), pa in pressures_pa.items()]
    for entry in record["snapshots"]:
        entry["bone_pressure"] = f"snapshots/bones_{entry['frame']:04d}.csv"
        write_rows(folder / entry["bone_pressure"], BONE_PRESSURE_COLUMNS, rows)
    (folder / "run.json").write_text(json.dumps(record))


def _write_snapshot(folder: Path, snapshot: Snapshot, triangles) -> dict:
    name = f"snapshots/frame_{snapshot.frame:04d}.ply"
    (folder / "snapshots").mkdir(exist_ok=True)
    extra = {"depth_m": snapshot.depth_m.astype("<f8"), "surface_depth_m": 2 * snapshot.depth_m.astype("<f8"), "attached": snapshot.attached.astype("u1")}
    write_ply(folder / name, snapshot.vertices_m, triangles, extra)
    poses = [{"rotation": np.ravel(r).tolist(), "translation_m": np.asarray(t).tolist()} for r, t in snapshot.poses]
    return {"frame": snapshot.frame, "angle_deg": snapshot.angle_deg, "file": name, "bone_poses": poses}


def write_ply(path: Path, vertices_m, triangles, extra: dict | None = None) -> None:
    extra = extra or {}
    kinds = {"f8": "double", "u1": "uchar"}
    fields = [(axis, "<f8") for axis in "xyz"] + [(name, values.dtype.str) for name, values in extra.items()]
    rows = np.empty(len(vertices_m), dtype=fields)
    for i, axis in enumerate("xyz"):
        rows[axis] = np.asarray(vertices_m)[:, i]
    for name, values in extra.items():
        rows[name] = values
    faces = np.empty(len(triangles), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    header += [f"property {kinds[kind[1:]]} {name}" for name, kind in fields]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    path.write_bytes(("\n".join(header) + "\n").encode() + rows.tobytes() + faces.tobytes())
