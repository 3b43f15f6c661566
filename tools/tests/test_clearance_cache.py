"""A whole flexion ends in the same state, to the bit, with clearance cache and without."""

import json
from pathlib import Path

import pytest

from program import call, needs_program

pytestmark = needs_program


def final_state(out: Path, scene: str, *arguments: str) -> tuple[str, int]:
    """Hash of all positions and velocities at the end, and the contacts of the last detections of all frames."""
    done = call("run", scene, "--no-referee", "--out", out, *arguments)
    assert done.returncode == 0, done.stderr
    contacts = [line.split(",") for line in (out / "frames.csv").read_text().splitlines()]
    column = contacts[0].index("contacts")
    return json.loads((out / "run.json").read_text())["state_hash"], sum(int(row[column]) for row in contacts[1:])


@pytest.mark.parametrize("backend", [
    ["bvh"], ["sdf", "--param", "cells=24"], ["sdf", "--param", "max_error_mm=0.5"]], ids=" ".join)
@pytest.mark.parametrize("muscle", ["adductor_brevis", pytest.param("iliacus", marks=pytest.mark.long)])
def test_flexion_is_the_same_to_the_bit(tmp_path, backend, muscle):
    if muscle == "iliacus" and backend != ["bvh"]:
        pytest.skip("a field of the large muscle would take longer than it tells")
    frames = "40" if muscle == "iliacus" else "314" if backend == ["bvh"] else "100"
    states = [final_state(tmp_path / word, f"synthetic/{muscle}", "--backend", *backend, "--param",
                          f"clearance_cache={word}", "--frames", frames)
              for word in ("on", "off")]
    assert states[0] == states[1]
    assert states[0][1] > 0, "a flexion without contacts tells nothing"


@pytest.mark.long
def test_real_anatomy_is_the_same_to_the_bit(tmp_path, lhdl_folder):
    states = [final_state(tmp_path / f"{word}{threads}", "lhdl/gluteus_maximus", "--data", str(lhdl_folder),
                          "--backend", "bvh", "--param", f"clearance_cache={word}", "--frames", "25",
                          "--threads", threads)
              for word, threads in (("on", "1"), ("on", "2"), ("off", "2"))]
    assert len(set(states)) == 1
    assert states[0][1] > 0
