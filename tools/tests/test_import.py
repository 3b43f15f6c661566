"""From a folder of meshes to scenes: what is found, what is refused, and that the scenes run."""

import importlib
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from anatomy_shapes import ball, spindle, write
from musclebench.anatomy import attaching, units
from musclebench.anatomy.anatomy_map import JointWords, read_map
from musclebench.anatomy.attaching import Area, areas_near_bones, distances_to, moved_out
from musclebench.anatomy.found_files import find_files
from musclebench.anatomy.joint_axis import Axis, articulating_points, fit_cylinder, fit_sphere
from musclebench.anatomy.joints import made_joint, turned
from musclebench.anatomy.mesh_file import mend, read_mesh
from musclebench.anatomy.opensim import opensim_axis
from musclebench.anatomy.scene_files import MusclePart, reach_m, scene_text
from musclebench.anatomy.surface import Surface, merged
from musclebench.program.cli import Problem
from musclebench.program.whole_folder import whole_folder
from program import PROGRAM, needs_native_module

pytestmark = needs_native_module
PROJECT = Path(__file__).resolve().parents[2]
MAP = """
title = "A knee"
licence = "CC BY 4.0"
cite = ["Nobody (2026)"]
near_mm = 2.0
[files]
bone = 'Right_Bone_(?P<name>[A-Za-z]+)'
muscle = 'Right_Muscle_(?P<name>[A-Za-z]+)'
[[joint]]
name = "knee"
moves = ["femur"]
axis = [-1, 0, 0]
centre = [0, 0, 0]
from_deg = 0
to_deg = 40
"""

import_tool = importlib.import_module("import")


@pytest.fixture(scope="module")
def knee(tmp_path_factory) -> Path:
    """The knee of the README as a stranger has it: STL in millimetres, each vertex several times, one mesh inside out."""
    made, folder = tmp_path_factory.mktemp("made"), tmp_path_factory.mktemp("knee")
    subprocess.run([sys.executable, PROJECT / "datasets/examples/knee.py", made], check=True, capture_output=True)
    for file, name in (("tibia.ply", "Bone_Tibia"), ("femur.obj", "Bone_Femur"), ("popliteus.stl", "Muscle_Popliteus")):
        surface = read_mesh(made / file)
        write(Surface(surface.vertices * 1000, surface.triangles[:, ::-1] if "femur" in file else surface.triangles), folder / f"VHF_Right_{name}_smooth.stl")
    (folder / "map.toml").write_text(MAP)
    return folder


def run(folder: Path, out: Path, *words: str, text: str = "") -> int:
    if text:
        (out.parent / "map.toml").write_text(text)
    chosen = str(out.parent / "map.toml" if text else folder / "map.toml")
    return import_tool.main([str(folder), "--map", chosen, "--out", str(out), "--no-pictures", "--musclebench", PROGRAM, *words])


def test_a_knee_becomes_a_scene_that_runs(knee, tmp_path, capsys):
    assert run(knee, tmp_path / "out") == 0
    told = capsys.readouterr()
    assert "2 bones, 0 cartilages, 1 muscle, unit mm; 1 scene, such as" in told.out and "Licence: CC BY 4.0." in told.out
    assert all(line.startswith("import: ") for line in told.err.splitlines())
    about = json.loads((tmp_path / "out" / "import.json").read_text())
    assert {one["name"]: one["repairs"] for one in about["meshes"]}["femur"] == ["turned inside out, and turned back"]
    assert all(one["error_mm"] <= 0.1 and one["triangles"] < one["triangles_in_file"] for one in about["meshes"])
    areas = {(one["bone"], one["role"]) for one in about["attachments"]}
    assert areas == {("tibia", "insertion"), ("femur", "origin")} or areas == {("tibia", "origin"), ("femur", "insertion")}
    scene = tmp_path / "out" / "scenes" / "knee" / "popliteus.toml"
    if program := os.environ.get("MUSCLEBENCH_BINARY"):
        done = subprocess.run([program, "run", scene, "--backend", "bvh", "--frames", "10", "--out", tmp_path / "run"], capture_output=True, text=True,
                              timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        result = json.loads((tmp_path / "run" / "run.json").read_text())
        assert result["source"]["licence"] == "CC BY 4.0" and "CC BY 4.0" in done.stdout
        told = {f"{one['role']}_{one['bone']}": one["nodes"] for one in about["attachments"]}
        assert {name: int(re.search(rf"attachment {name} +(\d+) nodes", done.stdout)[1]) for name in told} == told


def test_an_import_replaces_nothing_else(knee, tmp_path, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    assert run(knee, tmp_path / "mine", "--force") == 2 and "notes.txt is none of its files" in capsys.readouterr().err
    assert run(knee, tmp_path / "out") == 0 and run(knee, tmp_path / "out") == 2 and "--force" in capsys.readouterr().err
    assert run(knee, tmp_path / "out", "--force") == 0
    (tmp_path / "out" / "runs").mkdir()
    (tmp_path / "out" / "runs" / "run.json").write_text("{}")
    assert run(knee, tmp_path / "out", "--force") == 2 and "runs/run.json is none of its files" in capsys.readouterr().err
    assert run(tmp_path / "out" / "meshes", tmp_path / "out", "--force", text=MAP) == 2 and "FOLDER lies in it" in capsys.readouterr().err
    assert (tmp_path / "out" / "meshes" / "femur.ply").is_file() and (tmp_path / "mine" / "notes.txt").is_file()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.toml", "mine", "out"]


def test_what_cannot_be_used_is_listed_and_the_rest_goes_on(knee, tmp_path, capsys):
    folder = tmp_path / "folder"
    folder.mkdir()
    for path in knee.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    tibia = read_mesh(folder / "VHF_Right_Bone_Tibia_smooth.stl")
    half = tibia.corners.mean(axis=1)[:, 0] > 0
    write(Surface(tibia.vertices, tibia.triangles[half]), folder / "Right_Bone_Half.stl")
    write(ball(5, (300, 0, 0)), folder / "Right_Muscle_Adrift.stl")
    write(ball(5, (0, 0, -80)), folder / "Right_Muscle_Swallowed.stl")
    for name in ("Right_Muscle_Twice.stl", "VHF_Right_Muscle_Twice_smooth.stl"):
        write(ball(5, (0, 0, -80)), folder / name)
    (folder / "Right_Bone_Empty.stl").write_text("solid nothing\nendsolid\n")
    assert run(folder, tmp_path / "out") == import_tool.CODE_PARTLY
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("not imported, or not as told: ")]
    for name, words in (("Half", "is open"), ("Adrift", "touches no bone within 2 mm: none is within reach"), ("Swallowed", "of its nodes are inside tibia"),
                        ("Muscle_Twice.stl", "'twice' is VHF_Right_Muscle_Twice_smooth.stl, too"), ("Empty", "holds no triangle")):
        assert len([line for line in lines if name in line and words in line]) == 1, (name, lines)
    assert len(lines) == 5
    assert [path.name for path in (tmp_path / "out" / "scenes" / "knee").iterdir()] == ["popliteus.toml"]
    assert "Adrift" in (tmp_path / "out" / "README.md").read_text()


@pytest.mark.parametrize(("old", "new", "words"), [
    ('licence = "CC BY 4.0"', "", "licence: is missing"), ("near_mm = 2.0", "nearmm = 2.0", "nearmm: is no key"),
    ("(?P<name>[A-Za-z]+)'\nmuscle", "[A-Za-z]+'\nmuscle", "no group (?P<name>...)"),
    ("'Right_Bone_", "'(Right_Bone_", "is no regular expression"),
    ('moves = ["femur"]', 'moves = ["fibula"]', "there is no such bone or cartilage; there are femur, tibia"),
    ("to_deg = 40", 'to_deg = "40"', "to_deg: has to be"),
    ("axis = [-1, 0, 0]", "axis = [-1, 0]", "axis: has to be a point"), ("[files]", "[files", "is not valid TOML"),
    ("'Right_Bone_", "'Left_Bone_", "there is no such bone or cartilage"),
    ("[[joint]]", "[files.names]\nFemur = '../evil'\n[[joint]]", "can be no name"),
    ('name = "knee"', 'name = "a/b"', "can be no name"), ("[[joint]]", "names = ['a']\n[[joint]]", "has to be a table"),
    ("axis = [-1, 0, 0]", "axis = [0, 0, 0]", "has no length"),
    ('"CC BY 4.0"', '"CC BY-NC 4.0"', "write non_commercial = true"), ('title =', 'non_commercial = "false"\ntitle =', "has to be true or false"),
    ('"CC BY 4.0"', '"CC\\nend_header"', "has a line break"),
    ("near_mm = 2.0", "near_mm = -1", "has to be above 0"), ("to_deg = 40", "to_deg = 4000", "at most 360"),
    ("axis = [-1", "fit = 'sphere'\naxis = [-1", "keep one of the two"), ("near_mm = 2.0", "side = 'left'", "no pattern has a group"),
    ("near_mm = 2.0", "unit = 'm'", "which no bone or muscle is"),
    ("[[joint]]", "[[muscle]]\nname = 'a'\n[[muscle]]\nname = 'a'\n[[joint]]", "stands there twice"),
    ("near_mm = 2.0", "scene = 'frames = 3'", "is in no table"), ("near_mm = 2.0", "scene = '[loop'", "scene: is not valid TOML"),
    ('title = "A knee"', 'title = "A knee"\nunit = "inch"', "unit 'inch' has to be one of"),
])
def test_a_wrong_map_is_told_in_one_line(knee, tmp_path, capsys, old, new, words):
    assert MAP.count(old) == 1
    assert run(knee, tmp_path / "out", text=MAP.replace(old, new)) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len([line for line in lines if not line.startswith("import:    ")]) == 1 and words in lines[-1], lines
    assert not (tmp_path / "out").exists() and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(("name", "text"), [
    ("cut.ply", None), ("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n"), ("word.obj", "v 0 0 0\nv abc 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("more.ply", "ply\nformat ascii 1.0\nelement vertex 9999\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
                 "property list uchar int vertex_indices\nend_header\n0 0 0\n"),
])
def test_a_damaged_file_ends_in_one_line(tmp_path, name, text):
    path = tmp_path / name
    if text is None:
        data = write(ball(), tmp_path / "whole.ply").read_bytes()
        path.write_bytes(data[:len(data) // 2])
    else:
        path.write_text(text)
    with pytest.raises(Problem, match=f"{name}: (can't be read|holds no triangle|has coordinates)"):
        mend(read_mesh(path), name)


def test_what_gives_no_scene_is_told(knee, tmp_path, capsys):
    assert run(knee, tmp_path / "out", text=MAP.replace('["femur"]', '["femur", "tibia"]')) == import_tool.CODE_PARTLY
    assert "no scene: no muscle is attached to a bone that a joint moves" in capsys.readouterr().err
    one_end = MAP + '[[muscle]]\nname = "popliteus"\norigin = ["femur"]\n[[muscle]]\nname = "Popliteus"\n'
    assert run(knee, tmp_path / "two", text=one_end) == import_tool.CODE_PARTLY and "no muscle 'Popliteus'" in capsys.readouterr().err
    areas = json.loads((tmp_path / "two" / "import.json").read_text())["attachments"]
    assert {(one["bone"], one["role"]) for one in areas} == {("femur", "origin"), ("tibia", "insertion")}
    far = MAP + '[[muscle]]\nname = "popliteus"\ntendon = {to = "tibia", at = [0, 9999, 0], radius_mm = 2.0}\n'
    assert run(knee, tmp_path / "far", text=far) == import_tool.CODE_PARTLY and "mm away from tibia; is the map for" in capsys.readouterr().err


def test_the_unit_is_found_where_sizes_tell_it():
    assert units.unit_of({"femur": 480.0, "patella": 60.0}, "") == "mm"
    assert units.unit_of({"femur": 0.48, "patella": 0.06}, "") == "m"
    with pytest.raises(Problem, match="70 m large, which no bone"):
        units.unit_of({"femur": 70.0}, "m")
    with pytest.raises(Problem, match="mm and cm both fit"):
        units.unit_of({"patella": 60.0}, "")
    assert units.unit_of({"patella": 60.0}, "cm") == "cm"
    with pytest.raises(Problem, match="no unit fits"):
        units.unit_of({"house": 1e6}, "")
    with pytest.raises(Problem, match="fibula: is 0.4 large, where the others are some 400: another unit"):
        units.unit_of({"femur": 480.0, "tibia": 400.0, "fibula": 0.4}, "")


def test_left_and_right_are_not_mixed(tmp_path, capsys):
    (tmp_path / "folder").mkdir()
    for name in ("femur_left.stl", "femur_right.stl", "hip_right.stl", "sacrum.stl", "gluteus_medius_Right.stl"):
        (tmp_path / "folder" / name).touch()
    anatomy = read_map(PROJECT / "datasets" / "maps" / "totalsegmentator.toml")
    anatomy.side = ""
    with pytest.raises(Problem, match="has left and right, such as femur_left.stl and femur_right.stl: choose one by --side"):
        find_files(tmp_path / "folder", anatomy)
    for side, names in (("left", ["femur", "sacrum"]), ("right", ["femur", "gluteus_medius", "hip", "sacrum"])):
        anatomy.side = side
        assert sorted(one.name for one in find_files(tmp_path / "folder", anatomy)[0]) == names


@pytest.mark.parametrize(("name", "files", "parts"), [
    ("bodyparts3d", ["FMA16586.stl", "FMA24474.stl", "FMA24475.stl", "FMA22322.stl", "FMA2232.stl"], {"hip_bone", "femur", "iliacus"}),
    ("vsdfullbody", ["Hip_R.ply", "Hip_L.ply", "Femur_R.ply", "Sacrum.ply"], {"hip", "femur"}),
    ("visible_human_hip", ["VHM_Right_Bone_Femur_smooth.stl", "VHM_Right_Cartilage_FemurHead_smooth.stl", "VHM_Right_Muscle_Illiacus_smooth.stl",
                           "VHM_Left_Bone_Femur_smooth.stl", "VHM_Right_Muscle_SuperiorGemellus_smooth.stl", "VHM_Right_Muscle_Soleus_smooth.stl"],
     {"femur", "femur_head_cartilage", "iliacus", "superior_gemellus"}),
    ("visible_human_female", ["VHF_Right_Bone_Talus_smooth.stl", "VHF_Right_Bone_Femur_smooth.stl", "VHF_Right_Muscle_Soleus_smooth.stl",
                              "VHF_Right_Muscle_Popliteus_smooth.stl", "VHF_Right_Muscle_ExtensorHallucisLongus_smooth.stl"],
     {"talus", "soleus", "extensor_hallucis_longus"}),
])
def test_maps_know_the_names_of_their_data(tmp_path, name, files, parts):
    for file in files:
        (tmp_path / file).touch()
    found, problems = find_files(tmp_path, read_map(PROJECT / "datasets" / "maps" / f"{name}.toml"))
    assert {one.name for one in found} == parts and problems == []


def test_bones_alone_are_an_import_without_scenes(knee, tmp_path, capsys):
    bones_only = re.sub(r"muscle = .*\n", "", MAP)
    assert run(knee, tmp_path / "out", text=bones_only) == 0
    assert "0 scenes" in capsys.readouterr().out and not list((tmp_path / "out").rglob("scenes/*"))
    assert "Joint knee" in (tmp_path / "out" / "README.md").read_text()


def test_axes_are_those_of_the_shapes():
    random = np.random.default_rng(1)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    angle, along = random.uniform(-0.6, 0.6, 500), random.uniform(-12, 12, 500)
    points = np.column_stack([along, 20 * np.sin(angle), 20 * np.cos(angle)]) @ turn.T + [5, 6, 7]
    for sign in (1, -1):
        axis = fit_cylinder(points, sign * turn[:, 0])
        assert axis.direction @ turn[:, 0] == pytest.approx(sign, abs=1e-9) and axis.radius == pytest.approx(20, abs=1e-6) and axis.rms < 1e-6
        assert np.linalg.norm(np.cross(axis.centre - [5, 6, 7], turn[:, 0])) < 1e-6
    on_ball = random.normal(size=(300, 3))
    on_ball = 24 * on_ball[on_ball[:, 2] > 0] / np.linalg.norm(on_ball[on_ball[:, 2] > 0], axis=1)[:, None] + [1, 2, 3]
    fitted = fit_sphere(on_ball, np.array([0, 2.0, 0]))
    assert fitted.centre == pytest.approx([1, 2, 3], abs=1e-9) and fitted.radius == pytest.approx(24) and fitted.direction == pytest.approx([0, 1, 0])
    facing = articulating_points(ball(10), ball(10, (0, 0, 22)))
    assert 5 < len(facing) < 300 and facing[:, 2].min() > 5
    axis = Axis(np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), 1, 0)
    assert turned(np.array([[2.0, 0, 5]]), axis, 90)[0] == pytest.approx([1, 1, 5])


@pytest.mark.parametrize(("to_deg", "is_wrong"), [(45, True), (5, False)])
def test_a_joint_that_drives_bones_into_each_other_is_told(to_deg, is_wrong):
    words = JointWords("ankle", ["talus"], axis=np.array([1.0, 0, 0]), centre=np.array([0, -30.0, 12.5]), to_deg=to_deg)
    bones = {"talus": ball(10), "tibia": ball(10, (0, 0, 25))}
    problems = made_joint(words, bones, bones, "mm").problems
    assert bool(problems) == is_wrong and all("joint ankle: talus in tibia by " in one and "axis or the range is wrong" in one for one in problems)


OSIM_4 = """<OpenSimDocument Version="40000"><Model><JointSet><objects><PinJoint name="knee"><socket_parent_frame>thigh_offset</socket_parent_frame>
<coordinates><Coordinate name="knee_angle"/></coordinates><frames><PhysicalOffsetFrame name="thigh_offset"><translation>0.1 0.2 0.3</translation>
<orientation>0 1.5707963267948966 0</orientation></PhysicalOffsetFrame></frames></PinJoint></objects></JointSet></Model></OpenSimDocument>"""


def test_axes_of_opensim_models(tmp_path, lhdl_upstream, lhdl_folder):
    (tmp_path / "four.osim").write_text(OSIM_4)
    direction, centre = opensim_axis(tmp_path / "four.osim", "knee_angle")
    assert direction == pytest.approx([1, 0, 0], abs=1e-12) and centre == pytest.approx([0.1, 0.2, 0.3])
    with pytest.raises(Problem, match="has no coordinate 'hip'; there are knee_angle"):
        opensim_axis(tmp_path / "four.osim", "hip")
    (tmp_path / "none.osim").write_text("<a>")
    with pytest.raises(Problem, match="is no OpenSim model"):
        opensim_axis(tmp_path / "none.osim", "hip")
    hip = json.loads((lhdl_folder / "lhdl.json").read_text())["hip_joint"]
    for coordinate, axis in (("hip_flexion_r", "flexion"), ("hip_adduction_r", "adduction"), ("hip_rotation_r", "rotation")):
        direction, centre = opensim_axis(lhdl_upstream / "3d-muscles/a_MSK_model/a_MSK_model/LHDL_hip_r.osim", coordinate)
        assert direction == pytest.approx(hip["axes"][axis], abs=1e-9) and centre == pytest.approx(hip["centre_m"])


def test_a_map_gives_scenes_their_tables_and_tendons_their_rings(knee, tmp_path, capsys):
    text = MAP.replace("near_mm = 2.0", 'near_mm = 2.0\nscene = """\n[loop]\nframes = 7\n"""') + """
[[muscle]]
name = "popliteus"
origin = ["tibia"]
scene = "[effects.friction]"
tone = 0.03
[muscle.tendon]
to = "femur"
at = [0, -29, 5]
radius_mm = 2
rings = [{bone = "tibia", at = [0, -28, 0]}]
"""
    assert run(knee, tmp_path / "out", text=text) in (0, 3), capsys.readouterr().err
    scene = tomllib.loads((tmp_path / "out" / "scenes" / "knee" / "popliteus.toml").read_text())
    assert scene["loop"] == {"frames": 7} and set(scene["effects"]) == {"friction", "activation", "retinaculum"} and "wanted" not in scene
    assert [ring["bone"] for ring in scene["retinaculum"]] == ["tibia"] and scene["effects"]["activation"]["shortening"] == 0.03


def test_muscles_of_one_scene_keep_each_its_tone(tmp_path):
    (tmp_path / "map.toml").write_text(MAP)
    anatomy = read_map(tmp_path / "map.toml")
    muscles = [MusclePart(name, ball(), [], ["tibia"], tone=tone) for name, tone in (("taut", 0.06), ("half", 0.03), ("slack", 0.0))]
    scene = tomllib.loads(scene_text(anatomy, None, muscles, ""))
    assert scene["effects"]["activation"]["shortening"] == 0.06
    assert [one.get("activation", 1) for one in scene["muscle"]] == [1, 0.5, 0]
    assert "effects" not in tomllib.loads(scene_text(anatomy, None, muscles[2:], ""))


def test_a_corner_between_held_ones_is_no_spike():
    """Faces of a patch that is held in a bone dip into it, whatever its free corner does."""
    muscle = ball(10.0, (0, 0, 14.0), cells=40)  # 6 mm deep in the bone
    low = np.flatnonzero(muscle.vertices[:, 2] < 7.0)
    free = low[np.argmax(muscle.vertices[low, 2])]
    held = np.setdiff1d(low, free)
    moved, _ = moved_out(muscle, {"bone": ball(10.0, cells=40)}, [Area("bone", "origin", held, 0.0)])
    inside = max(0.0, -float(ball(10.0, cells=40).distance(muscle.vertices[[free]])[0]))
    assert np.linalg.norm(moved.vertices[free] - muscle.vertices[free]) < inside + 1.2


def test_a_muscle_is_attached_where_it_touches():
    muscle = spindle()
    bones = {"low": ball(20, (0, 0, -20.5), 60), "high": ball(20, (0, 0, 121), 60), "beside": ball(20, (29.5, 0, 50), 60), "far": ball(20, (300, 0, 0))}
    distances = distances_to(muscle, bones, 30)
    areas = areas_near_bones(muscle, distances, 2.0, {}, np.ones(len(muscle.vertices), dtype=bool))
    assert {area.bone for area in areas} == {"low", "high", "beside"} and len({area.role for area in areas if area.bone != "beside"}) == 2
    # A pulley that the muscle glides over is no second insertion; it is of the same bone.
    low_and_pulley = merged([ball(20, (0, 0, -20.5), 60), ball(15, (22.5, 0, 55), 60)])
    end, pulley = (areas_near_bones(muscle, distances_to(muscle, {"low": bone, "high": bones["high"], "more": ball(90, (97, 0, 75), 90)}, 30), 2.0, {},
                                    np.ones(len(muscle.vertices), dtype=bool)) for bone in (bones["low"], low_and_pulley))
    assert len({len(area.nodes) for areas in (end, pulley) for area in areas if area.bone == "low"}) == 1
    chosen = areas_near_bones(muscle, distances, 2.0, {"low": "origin", "high": "insertion"}, np.ones(len(muscle.vertices), dtype=bool))
    assert [(area.bone, area.role) for area in chosen] == [("low", "origin"), ("high", "insertion")]
    for area in chosen:
        gaps = np.linalg.norm(muscle.vertices[area.nodes] - [0, 0, -20.5 if area.bone == "low" else 121], axis=1) - 20
        assert gaps.max() < 2.05 and len(area.nodes) >= 4


def test_a_scene_attaches_the_nodes_of_an_area_and_no_other():
    muscle = spindle()
    muscle.vertices[:, 2] = 100 * (muscle.vertices[:, 2] / 100) ** 3  # edges of very different lengths
    area = Area("bone", "origin", np.flatnonzero(muscle.vertices[:, 2] < 0.02), 0.0)
    near = cKDTree(muscle.vertices[area.nodes]).query(muscle.vertices)[0] / 1000 <= reach_m(muscle, area)
    assert np.flatnonzero(near).tolist() == area.nodes.tolist() and 5 < len(area.nodes) < 300


def test_only_an_import_is_replaced(tmp_path):
    (tmp_path / "import.json").write_text('{"my": 1}')
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(Problem, match="import.json is none of its files"), whole_folder(tmp_path, "import.json", "import"):
        pass
    (tmp_path / "import.json").write_text('{"musclebench_import": 1, "files": ["import.json"]}')
    with pytest.raises(Problem, match="thesis.tex is none of its files"), whole_folder(tmp_path, "import.json", "import"):
        pass


def test_free_nodes_are_moved_out_of_bones(monkeypatch):
    muscle, bone = spindle(), ball(20, (24, 0, 50), 60)
    areas = [Area("bone", "origin", np.arange(5), 0.0)]
    out, told = moved_out(muscle, {"bone": bone}, areas)
    inside = np.linalg.norm(muscle.vertices - [24, 0, 50], axis=1) < 20
    count, farthest = map(float, re.fullmatch(r"(\d+) free nodes moved out of bones, by up to ([\d.]+) mm", *told).groups())
    assert count >= np.count_nonzero(inside) > 5 and 3.5 < farthest < 5
    monkeypatch.setattr(attaching, "PUSHES", 1)  # out of one bone into the other
    _, crowded = moved_out(muscle, {"bone": bone, "other": ball(20, (-12, 0, 50), 60)}, areas)
    assert crowded[-1].endswith("free nodes stay in bones")
    assert (np.linalg.norm(out.vertices - [24, 0, 50], axis=1) > 20).all() and (out.vertices[:5] == muscle.vertices[:5]).all()


def test_maps_read_names_as_data_sets_write_them(tmp_path):
    for path in sorted((PROJECT / "datasets" / "maps").glob("*.toml")):
        anatomy = read_map(path)
        assert anatomy.licence and anatomy.title
    for name in ("VHF_Right_Bone_Tibia_smooth.stl", "VHF_Right_Cartilage_TibiaDistal_smooth.stl", "VHF_Right_Muscle_FlexorHallucisLongus_smooth.stl",
                 "VHF_Left_Bone_Tibia_smooth.stl", "notes.stl"):
        (tmp_path / name).touch()
    files, problems = find_files(tmp_path, read_map(PROJECT / "datasets" / "maps" / "visible_human_female.toml"))
    assert [(one.kind, one.name) for one in files] == [("bone", "tibia"), ("cartilage", "tibia_distal_cartilage"), ("muscle", "flexor_hallucis_longus")]
    assert problems == []
