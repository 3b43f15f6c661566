"""Each scene effects/NAME shows one effect, and what its run leaves is what theory says of that effect."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from musclebench.cases.project_scenes import project_scenes
from musclebench.results.ply import PlyMesh, read_ply
from program import call, needs_program
from spring_model import displacement_m, stiffness_matrix

pytestmark = needs_program
SCENES = {name.removeprefix("effects/"): path for name, path in project_scenes().items() if name.startswith("effects/")}
NAMES = sorted(SCENES)
G = 9.80665
NOT_EFFECTS = {"contact", "fibre_anisotropy", "muscle_contact"}  # of the backend, of edge_length, of [contact]


@dataclass
class Result:
    record: dict
    frames: pd.DataFrame
    shapes: dict[int, PlyMesh]  # by frame
    poses: dict[int, list]  # by frame: (rotation, translation) a bone
    forces: pd.DataFrame | None  # where they were told

    @property
    def rest_m(self) -> np.ndarray:
        return self.shapes[0].vertices_m

    @property
    def outcome(self) -> dict:
        return self.record["outcome"]

    def moved_m(self, frame: int) -> np.ndarray:
        return self.shapes[frame].vertices_m - self.rest_m

    def time_s(self, frame: int) -> float:
        loop = self.record["case"]["loop"]
        return frame * loop["substeps"] * loop["time_step_s"]


@pytest.fixture
def run(tmp_path):
    """A scene by its name, or a file; frame 0 is kept beside those that are asked for."""
    def of(scene, *options, frames=()) -> Result:
        name = scene if str(scene).endswith(".toml") else f"effects/{scene}"
        out = tmp_path / f"{Path(name).stem}{len(list(tmp_path.glob('*')))}"
        kept = ",".join(map(str, (0, *frames)))
        done = call("run", name, "--backend", "bvh", "--snapshots", kept, "--out", out, *options)
        assert done.returncode == 0, done.stderr
        record = json.loads((out / "run.json").read_text())
        stored = {shot["frame"]: shot for shot in record["snapshots"]}
        poses = {frame: [(np.reshape(pose["rotation"], (3, 3)), np.array(pose["translation_m"]))
                         for pose in shot["bone_poses"]] for frame, shot in stored.items()}
        return Result(record, pd.read_csv(out / "frames.csv"),
                      {frame: read_ply(out / shot["file"]) for frame, shot in stored.items()}, poses,
                      pd.read_csv(out / "forces.csv") if (out / "forces.csv").is_file() else None)

    return of


def test_every_effect_has_a_scene_that_shows_it():
    listed = json.loads(call("list", "--json").stdout)
    effects = {effect["name"] for effect in listed["effects"]}
    assert effects | NOT_EFFECTS == set(NAMES)
    assert {f"effects/{name}" for name in NAMES} <= {scene["name"] for scene in listed["scenes"]}
    for name in effects & set(NAMES):
        assert re.search(rf"^\[effects\.{name}\]$", SCENES[name].read_text(), re.MULTILINE), name


# The rod pokes between nodes, which effects/local_volume
# is not about.
BEYOND = {
    "local_volume": r"a vertex of the rod is [\d.]+ mm deep in the muscle at 1 degrees .* add surface_contact",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_ends_within_all_limits(run, name):
    found = run(name, "--self-intersections")
    reason = found.record["status_detail"]
    assert re.fullmatch(BEYOND.get(name, ""), reason), reason
    assert len(found.frames) == found.record["case"]["loop"]["frames"]


def test_gravity_is_a_parabola(run):
    found = run("gravity", frames=(10, 20))
    for frame in (10, 20):
        time_s = found.time_s(frame)
        fallen_m = found.moved_m(frame)
        # A step adds its whole gain of speed at its beginning.
        exact_m = 0.5 * G * time_s * (time_s + found.record["case"]["loop"]["time_step_s"])
        assert np.abs(fallen_m - [0, 0, -exact_m]).max() < 1e-12
        assert exact_m == pytest.approx(0.5 * G * time_s**2, rel=0.025)


def test_damping_decays_the_same_whatever_the_step(run):
    """Speed towards g / rate as 1 - exp(-rate t)."""
    for steps in (["substeps=50", "time_step_s=1e-4"], ["substeps=200", "time_step_s=2.5e-5"]):
        found = run("damping", *(word for step in steps for word in ("--loop", step)), frames=(10, 20))
        rate = found.record["case"]["effects"]["damping"]["rate_per_s"]
        for frame in (10, 20):
            time_s = found.time_s(frame)
            wanted_m = G / rate * (time_s - (1 - np.exp(-rate * time_s)) / rate)
            assert -found.moved_m(frame)[:, 2].mean() == pytest.approx(wanted_m, rel=0.01)


def turning_points(values: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Times of the lowest points, each by a parabola through three samples."""
    found = [i for i in range(1, len(values) - 1) if values[i] <= values[i - 1] and values[i] < values[i + 1]]
    return np.array([time_s[i] + 0.5 * (time_s[1] - time_s[0]) * (values[i - 1] - values[i + 1])
                     / (values[i - 1] - 2 * values[i] + values[i + 1]) for i in found])


def swing(found: Result, node: int) -> tuple[float, float]:
    """Period and deepest displacement of a node."""
    frames = sorted(found.shapes)
    heights = np.array([found.moved_m(frame)[node, 2] for frame in frames])
    lowest = turning_points(heights, np.array([found.time_s(frame) for frame in frames]))
    assert len(lowest) > 1
    return float(np.diff(lowest).mean()), float(heights.min())


def test_an_edge_swings_with_the_period_of_its_spring(run):
    found = run("edge_length", frames=range(1, 101))
    apex = int(np.argmax(found.rest_m[:, 2]))
    stiffness, mass_kg = 3 / 1e-3 * 2 / 3, 0.1
    period_s, deepest_m = swing(found, apex)
    assert period_s == pytest.approx(2 * np.pi * np.sqrt(mass_kg / stiffness), rel=0.02)
    assert deepest_m == pytest.approx(-2 * mass_kg * G / stiffness, rel=0.03)


def test_a_hinge_swings_with_the_period_of_its_angle(run):
    found = run("bending", frames=range(1, 101))
    tip = int(np.argmax(found.rest_m[:, 0]))
    lever_m, mass_kg, compliance = 0.03, 0.1, 2.0
    period_s, deepest_m = swing(found, tip)
    assert period_s == pytest.approx(2 * np.pi * np.sqrt(mass_kg * lever_m**2 * compliance), rel=0.01)
    assert deepest_m == pytest.approx(-2 * compliance * mass_kg * G * lever_m * lever_m, rel=0.02)
    assert np.linalg.norm(found.shapes[50].vertices_m[tip]) == pytest.approx(lever_m, rel=1e-4)


@pytest.mark.parametrize("pull", [(0.2, 0.0), (0.0, 0.2)], ids=["along", "across"])
@pytest.mark.parametrize("exponent", [0.0, 0.5])
def test_fibres_soften_the_edges_along_them(run, pull, exponent):
    """Against linear springs solved in their natural modes."""
    gravity = f"gravity:x_m_per_s2={pull[0]},y_m_per_s2={pull[1]}"
    found = run("fibre_anisotropy", "--effect", gravity, "--effect", f"edge_length:anisotropy_exponent={exponent}",
                frames=(10, 20))
    muscle, free = found.record["muscle"], np.abs(found.rest_m[:, 0]) < 0.0499
    assert free.sum() == muscle["free_nodes"]
    stiffness = stiffness_matrix(found.rest_m, found.shapes[0].triangles, np.array([1.0, 0, 0]), exponent, 0.05)
    mass_kg = 1060 * muscle["rest_volume_m3"] / muscle["nodes"]
    for frame in (10, 20):
        wanted_m = displacement_m(stiffness, free, np.array([*pull, 0]), mass_kg, 60, found.time_s(frame))
        assert found.moved_m(frame)[free].mean(axis=0) == pytest.approx(wanted_m, rel=0.015, abs=2e-8)


def test_a_volume_grows_a_ball_evenly(run):
    found = run("volume", frames=(20,))
    assert found.frames.volume_m3.iloc[-1] == pytest.approx(1.2 * found.record["muscle"]["rest_volume_m3"], rel=1e-9)
    centre = found.rest_m.mean(axis=0)
    growth = np.linalg.norm(found.shapes[20].vertices_m - centre, axis=1) / np.linalg.norm(found.rest_m - centre, axis=1)
    # A node moves by the area about it, and twelve of the ball have five neighbours instead of six.
    assert growth.mean() == pytest.approx(1.2 ** (1 / 3), rel=2e-3) and growth == pytest.approx(growth.mean(), rel=0.02)


def width_change(found: Result, from_m: float, to_m: float) -> float:
    """Of the tube across its axis, over the nodes in that part."""
    part = (found.rest_m[:, 0] > from_m) & (found.rest_m[:, 0] < to_m)
    across = [np.linalg.norm(shape[part][:, 1:] - [0, 0.01], axis=1).mean()
              for shape in (found.rest_m, found.shapes[60].vertices_m)]
    return across[1] / across[0] - 1


def test_a_squeezed_end_does_not_inflate_the_other(run):
    regional = run("local_volume", frames=(60,))
    whole = run("local_volume", "--no-effect", "local_volume", "--effect", "volume", frames=(60,))
    for found in (regional, whole):
        assert found.outcome["max_volume_error"] < 1e-3
    assert abs(width_change(regional, 0.0, 0.05)) < 0.002
    assert width_change(whole, 0.0, 0.05) > 0.01


def test_bound_nodes_move_rigidly_to_the_bit(run):
    found = run("attachment", frames=(15, 30))
    bound = found.shapes[0].extra["attached"] == 1
    assert bound.sum() == found.record["bound_nodes"] > 100
    for frame in (15, 30):
        rotation, translation_m = found.poses[frame][0]
        x_m, y_m, z_m = found.rest_m[bound].T[:, :, None]
        # Products summed in this order: `@` may fuse and reorder them.
        wanted_m = x_m * rotation[:, 0] + y_m * rotation[:, 1] + z_m * rotation[:, 2] + translation_m
        assert (found.shapes[frame].vertices_m[bound] == wanted_m).all()
    assert found.record["bones"][0]["motion"]["angles_rad"][1] == pytest.approx(np.pi / 3)


def test_contact_holds_a_ball_on_a_plate(run):
    found = run("contact", frames=(60,))
    assert found.outcome["max_depth_m"] < 1e-15 and found.frames.missed_contacts.sum() == 0
    assert found.frames.contacts.iloc[-1] > 10
    assert found.shapes[60].vertices_m[:, 2].min() == pytest.approx(0, abs=1e-15)


def test_a_folded_sheet_does_not_fall_through_itself(run):
    found, through = run("self_contact", frames=(60,)), run("self_contact", "--no-effect", "self_contact", frames=(60,))
    upper = found.rest_m[:, 2] > 0.007
    assert upper.sum() == 70
    assert found.shapes[60].vertices_m[upper, 2].min() > 0.95 * 0.001
    assert through.shapes[60].vertices_m[upper, 2].min() < 1e-6


def test_faces_stay_out_of_a_ridge(run):
    bar_m = 1e-4
    with_faces, nodes_only = run("surface_contact"), run("surface_contact", "--no-effect", "surface_contact")
    assert with_faces.outcome["max_surface_depth_m"] < bar_m
    assert nodes_only.outcome["max_surface_depth_m"] > 10 * bar_m


def test_a_margin_keeps_its_distance(run):
    found = run("margin", frames=(60,))
    assert found.shapes[60].vertices_m[:, 2].min() == pytest.approx(0.003, abs=1e-12)
    assert run("margin", "--no-effect", "margin", frames=(60,)).shapes[60].vertices_m[:, 2].min() < 1e-9


def test_a_ball_rests_in_the_groove_of_two_bones_in_any_order(run, tmp_path):
    found = run("multi_bone", frames=(60,))
    assert found.outcome["max_depth_m"] < 1e-9
    lowest_m = found.shapes[60].vertices_m[:, 2].min()
    assert 0 < lowest_m < 0.01  # touches both sides above the bottom
    text = SCENES["multi_bone"].read_text()
    swapped = tmp_path / "swapped.toml"
    swapped.write_text(text.replace("groove_left", "x").replace("groove_right", "groove_left")
                       .replace("x", "groove_right", 2))
    other = run(swapped)
    assert [bone["name"] for bone in other.record["bones"]] == ["groove_right", "groove_left"]
    assert other.record["state_hash"] == found.record["state_hash"]


def test_the_guard_stops_a_fast_plate(run):
    held, through = run("tunnelling_guard"), run("tunnelling_guard", "--no-effect", "tunnelling_guard")
    nodes = held.record["muscle"]["nodes"]
    assert held.outcome["tunnelled_nodes"] == 0
    assert through.outcome["tunnelled_nodes"] == nodes


def test_bars_that_meet_edge_on_edge_do_not_pass(run):
    """They meet with opposite momenta, and what keeps them apart gives neither of them any."""
    held, through = run("no_passage", frames=(20, 24)), run("no_passage", "--no-effect", "no_passage")
    assert through.outcome["muscle_crossing_triangles"] > 20
    assert held.record["status"] == "ok"
    assert held.outcome["muscle_crossing_triangles"] == 0 and held.outcome["self_intersecting_triangles"] == 0
    moved_m = held.moved_m(24)
    lower = held.rest_m[:, 2] < 0
    assert held.rest_m[lower, 2].max() < held.rest_m[~lower, 2].min()
    size_m = np.abs(moved_m).max()
    assert np.abs(moved_m.mean(axis=0)).max() < 1e-9 * size_m
    assert held.shapes[24].vertices_m[lower, 2].mean() < held.shapes[24].vertices_m[~lower, 2].mean()


@pytest.mark.parametrize("coefficient", [0.7, 0.74, 0.76, 0.9])
def test_a_block_slides_beyond_the_angle_of_friction_and_not_before(run, coefficient):
    """The slope falls by 3 in 4: its tangent is 0.75."""
    found = run("friction", "--effect", f"friction:coefficient={coefficient}", frames=(20, 40, 60))
    down = np.array([0.8, 0, -0.6])
    slid_m = [found.moved_m(frame).mean(axis=0) @ down for frame in (20, 40, 60)]
    interval_s = found.time_s(20)
    if coefficient > 0.75:
        assert slid_m[2] - slid_m[1] < 1e-6  # at rest once the block has settled
    else:
        acceleration = (slid_m[2] - 2 * slid_m[1] + slid_m[0]) / interval_s**2
        assert acceleration == pytest.approx(G * (0.6 - coefficient * 0.8), rel=0.01)


def test_fibres_that_shorten_make_the_muscle_bulge(run):
    """Brought nearer by a fifth of its length, which the fibres take up: thicker by 1 / sqrt(0.8) at the same volume."""
    found = run("activation", frames=(60,))
    assert found.outcome["max_volume_error"] < 0.01
    assert width_of_belly(found) == pytest.approx(1 / np.sqrt(0.8), rel=0.03)


@pytest.mark.long
def test_fibres_that_pull_keep_a_muscle_straight_while_its_ends_come_closer(run):
    """Brought nearer by a fifth of its length: without them its axis folds up."""
    taut = run("fibre_force", "--forces", frames=(60,))
    slack = run("fibre_force", "--no-effect", "fibre_force", frames=(60,))
    assert taut.record["status"] == "ok" and taut.outcome["max_volume_error"] < 0.05
    assert farthest_off_axis_m(taut) < 5e-4 and farthest_off_axis_m(slack) > 0.01
    # Hill's curves: at rest in the last frames, and half as active with half the level.
    half = run("fibre_force", "--forces", "--effect", "fibre_force:level=0.025", frames=(60,))
    forces_n = [last_fibre_force_n(result) for result in (half, taut)]
    assert forces_n[1] == pytest.approx(2 * forces_n[0], rel=0.02)


def farthest_off_axis_m(found: Result) -> float:
    """Of the middles of slices of the tube."""
    slices = np.round(found.rest_m[:, 0] / 0.005)
    middles = np.array([found.shapes[60].vertices_m[slices == each].mean(axis=0) for each in np.unique(slices)])
    return np.linalg.norm(middles[:, 1:] - [0, 0.01], axis=1).max()


def last_fibre_force_n(found: Result) -> float:
    attached = found.forces[found.forces.source == "attachment"]
    return attached.fibres_n.iloc[-1]


def test_a_ring_holds_a_tendon_which_slides_through_it(run):
    """The tendon bends at the ring and pulls alike on both sides of it: the ring bears that on the line that halves the bend."""
    held = run("retinaculum", "--forces", "--loop", "frames=120", "--loop", "rest_frames=70", frames=(120,))
    free = run("retinaculum", "--no-effect", "retinaculum", frames=(60,))
    assert held.record["status"] == "ok" and held.outcome["max_ring_escape_m"] < 1e-3
    assert free.record["status"] == "suspect" and free.outcome["max_ring_escape_m"] > 0.01
    assert "add retinaculum" in free.record["status_detail"]
    last = held.forces[held.forces.frame == 120].set_index("other")
    forces_n = last[["force_x_n", "force_y_n", "force_z_n"]]
    strap, ends = forces_n.loc["strap"].to_numpy(), forces_n.loc[["origin", "insertion"]].to_numpy()
    pull_n = np.linalg.norm(ends, axis=1)
    assert strap[2] < -0.1 * pull_n.mean()
    assert np.linalg.norm(strap + ends.sum(axis=0)) < 1e-3 * pull_n.mean()  # at rest nothing is left over


def width_of_belly(found: Result) -> float:
    middle = np.abs(found.rest_m[:, 0]) < 0.03
    axis_m = found.shapes[60].vertices_m[middle][:, 1:].mean(axis=0)
    radius_m = np.linalg.norm(found.shapes[60].vertices_m[middle][:, 1:] - axis_m, axis=1).mean()
    return radius_m / 0.01


def test_muscles_rest_on_each_other(run):
    found = run("muscle_contact", frames=(60,))
    apart = run("muscle_contact", "--effect", "gravity:z_m_per_s2=0", frames=(60,))
    assert found.outcome["max_muscle_depth_m"] < 1e-4
    assert found.frames.muscle_contacts.iloc[-20:].min() > 0 == apart.frames.muscle_contacts.max()
    half = len(found.rest_m) // 2
    heights = found.shapes[60].vertices_m[:, 2]
    assert heights[half:].mean() - heights[:half].mean() > 0.035  # balls of 40 mm
