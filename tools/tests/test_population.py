"""Members of a population: their shapes, what goes along with them, and what is said of them."""

import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import vtk

import anatomy_shapes
import experiment
import population
from musclebench.anatomy.mesh_file import mend
from musclebench.anatomy.surface import SignedDistance, Surface, as_vtk, from_vtk, merged
from musclebench.lhdl.write_ply import write_ply
from musclebench.population.base_scene import BaseScene, read_base_scene
from musclebench.population.deformation import (
    Deformation, bent, carried, frame_of, jacobian, scaled, stretches, twisted, with_carry,
)
from musclebench.population.members import Family
from musclebench.population.modes import read_modes
from musclebench.population.refitting import joints_of, moved_axis
from musclebench.population.report import Ending, answer, best_setting, interval, members_table, settings_table
from musclebench.population.shape_words import read_shape
from musclebench.population.shapes import drawn_amounts
from musclebench.population.toml_text import toml_text
from musclebench.program.cli import Problem
from program import PROGRAM, call, needs_native_module

PROJECT = Path(__file__).resolve().parents[2]


def ball(radius=0.01, centre=(0, 0, 0), cells=24, stretch=(1, 1, 1)) -> Surface:
    surface = anatomy_shapes.ball(1.0, cells=cells)
    return Surface(surface.vertices * radius * np.array(stretch) + np.array(centre), surface.triangles)


def rod(length=0.4, radius=0.01) -> Surface:
    return ball(1.0, cells=60, stretch=(radius, radius, length / 2))


@pytest.mark.parametrize(("text", "words"), [
    ("scale", "is not like KIND=AMOUNT"), ("scael=5", "there is no kind 'scael'"), ("scale=x", "has to be a number above 0"),
    ("bend=0", "at most 60 degrees"), ("twist=nan", "at most 90 degrees"), ("modes=2", "modes need a folder"),
    ("scale=5:folder", "only modes have a folder"), ("modes=2:folder", "say whose shape"),
])
def test_a_wrong_shape_is_told_in_one_line(text, words):
    with pytest.raises(Problem, match=words) as problem:
        read_shape(text)
    assert "\n" not in str(problem.value)


def test_members_fill_the_range_and_stay_the_same():
    shapes = [read_shape("scale=20"), read_shape("bend=10"), read_shape("modes=2@femur:folder")]
    drawn = [drawn_amounts(shapes, number, seed=3) for number in range(1, 65)]
    factors = np.log([one[0] for one in drawn]) / math.log(1.2)
    assert np.abs(factors).max() <= 1 and np.abs(factors.mean(axis=0)).max() < 0.02
    for axis in range(3):  # each quarter of the range has a quarter of the members
        assert np.histogram(factors[:, axis], bins=4, range=(-1, 1))[0].tolist() == [16] * 4
    bends = np.array([one[1] for one in drawn])
    assert 0 <= bends[:, 0].min() and bends[:, 0].max() <= 10 and bends[:, 1].max() > 300
    modes = np.array([one[2] for one in drawn])
    assert np.abs(modes).max() <= 2 and 0.7 < modes.std() < 1.0  # a normal distribution cut at 2 has 0.88
    assert drawn_amounts(shapes, 17, seed=3) == drawn[16] and drawn_amounts(shapes, 17, seed=4) != drawn[16]


def test_twisting_and_bending_keep_what_they_should():
    bone = rod()
    frame = frame_of([bone])
    assert abs(frame.along[2]) == pytest.approx(1, abs=1e-6) and frame.length == pytest.approx(0.4, rel=1e-6)
    turned = Surface(twisted(30, frame)(bone.vertices), bone.triangles)
    assert np.hypot(*turned.vertices[:, :2].T) == pytest.approx(np.hypot(*bone.vertices[:, :2].T), abs=1e-12)
    apart = twisted(30, frame)(np.array([[0.01, 0, 0.2], [0.01, 0, -0.2]]))
    assert np.degrees(np.arccos(apart[0, :2] @ apart[1, :2] / 1e-4)) == pytest.approx(30)
    # The axis becomes an arc as long as it was, whose ends stand at the angle.
    line = np.column_stack([np.zeros(2001), np.zeros(2001), np.linspace(-0.2, 0.2, 2001)])
    arc = bent(40, 25, frame)(line)
    steps = np.diff(arc, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(0.4, rel=1e-6)
    first, last = steps[0] / np.linalg.norm(steps[0]), steps[-1] / np.linalg.norm(steps[-1])
    assert np.degrees(np.arccos(first @ last)) == pytest.approx(40, abs=0.05)
    assert bent(1e-9, 0, frame)(bone.vertices) == pytest.approx(bone.vertices, abs=1e-12)
    stretched = jacobian(scaled([1.2, 0.9, 1.0], frame), np.array([0.01, 0.02, 0.03]), 0.4)
    assert stretched == pytest.approx(np.diag([1.2, 0.9, 1.0]), abs=1e-8) and stretches(stretched) == pytest.approx((0.9, 1.2))


def test_what_is_carried_along_follows_affine_maps_and_stays_between():
    points = np.random.default_rng(1).uniform(-0.1, 0.1, (300, 3))
    matrix = np.array([[0.1, 0.02, 0], [0, -0.1, 0.03], [0.01, 0, 0.05]])
    move = carried(points, points @ matrix.T + 0.01)
    asked = np.random.default_rng(2).uniform(-0.15, 0.15, (50, 3))
    assert move(asked) == pytest.approx(asked + asked @ matrix.T + 0.01, abs=1e-9)
    # One of two bones grows: a muscle between them keeps to both.
    bones = {"low": ball(0.02, (0, 0, 0)), "high": ball(0.02, (0, 0, 0.1))}
    grown = with_carry(Deformation(own={"low": [lambda points: 1.2 * points]}), bones)
    near_low, near_high = grown.of_space(np.array([[0, 0, 0.0205], [0, 0, 0.0795]]))
    assert near_low[2] == pytest.approx(0.0245, abs=3e-4) and near_high[2] == pytest.approx(0.0795, abs=3e-4)


def above(surface: Surface, height: float) -> Surface:
    """What is cut off there, closed."""
    plane = vtk.vtkPlane()
    plane.SetOrigin(0, 0, height)
    plane.SetNormal(0, 0, 1)
    planes = vtk.vtkPlaneCollection()
    planes.AddItem(plane)
    cut = vtk.vtkClipClosedSurface()
    cut.SetInputData(as_vtk(surface))
    cut.SetClippingPlanes(planes)
    cut.Update()
    return mend(from_vtk(cut.GetOutput()), "socket").surface


def hip(head=0.02, gap=0.001) -> BaseScene:
    """A ball in a socket, which turns about x."""
    socket = ball(head + gap, cells=60)
    wall = merged([ball(head + gap + 0.01, cells=60), Surface(socket.vertices, socket.triangles[:, ::-1])])
    upper = above(wall, -0.002)
    tables = {"bone": [{"name": "pelvis"}, {"name": "femur", "motion": {"axis": [2.0, 0, 0], "centre_m": [0.001, 0, 0]}}]}
    return BaseScene("hip", tables, {"pelvis": upper, "femur": merged([ball(head, cells=60), ball(0.01, (0, 0, -0.1))])}, {})


@needs_native_module
def test_an_axis_is_fitted_anew_where_the_bones_tell_it():
    (joint,) = joints_of(hip())
    assert joint.shape == "sphere" and joint.fitted.radius == pytest.approx(20, abs=0.2) and "refitted by a sphere" in joint.words
    # The head grows about a point that is not its centre, as it does in a leg that is longer.
    frame = frame_of([ball(0.01)], centre=np.array([0, 0, -0.1]))
    axis, centre = moved_axis(joint, Deformation(whole=[scaled([1.1, 1.1, 1.1], frame)]), 0.2)
    assert centre[1:] == pytest.approx([0, 0.01], abs=2e-5) and abs(axis[0]) == pytest.approx(1, abs=1e-6)
    # An articular surface that is no ball any more: its fit is nearer to all of its points than the old centre is.
    flat = Deformation(whole=[scaled([1.0, 1.0, 1.3], frame_of([ball(0.02)]))])
    points = flat.of_bone("femur", joint.points["femur"])
    fitted, kept = moved_axis(joint, flat, 0.2)[1] - [0.001, 0, 0], flat.of_space(joint.centre[None])[0] - [0.001, 0, 0]
    assert np.linalg.norm(points - fitted, axis=1).std() < 0.9 * np.linalg.norm(points - kept, axis=1).std()
    # An axis that no surface explains is carried along.
    far = hip()
    far.tables["bone"][1]["motion"]["centre_m"] = [0, 0.03, 0]
    (joint,) = joints_of(far)
    assert joint.fitted is None and "carried along" in joint.words
    axis, centre = moved_axis(joint, Deformation(whole=[scaled([1.0, 2.0, 1.0], frame)]), 0.2)
    assert centre == pytest.approx([0, 0.06, 0], abs=1e-9) and axis == pytest.approx([1, 0, 0], abs=1e-9)


def write_shapes(folder: Path, lengths, unit=1000.0) -> Path:
    folder.mkdir()
    for number, length in enumerate(lengths):
        mesh = ball(1.0, cells=30, stretch=(0.01, 0.013, length))
        turn = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])  # as another laboratory has its axes
        write_ply(folder / f"bone_{number}.ply", unit * (mesh.vertices @ turn.T + 0.3), mesh.triangles.astype(np.int32), ())
    return folder


def test_modes_are_how_the_meshes_of_a_folder_differ(tmp_path):
    lengths = [0.05, 0.055, 0.06, 0.065, 0.07]
    modes = read_modes(write_shapes(tmp_path / "shapes", lengths), ball(1.0, cells=40, stretch=(0.01, 0.013, 0.06)), "bone")
    assert modes.explained[0] > 0.999 and modes.off < 0.01 and modes.scale == pytest.approx(1e-3, rel=0.02)
    bone = ball(1.0, cells=40, stretch=(0.01, 0.013, 0.06))
    half = {amount: np.ptp(modes.map_of([amount])(bone.vertices), axis=0) / 2 for amount in (-1.0, 0.0, 1.0)}
    spread = np.std(lengths, ddof=1)
    assert half[0.0] == pytest.approx(np.ptp(bone.vertices, axis=0) / 2, rel=1e-12)
    assert sorted([half[-1.0][2], half[1.0][2]]) == pytest.approx([0.06 - spread, 0.06 + spread], abs=4e-4)
    assert half[1.0][:2] == pytest.approx([0.01, 0.013], abs=4e-4)


def test_meshes_that_are_no_shapes_of_one_bone_are_told(tmp_path):
    bone = ball(1.0, stretch=(0.01, 0.013, 0.06))
    with pytest.raises(Problem, match="has 2 meshes; modes need 3 or more"):
        read_modes(write_shapes(tmp_path / "few", [0.05, 0.06]), bone, "bone")
    with pytest.raises(Problem, match="all of its meshes have one shape"):
        read_modes(write_shapes(tmp_path / "same", [0.05] * 3), bone, "bone")
    with pytest.raises(Problem, match="is it the same bone, and all of it"):
        read_modes(write_shapes(tmp_path / "flat", [0.05, 0.06, 0.07]), ball(0.03), "bone")
    z = bone.vertices[:, 2]
    wound = Surface(bone.vertices + np.column_stack([3 * z**2, 60 * z**3, 0 * z]), bone.triangles)
    for side, factor in (("same", 1), ("mirrored", -1)):
        (tmp_path / f"of_the_{side}_side").mkdir()
        for number, length in enumerate((0.97, 1.0, 1.03)):
            points = (wound.vertices * [factor, 1, length] + 1.0) * 1000
            write_ply(tmp_path / f"of_the_{side}_side" / f"{number}.ply", points, wound.triangles[:, ::factor].astype(np.int32), ())
    assert read_modes(tmp_path / "of_the_same_side", wound, "bone").off < 0.005
    with pytest.raises(Problem, match="fits bone better when mirrored"):
        read_modes(tmp_path / "of_the_mirrored_side", wound, "bone")
    other = write_shapes(tmp_path / "other", [0.05, 0.06, 0.07])
    mesh = ball(1.0, cells=31, stretch=(0.01, 0.013, 0.05))
    write_ply(other / "bone_9.ply", mesh.vertices, mesh.triangles.astype(np.int32), ())
    with pytest.raises(Problem, match="bone_9.ply: its triangles differ"):
        read_modes(other, bone, "bone")


def test_tables_are_read_back_as_they_were():
    tables = {"title": 'a "knee"\n', "loop": {"frames": 3, "step": 1e-9, "on": True}, "effects": {"a-b": {}, "x y": {"list": [[1.5, 2], [3, 4]]}},
              "bone": [{"name": "femur", "motion": {"axis": [1, 0, 0]}}, {"name": "tibia", "parameters": {"cells": 8}}]}
    assert tomllib.loads(toml_text(tables)) == tables


@pytest.fixture(scope="module")
def knee(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("knee")
    subprocess.run([sys.executable, PROJECT / "datasets/examples/knee.py", folder], check=True, capture_output=True)
    return next(folder.glob("*.toml"))


@needs_native_module
def test_a_member_is_its_scene_with_another_shape(knee, tmp_path):
    base = read_base_scene(str(knee), Path(PROGRAM), None)
    family = Family(base, [read_shape("scale=20"), read_shape("scale=10@femur")], seed=1)
    same, other = (family.member(number, tmp_path / f"m{number}") for number in (0, 3))
    # Member 0 ends in the same bits as the scene.
    hashes = []
    for scene in (knee, same.scene):
        out = tmp_path / f"run{len(hashes)}"
        done = call("run", scene, "--backend", "bvh", "--frames", "5", "--out", out)
        assert done.returncode == 0, done.stderr
        record = json.loads((out / "run.json").read_text())
        hashes.append(record["state_hash"])
    assert hashes[0] == hashes[1]
    # Another one keeps what is bound, and its muscle keeps as far from the bones.
    done = call("run", other.scene, "--backend", "bvh", "--frames", "5", "--out", tmp_path / "other")
    assert done.returncode == 0, done.stderr
    changed = json.loads((tmp_path / "other" / "run.json").read_text())
    assert changed["state_hash"] != hashes[0]
    bound = {one["name"]: one["nodes"] for one in record["attachments"]}
    for one in changed["attachments"]:
        assert 0.7 * bound[one["name"]] < one["nodes"] < 1.4 * bound[one["name"]]
    made = read_base_scene(str(other.scene), Path(PROGRAM), None)
    for bone in base.bones:
        before = SignedDistance(base.bones[bone])(base.muscles["popliteus"].vertices)
        after = SignedDistance(made.bones[bone])(made.muscles["popliteus"].vertices)
        near = before < 0.003
        assert np.abs(after - before)[near].max() < 0.0012  # 20 % of 3 mm, and what one bone grows for itself
    told = json.loads((other.scene.parent / "member.json").read_text())
    assert told["member"] == 3 and list(told["amounts"]) == ["scale_x", "scale_y", "scale_z", "scale_x@femur", "scale_y@femur", "scale_z@femur"]
    with pytest.raises(Problem, match="the scene has no bone 'fibula'; there are"):
        Family(base, [read_shape("twist=5@fibula")], seed=1)


def with_cord() -> BaseScene:
    """The hip with a cord from bone to bone, which runs through a ring."""
    base = hip()
    base.muscles = {"cord": Surface(rod(0.1, 0.004).vertices + [0.04, 0, -0.03], rod().triangles)}
    base.outlines = [np.array([[0.04, 0.004, 0.02], [0.04, -0.004, 0.02], [0.036, 0, 0.02]])]
    base.tables |= {"muscle": {"name": "cord", "scale": 2.0}, "attachment": [{"name": "origin", "bone": "pelvis", "distance_m": 0.003, "margin_m": 0.001,
                                                                            "outline": "elsewhere.json#cord/origin"}],
                    "retinaculum": [{"name": "ring", "bone": "femur", "centre_m": [0.04, 0, -0.03], "axis": [0, 0, 2.0], "radius_m": 0.006, "slide_m": 0.03}]}
    return base


@needs_native_module
def test_what_a_scene_names_goes_along(tmp_path):
    base = with_cord()
    family = Family(base, [read_shape("scale=50")], seed=2)
    made = tomllib.loads(family.member(1, tmp_path / "m1").scene.read_text())
    factors = np.array(drawn_amounts(family.shapes, 1, 2)[0])
    (ring,), (area,) = made["retinaculum"], made["attachment"]
    assert ring["radius_m"] == pytest.approx(0.006 * factors[:2].max(), rel=1e-6) and ring["slide_m"] == pytest.approx(0.03 * factors[2], rel=1e-6)
    assert ring["axis"] == pytest.approx([0, 0, 1], abs=1e-9)
    centre = family.whole.centre
    assert ring["centre_m"] == pytest.approx((centre + factors * ([0.04, 0, -0.03] - centre)).tolist())
    # The outline lies in a plane of z: distances grow with z, margins in the plane. Its points are in the scene's frame now.
    assert area["distance_m"] == pytest.approx(0.003 * factors[2], rel=1e-6)
    assert area["margin_m"] == pytest.approx(0.001 * np.sqrt(factors[0] * factors[1]), rel=1e-6)
    assert "outline" not in area and np.array(area["outline_m"]) == pytest.approx(centre + factors * (base.outlines[0] - centre))
    assert "scale" not in made["muscle"] and made["muscle"]["mesh"] == "meshes/muscles/cord.ply"
    # Member 0 is the scene as it is, to the last bit.
    same = tomllib.loads(family.member(0, tmp_path / "m0").scene.read_text())
    assert same["retinaculum"] == base.tables["retinaculum"] and same["attachment"][0]["outline_m"] == base.outlines[0].tolist()
    assert same["attachment"][0]["distance_m"] == 0.003 and same["bone"][1]["motion"] == base.tables["bone"][1]["motion"]


@needs_native_module
def test_a_folder_is_of_one_population(tmp_path):
    options = SimpleNamespace(out=tmp_path, shape=[read_shape("size=5")], seed=1, force=False, scene="hip")
    population.claim(options, with_cord())
    Family(with_cord(), options.shape, 1).member(1, tmp_path / "members" / "hip-m0001")
    population.claim(options, with_cord())
    moved = with_cord()
    moved.outlines[0] = moved.outlines[0] + 1e-4
    for change, base, words in (({"seed": 2}, with_cord(), "another seed"), ({"shape": [read_shape("size=6")]}, with_cord(), "other shapes"),
                                ({}, moved, "another scene")):
        with pytest.raises(Problem, match=f"holds a population of {words}"):
            population.claim(SimpleNamespace(**vars(options) | change), base)
    assert (tmp_path / "members" / "hip-m0001").is_dir()
    population.claim(SimpleNamespace(**vars(options) | {"seed": 2, "force": True}), with_cord())
    assert not (tmp_path / "members" / "hip-m0001").exists()


@needs_native_module
def test_a_population_says_which_setting_holds(knee, tmp_path, capsys):
    words = [str(knee), "--shape", "scale=10", "--members", "3", "--setting", "bvh", "--setting", "sdf:cells=8", "--wanted", "surface_mm=0.4",
             "--frames-limit", "6", "--musclebench", PROGRAM, "--any-build", "--out", str(tmp_path / "out"), "--no-pictures", "--hold", "60"]
    code = population.main(words)
    said = capsys.readouterr()
    assert code in (0, 1), said.err
    settings = pd.read_csv(tmp_path / "out" / "settings.csv")
    assert settings["setting"].tolist() == ["bvh", "sdf-cells=8"] and (settings["members"] == 3).all()
    members = pd.read_csv(tmp_path / "out" / "members.csv")
    assert members["member"].tolist() == [0, 1, 2, 3] and members["scale_x"][1:].between(1 / 1.1, 1.1).all()
    broken = pd.read_csv(tmp_path / "out" / "broken.csv")
    assert len(broken) == 6 - settings["hold"].sum() and (settings["hold"] == [(members[name][1:] == "ok").sum() for name in settings["setting"]]).all()
    told = json.loads((tmp_path / "out" / "population.json").read_text())
    assert (told["setting"] is None) == (code == 1) and told["answer"] in said.out
    # What is complete is not run again, and one member can be made alone, to the same bytes.
    before = (tmp_path / "out" / "settings.csv").read_text()
    assert population.main([*words, "--report-only"]) == code and (tmp_path / "out" / "settings.csv").read_text() == before
    mesh = f"members/{knee.stem}-m0002/meshes/bones/femur.ply"
    kept = (tmp_path / "out" / mesh).read_bytes()
    assert population.main([*words[:3], "--members", "30", "--only", "2", "--make-only", "--musclebench", PROGRAM, "--out", str(tmp_path / "alone")]) == 0
    assert (tmp_path / "alone" / mesh).read_bytes() == kept
    capsys.readouterr()
    assert population.main([*words, "--only", "0"]) in (0, 1)
    assert "member 0 with bvh: " in capsys.readouterr().out and (tmp_path / "out" / "settings.csv").read_text() == before
    # Other shapes want another folder, and are told before anything is lost.
    other = [str(knee), "--shape", "bend=20", *words[3:]]
    for more in ([], ["--report-only"], ["--dry-run"]):
        assert population.main([*other, *more]) == 2 and "holds a population of other shapes" in capsys.readouterr().err
    assert (tmp_path / "out" / mesh).read_bytes() == kept
    assert population.main([*other, "--force"]) in (0, 1) and (tmp_path / "out" / mesh).read_bytes() != kept


@needs_native_module
def test_parts_of_a_population_are_joined(knee, tmp_path, capsys):
    words = [str(knee), "--shape", "size=5", "--members", "3", "--setting", "bvh", "--frames-limit", "3", "--musclebench", PROGRAM, "--any-build",
             "--no-pictures"]
    for part in ("1", "2"):
        assert population.main([*words, "--shard", f"{part}/2", "--out", str(tmp_path / f"part{part}")]) == 0
    capsys.readouterr()
    assert population.main([*words, "--report-only", "--out", str(tmp_path / "part1")]) in (0, 1)
    assert "2 runs have no result, and do not count" in capsys.readouterr().out
    assert experiment.main(["population", "--merge", str(tmp_path / "part1"), str(tmp_path / "part2"), "--out", str(tmp_path / "whole")]) == 0
    assert population.main([*words, "--report-only", "--out", str(tmp_path / "whole")]) in (0, 1)
    settings = pd.read_csv(tmp_path / "whole" / "settings.csv")
    assert settings["members"].tolist() == [3] and settings["frame_ms"].notna().all()
    assert "no result" not in capsys.readouterr().out


@needs_native_module
def test_what_is_not_of_this_tool_is_not_removed(knee, tmp_path, capsys):
    (tmp_path / "members" / f"{knee.stem}-m0001").mkdir(parents=True)
    (tmp_path / "members" / f"{knee.stem}-m0001" / "notes.txt").write_text("mine")
    words = [str(knee), "--shape", "size=5", "--members", "1", "--make-only", "--musclebench", PROGRAM, "--out", str(tmp_path)]
    assert population.main(words) == 2 and "has a folder members of something else" in capsys.readouterr().err
    assert (tmp_path / "members" / f"{knee.stem}-m0001" / "notes.txt").read_text() == "mine"


@needs_native_module
@pytest.mark.parametrize(("old", "new", "words"), [
    ('preset = "standard"', 'preset = "standard"\neffects = "auto"', "each member would get effects of its own"),
    ("[muscle]", "[muscle", "knee"),
])
def test_a_scene_that_makes_no_members_is_told(knee, tmp_path, capsys, old, new, words):
    text = knee.read_text()
    assert old in text
    scene = knee.parent / "changed.toml"
    scene.write_text("\n".join(line for line in text.replace(old, new).splitlines() if not line.startswith("[effects") and "compliance_rad" not in line))
    assert population.main([str(scene), "--shape", "size=5", "--musclebench", PROGRAM, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert words in said and said.startswith("population: ")


@needs_native_module
@pytest.mark.parametrize(("change", "words"), [
    (["--setting", "bhv"], "not built"), (["--setting", "sdf:cell=8"], "'cell=8' is not like key=value with a parameter of sdf"),
    (["--setting", "bvh", "--setting", "bvh"], "two are alike"), (["--hold", "101"], "at most 100 percent"),
    (["--only", "9"], "there are members 0 to 3"), (["--only", "-1"], "there are members 0 to 3"),
    (["--setting", "sdf:cells=abc"], "cells"), (["--wanted", "surfce=1"], "surfce"), (["--shape", "size=9"], "size is given twice"),
    (["--members", "0"], "must be 1 or more"),
])
def test_bad_input_is_told_in_one_line(knee, tmp_path, capsys, change, words):
    asked = [str(knee), "--shape", "size=5", "--members", "3", "--frames-limit", "2", "--musclebench", PROGRAM, "--any-build", "--out", str(tmp_path / "out")]
    assert population.main([*asked, *change]) == 2
    line = capsys.readouterr().err.strip().splitlines()[-1]
    assert words in line and line.startswith("population: ")


def test_shares_have_the_published_interval_and_the_fastest_setting_is_named():
    # Brown, Cai and DasGupta 2001 print Wilson's interval of 0 of n as 0 to z2 / (n + z2).
    assert interval(0, 10) == pytest.approx((0, 1.959964**2 / (10 + 1.959964**2))) and interval(0, 0) == (0.0, 1.0)
    low, high = interval(95, 100)
    assert low == pytest.approx(0.8882, abs=1e-4) and high == pytest.approx(0.9785, abs=1e-4)
    ok, bad = Ending("ok", frame_ms=math.nan), Ending("suspect", "1 % pass (frame 28)")
    endings = {"fine": {0: ok} | {i: ok for i in range(1, 21)}, "fast": {0: ok} | {i: bad if i == 7 else ok for i in range(1, 21)},
               "faulty": {0: bad} | {i: bad for i in range(1, 21)}}
    for setting, ms in (("fine", 9.0), ("fast", 3.0), ("faulty", 1.0)):
        for one in (own := endings[setting]):
            own[one] = Ending(own[one].status, own[one].detail, ms, run=object())
    table = settings_table(endings, "scene")
    assert table.rows["hold"].tolist() == [20, 19, 0] and table.rows["scene_itself"].tolist() == ["ok", "ok", "suspect"]
    assert best_setting(table, 95)["setting"] == "fast" and best_setting(table, 96)["setting"] == "fine" and bad.worst_frame == 28
    assert "fast holds for 19 of 20 members" in answer(table, endings, 95) and "No setting holds for 95 % of the members" in answer(
        settings_table({"faulty": endings["faulty"]}, ""), {"faulty": endings["faulty"]}, 95)
    shown = members_table(endings, [read_shape("size=5")], {0: []} | {i: [[1.0 + i / 1000]] for i in range(1, 21)})
    assert shown.rows["size"][7] == pytest.approx(1.007) and shown.rows["fast"].tolist().count("suspect") == 1
