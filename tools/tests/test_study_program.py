"""The accuracy study with the real program: it takes every command line of the plan, and its answers are understood."""

import json
from pathlib import Path

import pytest

import accuracy
import fake_registry
from musclebench.accuracy.configurations import configuration
from musclebench.cases.case import Folders
from musclebench.program.registry import parse_registry, read_registry
from musclebench.experiments.expansion import Expansion
from musclebench.experiments.experiment_file import of_project
from musclebench.figures import style
from musclebench.page.sections import sections_of
from musclebench.results.status import MEASURED
from fake_sweep import FakeScenes
from program import PROGRAM, call, needs_program

pytestmark = needs_program
FEW = {
    "sdf": {"series": [{"sweep": {"cells": [8]}, "stores": True, "probed": True}]},
    "bvh": {"series": [{}]},
}


def registry():
    return read_registry(Path(PROGRAM))


def test_the_program_takes_every_configuration(tmp_path):
    """Parameters are checked before the recording is looked for."""
    scenes = FakeScenes((fake_registry.scene("synthetic/iliacus"),))
    cases = Expansion(of_project("accuracy"), registry(), scenes).firsts()
    for case in [case for case in cases if case.group.mode == "replay"]:
        done = call(*case.arguments(Folders(tmp_path)))
        assert done.returncode == 2 and done.stderr.startswith(f"musclebench: {tmp_path / case.recording.file}:"), (
            f"{case.name}: {done.stderr}")


@pytest.mark.parametrize("backend", fake_registry.registry().names)
def test_what_the_program_does_by_default_needs_no_words_in_a_figure(folder, backend):
    done = call("run", folder / "scene.toml", "--backend", backend, "--no-referee", "--out", folder / "out")
    if "is not a backend of this build" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr
    case = json.loads((folder / "out" / "run.json").read_text())["case"]
    assert configuration(registry().backend(backend), case["parameters"]).is_default


def require_its_page(study: Path) -> None:
    """tools/report shows the charts and price lists that tools/accuracy wrote."""
    (section,) = sections_of([study])
    parts = {part.name for part in section.parts}
    assert section.name == "accuracy"
    assert {"pareto_replay", "pareto_coupled", "pareto_moment_arm", "price_list", "arm_price_list", "coupled_outcomes"} <= parts
    chart = next(part for part in section.parts if part.name == "pareto_replay")
    assert set(chart.rows["backend"]) == set(FEW) and set(section.backends) == set(FEW)
    what = dict(section.what)
    assert what["Runs"].startswith("16: ") and what["Scenes"] == "synthetic/adductor_brevis" and what["Begun"].startswith("20")


@pytest.mark.long
def test_a_small_study_comes_out_complete(tmp_path, monkeypatch, capfd):
    few = parse_registry(fake_registry.with_studies(FEW), "few")
    monkeypatch.setattr(accuracy, "read_registry", lambda program: few)
    monkeypatch.setattr(style, "FORMATS", [".svg"])
    arguments = ["--musclebench", PROGRAM, "--out", str(tmp_path / "out"), "--muscle", "adductor_brevis",
                 "--frames-limit", "4", "--repetitions", "2"]
    assert accuracy.main(arguments) == 0, capfd.readouterr().err
    require_its_page(tmp_path / "out")
    runs = {path.parent.name: json.loads(path.read_text()) for path in (tmp_path / "out" / "raw").glob("*/run.json")}
    assert {run["status"] for run in runs.values()} <= MEASURED and len(runs) == 16
    assert {run["case"]["mode"] for run in runs.values()} == {"replay", "coupled", "probe"}
    exact, floor = runs["adductor_brevis-coupled-bvh-r0"], runs["adductor_brevis-floor-bvh-r0"]
    assert floor["case"]["loop"]["start_noise_m"] == 1e-12 and exact["case"]["loop"]["start_noise_m"] == 0
    assert floor["state_hash"] != exact["state_hash"]
    arms = runs["adductor_brevis-arms-bvh-r0"]
    assert arms["case"]["preset"] == "standard" and arms["fibres"][0]["followed"] == 100
    sdf = "sdf-cells=8"
    assert runs[f"adductor_brevis-probe-{sdf}-r0"]["structures"] == "built"
    assert runs[f"adductor_brevis-replay-{sdf}-r0"]["structures"] == "loaded"
    assert runs["adductor_brevis-replay-bvh-r0"]["accuracy"]["missed_contacts"] == 0
    hashes = {runs[f"adductor_brevis-replay-{sdf}-r{r}"]["contact_hash"] for r in (0, 1)}
    assert len(hashes) == 1 and None not in hashes
    files = {Path(shot["file"]).name for shot in runs["adductor_brevis-coupled-bvh-r0"]["snapshots"]}
    assert files == {f"frame_{frame:04d}.ply" for frame in (0, 2, 4)}
