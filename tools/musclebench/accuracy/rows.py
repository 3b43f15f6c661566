"""accuracy.csv, one row a case and repetition, and study.csv, one row a configuration with medians and intervals."""

import json
import math

import pandas as pd

from ..results.records import inner
from ..results.run_folder import COLLISION_STAGES, count_of_warnings
from ..results.statistics import paired_ratio
from .aggregates import Aggregate, number, unit_of_price
from .cases import StudyCase

ACCURACY_KEYS = [
    "contacts", "true_contacts", "missed_contacts", "false_contacts", "measured_contacts", "max_depth_error_m",
    "p99_depth_error_m", "mean_depth_error_m", "max_normal_error_deg", "p99_normal_error_deg", "mean_normal_error_deg",
    "max_missed_depth_m", "max_false_distance_m",
]
OFFSET_KEYS = [
    "sites", "open_sites", "p99_offset_m", "max_offset_m", "p99_inward_m", "max_inward_m", "p99_outward_m", "max_outward_m",
]
OUTCOME_KEYS = [
    "max_depth_m", "p99_depth_m", "p99_contact_depth_m", "max_surface_depth_m", "p99_surface_depth_m", "max_volume_error",
    "final_volume_error", "tunnelled_nodes", "stuck_nodes", "collision_ns", "loop_ns",
]


def accuracy_rows(cases: list[StudyCase]) -> pd.DataFrame:
    return pd.DataFrame([_case_row(case) for case in cases])


def study_rows(aggregates: list[Aggregate], build_seconds: dict) -> pd.DataFrame:
    return pd.DataFrame([_aggregate_row(aggregate, aggregates, build_seconds) for aggregate in aggregates])


def build_seconds_of(aggregates: list[Aggregate]) -> dict:
    """{(bones, configuration): median seconds}. A field that one case built and the others loaded counts as built, and
    where all loaded it, what is noted beside it; a scene's bones are those of another scene where their meshes are the
    same."""
    measured: dict[tuple, list[float]] = {}
    noted: dict[tuple, list[float]] = {}
    for aggregate in aggregates:
        for case in aggregate.ok:
            is_loaded = case.run.record.get("structures") == "loaded"
            seconds = number(case.run.record, "kept_build_ns" if is_loaded else "build_ns") / 1e9
            if not math.isnan(seconds):
                (noted if is_loaded else measured).setdefault(_build_key(aggregate), []).append(seconds)
    return {key: float(pd.Series(seconds).median()) for key, seconds in (noted | measured).items()}


def build_seconds(aggregate: Aggregate, measured: dict) -> float:
    return measured.get(_build_key(aggregate), math.nan)


def _build_key(aggregate: Aggregate) -> tuple:
    record = aggregate.ok[0].run.record if aggregate.ok else {}
    bones = tuple(bone.get("mesh_sha256", aggregate.scene) for bone in record.get("bones", []))
    return bones or (aggregate.scene,), aggregate.configuration


def _case_row(case: StudyCase) -> dict:
    record, frames = case.run.record, case.run.timed_frames
    recording, build, machine = (record.get(key) or {} for key in ("recording", "build", "machine"))
    times = {key: frames[key].median() for key in [*COLLISION_STAGES, "collision_ns"]}
    return {
        "case": case.name, **_identity(case.mode, case.scene, case.configuration),
        "preset": record["case"].get("preset"), "repetition": case.repetition, "status": case.run.status,
        "status_detail": record.get("status_detail", ""), "warnings": count_of_warnings(record), "disturbance": case.disturbance,
        "frames": len(case.run.frames) or None,
        "stride": recording.get("stride"), **{f"median_{key}": value for key, value in times.items()},
        "build_ns": record.get("build_ns"), "structures": record.get("structures"),
        "structure_bytes": record.get("structure_bytes"), "band_m": record.get("band_m"),
        **{key: number(record, "accuracy", key) for key in ACCURACY_KEYS},
        **{key: number(record, "surface_offset", key) for key in OFFSET_KEYS},
        **{f"outcome_{key}": number(record, "outcome", key) for key in OUTCOME_KEYS},
        "contact_hash": record.get("contact_hash"), "queries_hash": record.get("queries_hash"), "state_hash": record.get("state_hash"),
        "recording_sha256": recording.get("sha256"), "wall_ns": record.get("wall_ns"), "git": build.get("git"),
        "compiler": build.get("compiler"), "flags": build.get("flags"), "cpu": machine.get("cpu"),
        "run_id": record.get("run_id"),
    }


def _aggregate_row(aggregate: Aggregate, aggregates: list[Aggregate], measured: dict) -> dict:
    time, ratio = aggregate.collision_ms, ratio_to(aggregate, unit_of_price(aggregates, aggregate))
    stages = {stage.replace("_ns", "_ms"): aggregate.stage_ms(stage) for stage in COLLISION_STAGES}
    chosen, record = aggregate.configuration, aggregate.ok[0].run.record if aggregate.ok else {}
    return {
        **_identity(aggregate.mode, aggregate.scene, chosen), "spoken": chosen.spoken, "series": chosen.series,
        "fineness": chosen.fineness, "is_default": chosen.is_default, "is_advised": chosen.is_advised,
        "is_control": chosen.about.is_control, "status": aggregate.status,
        "detail": aggregate.detail, "is_disturbed": aggregate.is_disturbed,
        "repetitions": len(aggregate.cases), "ok_repetitions": len(aggregate.ok),
        "distinct_answers": len(aggregate.answers) or None,
        "frames": time.frames or None, "collision_ms": time.value, "collision_ms_low": time.low,
        "collision_ms_high": time.high, **stages, "times_unit": ratio.value, "times_unit_low": ratio.low,
        "times_unit_high": ratio.high, "build_s": build_seconds(aggregate, measured),
        "structure_bytes": aggregate.structure_bytes,
        **{key: aggregate.number("accuracy", key) for key in ACCURACY_KEYS},
        **{key: aggregate.number("surface_offset", key) for key in OFFSET_KEYS},
        **{f"outcome_{key}": aggregate.number("outcome", key) for key in OUTCOME_KEYS},
        "verdict": aggregate.verdict if aggregate.is_right_or_wrong else "",
        "stride": inner(record, "recording", "stride"),
        "declared_missed_m": aggregate.number("declared", "missed_depth_m"),
        "declared_false_m": aggregate.number("declared", "false_distance_m"),
        **{name: record.get(name) for name in ("queries_hash", "contact_hash", "state_hash")},
    }


def ratio_to(aggregate: Aggregate, reference: Aggregate | None):
    """Of collision times, frame by frame."""
    return paired_ratio(aggregate.times_ns, reference.times_ns if reference else {})


def _identity(mode: str, scene: str, chosen) -> dict:
    return {
        "mode": mode, "scene": scene, "muscle": scene.split("/")[-1], "backend": chosen.backend,
        "configuration": chosen.name, "parameters": json.dumps(dict(chosen.choices)), "threads": chosen.threads,
        "cells": chosen.cells, "cell_edge_m": chosen.cube_edge_m,
    }
