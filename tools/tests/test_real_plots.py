"""Tables and figures of real runs of every backend, from the command line to the file. One module, which a worker of
xdist runs alone."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import paper
from ball_on_box import write_scene_of_balls
from few_cases import program_list, run_few
from musclebench.paper.paper_backends import paper_backends
from musclebench.results.status import MEASURED
from program import PROGRAM, needs_program
from test_paper import CAN_DRAW

pytestmark = [needs_program, pytest.mark.long]
MUSCLE = ("--muscle", "adductor_brevis")
FIGURES = {
    "paper": {"fig_6_adductor_brevis", "fig_7_collision_time", "fig_8_memory", "depth_by_frame",
              "muscles_at_full_flexion", "attachments"},
    "accuracy": {"overview", "pareto_replay", "pareto_coupled", "pareto_coupled_shape", "offset_and_depth", "convergence", "convergence_cost",
                 "stages"},
}
AS_WRITTEN = {"backend": str, "configuration": str}  # `null` is a name
FEWEST_COLOURS = 100  # of lines and letters with smooth edges; a blank page has one


@dataclass
class Done:
    """A command that ended."""

    code: int
    text: str
    errors: str
    out: Path

    @property
    def files(self) -> list[Path]:
        """That the command names below `Written:`."""
        return [Path(line.strip()) for line in self.text.partition("Written:\n")[2].splitlines()
                if line.startswith("  ")]


@pytest.fixture(scope="module")
def both(tmp_path_factory) -> dict[str, Done]:
    """The paper's experiment, and the accuracy study of a scene whose meshes are read, at the same time."""
    folder = tmp_path_factory.mktemp("real")
    command = [sys.executable, paper.__file__, "--musclebench", PROGRAM, "--out", folder / "paper", *MUSCLE]
    with subprocess.Popen([*command, "--frames-limit", "10", "--jobs", "1"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as process:
        study = run_few(folder / "accuracy", "--scene", str(write_scene_of_balls(folder)), "--quick", "--frames-limit", "10",
                        "--jobs", "1")
        text, errors = process.communicate(timeout=240)
    return {"paper": Done(process.returncode, text, errors, folder / "paper"),
            "accuracy": Done(study.returncode, study.stdout, study.stderr, folder / "accuracy")}


@pytest.mark.parametrize("name", ["paper", "accuracy"])
def test_what_the_command_names_is_there(both, name):
    done = both[name]
    if name == "paper" and not CAN_DRAW:
        pytest.skip("no display and no Xvfb: surface figures can't be drawn")
    assert done.code == 0, done.errors
    figures = {path.stem for path in done.files if path.suffix == ".png"}
    of_libraries = {stem for stem in figures if stem.startswith("library_")}
    assert figures - of_libraries == FIGURES[name]
    if name == "accuracy":
        assert of_libraries >= {f"library_{one['name']}" for one in program_list()["backends"] if (one["study"] or {}).get("external")}
    assert {path.suffix for path in done.files} >= {".csv", ".md", ".tex", ".png", ".svg", ".pdf"}
    for path in done.files:
        assert path.stat().st_size > 0 and done.out in path.parents, path


@pytest.mark.parametrize("name", ["paper", "accuracy"])
def test_pictures_are_whole_and_show_something(both, name):
    for path in both[name].files:
        if path.suffix != ".png":
            continue
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert("RGB"))
        colours = np.unique(pixels.astype(np.uint32) @ [1 << 16, 1 << 8, 1])
        assert pixels.shape[1] > 1000 and len(colours) > FEWEST_COLOURS, path.name
        assert (pixels[:, [0, -1]] == 255).all(), f"{path.name}: something leaves the page"


def test_every_backend_has_answered_and_stands_in_a_table(both):
    listed = program_list()
    rows = pd.read_csv(both["accuracy"].out / "accuracy.csv", converters=AS_WRITTEN)
    assert set(rows["status"]) <= MEASURED
    assert set(rows["backend"]) == {one["name"] for one in listed["backends"]}
    replayed = set(rows[rows["mode"] == "replay"]["backend"])
    assert replayed == {one["name"] for one in listed["backends"] if not (one["study"] or {}).get("control")}
    runs = pd.read_csv(both["paper"].out / "runs.csv", converters=AS_WRITTEN)
    papers = [one for one in paper_backends() if one in {entry["name"] for entry in listed["backends"]}]
    assert set(runs["configuration"]) == {*papers, "fcl as advised", "bvh", "bvh, start off by rounding"}
    assert (runs["frames"] == 10).all()
    assert set(runs["status"]) <= MEASURED
    for backend in (*papers, "fcl as advised", "bvh"):
        assert f"\n  {backend} " in both["paper"].text
