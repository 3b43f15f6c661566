"""`verify` and `probe` as a user meets them."""

import json
import subprocess
from pathlib import Path

import pandas as pd
import pytest

from ball_on_box import ball, off
from program import call, complaint, needs_program

pytestmark = needs_program


def test_verify_holds_and_says_so(folder):
    done = call("verify", folder / "scene.toml", "--points", "2000", "--brute-force-points", "500", "--threads", "2")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    rows = [line.split() for line in lines if line.startswith("box ")]
    assert len([row for row in rows if "cgal" not in row]) == 6  # a build with CGAL has one judge more
    assert {row[1] for row in rows} == {"repaired", "as"}
    assert lines[-1] == "held"


def test_verify_json_has_the_rows_of_the_table(folder):
    arguments = ["verify", folder / "scene.toml", "--points", "2000", "--brute-force-points", "500"]
    done, table = call(*arguments, "--json"), call(*arguments)
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    pairs = [(surface["bone"], str(pair["points"]), str(pair["inside"]), str(pair["sign_differences"]))
             for surface in printed["surfaces"] for pair in surface["pairs"]]
    rows = [line.split() for line in table.stdout.splitlines() if line.startswith("box ")]
    assert pairs == [(row[0], row[-5], row[-4], row[-2]) for row in rows] and len(pairs) >= 6
    assert printed["held"] and all(surface["held"] for surface in printed["surfaces"])


def test_verify_reports_progress_in_lines(folder):
    done = call("verify", folder / "scene.toml", "--points", "60000", "--brute-force-points", "60000", "--progress")
    assert done.returncode == 0
    assert all(line.split()[0] == "progress" for line in done.stderr.splitlines())


@pytest.mark.parametrize("arguments", [["--points", "0"], ["--points", "many"], ["--brute-force-points", "-1"]])
def test_verify_refuses_bad_options(folder, arguments):
    done = call("verify", folder / "scene.toml", *arguments)
    assert done.returncode == 2
    assert arguments[0] in done.stderr


def test_verify_can_do_without_brute_force(folder):
    done = call("verify", folder / "scene.toml", "--points", "100", "--brute-force-points", "0")
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == "held"


def probe(folder: Path, backend: str, *arguments) -> tuple[subprocess.CompletedProcess, dict, pd.DataFrame]:
    done = call("probe", folder / "scene.toml", "--backend", backend, "--points", "3000",
                "--out", folder / "out", *arguments)
    manifest = json.loads((folder / "out/run.json").read_text())
    return done, manifest, pd.read_csv(folder / "out/probe.csv").set_index(["bone", "region"])


def test_the_exact_backends_err_by_rounding(folder):
    for backend in ("bvh", "brute_force"):
        done, manifest, rows = probe(folder, backend, "--force")
        assert done.returncode == 0, done.stderr
        assert manifest["status"] == "ok"
        assert manifest["case"]["mode"] == "probe"
        assert manifest["probed"][0]["cell_edge_m"] is None
        assert manifest["probed"][0]["sharp_edges"] == 12
        assert rows.max_error_m.max() < 1e-15
        assert rows.wrong_side.max() == 0


def test_a_grid_errs_by_order_of_its_cells_and_most_at_edges(folder):
    errors = []
    for cells in (8, 32):
        done, manifest, rows = probe(folder, "sdf", "--param", f"cells={cells}", "--force")
        assert done.returncode == 0, done.stderr
        assert manifest["probed"][0]["cell_edge_m"] == pytest.approx(0.06 / cells, rel=0.01)
        assert manifest["structure_bytes"] > 0 and manifest["build_ns"] > 0
        points = rows.points
        assert points["box", "smooth"] + points["box", "sharp"] == points["box", "all"] == 3000
        assert 0.6 < rows.measured_points["box", "all"] / 3000 < 0.9
        assert rows.mean_error_m["box", "sharp"] > 1.5 * rows.mean_error_m["box", "smooth"]
        largest = rows.max_error_m["box"]
        assert largest["all"] == max(largest["sharp"], largest["smooth"])
        assert rows.mean_error_m["box", "all"] <= rows.rms_error_m["box", "all"] <= rows.max_error_m["box", "all"]
        errors.append(rows.mean_error_m["box", "all"])
    assert errors[1] < errors[0] / 2


def test_contacts_without_depth_err_by_how_far_outside_they_are(folder):
    (folder / "box.off").write_text(off(*ball(0.03, [0, 0, 0], rings=24, around=32)))  # a box fills its own grid
    _, manifest, rows = probe(folder, "voxel", "--param", "cells=20")
    assert manifest["status"] == "ok"
    assert 0 < rows.max_error_m["box", "all"] <= 2e-3  # the band
    assert rows.wrong_side["box", "all"] > 0.01


def test_what_cannot_be_asked_about_points_is_unsupported(folder):
    done = call("probe", folder / "scene.toml", "--backend", "fcl", "--out", str(folder / "out"))
    if "not a backend of this build" in done.stderr:
        pytest.skip("built without FCL")
    assert done.returncode == 3
    assert len(complaint(done).splitlines()) == 1 and "unsupported" in done.stderr
    manifest = json.loads((folder / "out/run.json").read_text())
    assert manifest["status"] == "unsupported"
    assert manifest["structure_bytes"] is None
    assert len((folder / "out/probe.csv").read_text().splitlines()) == 1


def test_a_complete_probe_is_skipped_and_the_same_again(folder):
    _, _, first = probe(folder, "sdf", "--param", "cells=8")
    done, _, _ = probe(folder, "sdf", "--param", "cells=8")
    assert "complete already" in done.stdout
    _, _, again = probe(folder, "sdf", "--param", "cells=8", "--force")
    assert first.equals(again)
    _, _, other = probe(folder, "sdf", "--param", "cells=8", "--seed", "2")
    assert not first.equals(other)


@pytest.mark.parametrize("arguments", [["--points", "0"], ["--band-mm", "-1"], ["--param", "cels=3"]])
def test_a_bad_probe_is_refused(folder, arguments):
    done = call("probe", folder / "scene.toml", "--backend", "sdf", "--out", str(folder / "out"), *arguments)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert not (folder / "out").exists()
