"""A backend that no tool knows takes part in the accuracy study with what its study.toml says of its looks."""

import json

import pandas as pd
import pytest
from matplotlib.colors import to_hex

import fake_registry
import fake_study
from fake_study import Truth
from musclebench.accuracy import report
from musclebench.figures import looks
from musclebench.program.registry import parse_registry, save_registry
from printed import check_print, keep_figures

pytestmark = pytest.mark.long
SCENE = "lhdl/iliacus"
COLOUR = "#8a2be2"
NEWCOMER = {
    "name": "capsule", "label": "capsule hull", "help": "", "colour": COLOUR, "dash": "dashed", "exact": False,
    "default_response": "project", "capabilities": {},
    "parameters": [{"name": "radius_share", "kind": "number", "unit": "", "default": 1.0, "role": "resolution"}],
    "study": {"series": [{"name": "radii", "sweep": {"radius_share": [0.8, 0.9, 1.0]}, "step_ms": 0.05}]},
}
SHARES = {0.8: 2.0, 0.9: 0.5, 1.0: 0.05}  # its error in mm


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The study's folder, the report, and its figures."""
    folder, kept = tmp_path_factory.mktemp("study"), {}
    for place, (share, p99_mm) in enumerate(SHARES.items()):
        truth = Truth(0.1 * (place + 1), p99_mm, noise=0, shift_mm=p99_mm, parameters={"radius_share": share})
        fake_study.write_replay(folder / "raw" / f"replay-{share}", SCENE, "capsule", truth)
        fake_study.write_coupled(folder / "raw" / f"coupled-{share}", SCENE, "capsule", truth)
    voxels = Truth(0.2, 3.0, noise=0, parameters=fake_study.GRID_64)
    fake_study.write_replay(folder / "raw" / "voxel", SCENE, "voxel", voxels)
    fake_study.write_coupled(folder / "raw" / "bvh", SCENE, "bvh", Truth(0.3))
    known = fake_registry.listed()
    save_registry(parse_registry(json.dumps(known | {"backends": [*known["backends"], NEWCOMER]}), "more"), folder)
    with pytest.MonkeyPatch.context() as patch:
        keep_figures(patch, kept)
        made = report.write_report(folder)
    return folder, made, kept


def test_its_rows_go_by_its_label(told):
    folder, made, _ = told
    prices = made.tables[0].rows.set_index("target_mm")["configuration"]
    assert prices["1"] == "capsule hull 0.9" and prices["0.1"].startswith("capsule hull")
    assert made.tables[0].rows.set_index("target_mm").loc["1", "ratio"] == pytest.approx(1.0)  # of the unit's time
    for table in ("accuracy.csv", "study.csv", "figures/pareto_replay.csv", "figures/pareto_coupled_shape.csv"):
        assert (pd.read_csv(folder / table)["backend"] == "capsule").sum() >= len(SHARES), table


@pytest.mark.parametrize("name", ["pareto_replay", "pareto_coupled", "pareto_coupled_shape"])
def test_its_curve_has_its_colour_and_a_place_in_the_key(told, name):
    figure, paths = told[2][name]
    panel, key = figure.axes
    check_print(figure, paths)
    curve = next(line for line in panel.get_lines() if to_hex(line.get_color()) == COLOUR)
    assert len(curve.get_xdata()) == len(SHARES)
    signs = {text.get_text(): sign for text, sign in zip(key.get_legend().get_texts(), key.get_legend().get_lines())}
    assert to_hex(signs["capsule hull (capsule), radii"].get_color()) == COLOUR
    assert {f"capsule hull, radius share {share:g}" for share in (0.8, 1.0)} <= {text.get_text() for text in panel.texts}


def test_one_that_names_no_colour_gets_one_that_no_other_has():
    known = fake_registry.listed()
    plain = {key: value for key, value in NEWCOMER.items() if key not in ("colour", "dash")}
    looks.know(parse_registry(json.dumps(known | {"backends": [*known["backends"], plain]}), "more"))
    others = {looks.colour(backend["name"]) for backend in known["backends"]}
    assert looks.colour("capsule") not in others and looks.dash("capsule") == "solid"
