"""Places of a map that were read off one body are those of another, which lies elsewhere, is larger, or is of the other side."""

import numpy as np
import pytest
import vtk

from program import needs_native_module
from musclebench.anatomy.anatomy_map import JointWords, read_map
from musclebench.anatomy.carried import Place, _bone_place, carried, fitted
from musclebench.anatomy.joints import made_joint
from musclebench.anatomy.surface import Surface, from_vtk
from musclebench.lhdl.write_ply import write_ply
from musclebench.program.cli import Problem

pytestmark = needs_native_module
MIDDLES_MM = {"tibia": (0, 0, 300), "fibula": (40, 5, 290), "talus": (5, 10, 100), "calcaneus": (-5, -40, 60), "forefoot": (10, 120, 40)}
TURN = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
MAP = """title = "A leg"
licence = "CC BY 4.0"
[files]
bone = '(?P<name>\\w+)'
[reference]
meshes = "reference"
unit = "cm"
[[joint]]
name = "ankle"
moves = ["talus"]
axis = [1, 0, 0]
centre = [0.5, 1.0, 10.0]
from_deg = 0
to_deg = 20
[[muscle]]
name = "soleus"
[muscle.tendon]
to = "calcaneus"
at = [-0.5, -6.0, 6.0]
through = [[0, -1.0, 12.0]]
radius_mm = 3
rings = [{bone = "tibia", at = [0.5, 1.0, 22.0]}]
"""


def bones(matrix=np.eye(3), shift=(0, 0, 0)) -> dict[str, Surface]:
    found = {}
    for name, middle in MIDDLES_MM.items():
        source = vtk.vtkSphereSource()
        source.SetRadius(1)
        source.SetThetaResolution(24)
        source.SetPhiResolution(24)
        source.Update()
        one = from_vtk(source.GetOutput())
        # No symmetry: an egg with three axes.
        egg = one.vertices * [12, 18, 30] * (1 + 0.3 * one.vertices[:, [2]] + 0.2 * one.vertices[:, [0]] + 0.1 * one.vertices[:, [1]])
        triangles = one.triangles if np.linalg.det(matrix) > 0 else one.triangles[:, ::-1]
        found[name] = Surface((egg + middle) @ np.asarray(matrix).T + shift, triangles)
    return found


@pytest.fixture
def anatomy(tmp_path):
    (tmp_path / "reference").mkdir()
    for name, bone in bones().items():
        write_ply(tmp_path / "reference" / f"{name}.ply", bone.vertices / 1000, bone.triangles.astype(np.int32), ())
    (tmp_path / "map.toml").write_text(MAP)
    return read_map(tmp_path / "map.toml")


@pytest.mark.parametrize("mirrors", [False, True])
def test_points_are_fitted_as_they_were_moved(mirrors):
    points = np.random.default_rng(1).normal(size=(9, 3))
    mirror = np.diag([-1.0 if mirrors else 1.0, 1, 1])
    turn = TURN * np.linalg.det(TURN)
    place = fitted(points, points @ (1.3 * turn @ mirror).T + [1, 2, 3], mirrors)
    assert place.matrix == pytest.approx(1.3 * turn @ mirror) and place.shift == pytest.approx(np.array([1, 2, 3])) and place.is_mirrored == mirrors


@pytest.mark.parametrize(("mirror", "scale"), [(1, 1.1), (-1, 0.9)])
def test_places_go_along_with_their_bones(anatomy, mirror, scale):
    matrix, shift = scale * TURN * np.linalg.det(TURN) @ np.diag([mirror, 1, 1]), np.array([50, -700, 20])
    found = carried(anatomy, bones(matrix, shift), "m")
    tendon, joint = found.anatomy.muscles[0].tendon, found.anatomy.joints[0]
    assert ("mirrored" in found.words) == (mirror < 0) and f"scaled by {scale:.3f}" in found.words
    for place, own in ((tendon.at, [-5, -60, 60]), (tendon.through[0], [0, -10, 120]), (tendon.rings[0][1], [5, 10, 220]), (joint.centre, [5, 10, 100])):
        assert 1000 * place == pytest.approx(matrix @ own + shift, abs=0.05)
    # A mirror turns the sense of a rotation round: the foot goes up on both sides.
    assert joint.axis == pytest.approx(mirror * matrix @ [1, 0, 0] / scale, abs=1e-3)
    assert anatomy.muscles[0].tendon.at == pytest.approx(np.array([-0.5, -6, 6]))


def test_a_bone_that_lies_otherwise_takes_its_places_along(anatomy):
    """The foot is turned about its middle; the leg is not."""
    here = bones()
    angle = np.radians(20)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    middle = np.array(MIDDLES_MM["calcaneus"])
    here["calcaneus"].vertices[:] = (here["calcaneus"].vertices - middle) @ turn.T + middle + [3, 0, 0]
    tendon, goal = carried(anatomy, here, "mm").anatomy.muscles[0].tendon, turn @ (np.array([-5, -60, 60]) - middle) + middle + [3, 0, 0]
    assert np.linalg.norm(goal - [-5, -60, 60]) > 7 and np.linalg.norm(tendon.at - goal) < 2
    assert tendon.rings[0][1] == pytest.approx(np.array([5, 10, 220]), abs=0.3)


def test_the_reference_itself_is_left_as_it_is(anatomy):
    assert carried(anatomy, bones(), "cm") is None
    converted = carried(anatomy, bones(), "mm").anatomy
    assert converted.muscles[0].tendon.at == pytest.approx(np.array([-5, -60, 60])) and converted.joints[0].axis == pytest.approx([1, 0, 0])
    anatomy.reference = None
    assert carried(anatomy, bones(TURN), "mm") is None


def test_a_joint_that_this_body_does_not_tell_is_that_of_the_reference(anatomy, tmp_path, monkeypatch):
    """The reference has a ball on its talus and a shell around that; this body has none, or one at the wrong place."""
    ball = bones()["talus"]
    from_middle = ball.vertices - ball.vertices.mean(axis=0)
    ball.vertices = 12 * from_middle / np.linalg.norm(from_middle, axis=1)[:, None] + [5, 10, 130]
    write_ply(tmp_path / "reference" / "dome.ply", ball.vertices / 1000, ball.triangles.astype(np.int32), ())
    anatomy.joints[0] = JointWords("ankle", ["talus"], fit="sphere", surface="dome", axis_towards=np.array([1.0, 0, 0]), to_deg=20)
    matrix, shift = TURN * np.linalg.det(TURN) @ np.diag([-1, 1, 1]), np.array([50, -700, 20])
    here = bones(matrix, shift)
    words = carried(anatomy, here, "m").anatomy.joints[0]
    joint = made_joint(words, here, here, "m")
    assert "there is no dome" in joint.carried and joint.axis.centre == pytest.approx(matrix @ [5, 10, 130] + shift, abs=0.2)
    assert joint.axis.direction == pytest.approx(-matrix @ [1, 0, 0], abs=1e-3)
    # A dome in the wrong place: about it the talus comes into the tibia, about the carried axis it does not.
    middle = matrix @ np.array([90.0, 10, 200]) + shift
    far = Surface((ball.vertices - [5, 10, 130]) + middle, ball.triangles)
    words.to_deg = 300
    alone = JointWords("ankle", ["talus"], fit="sphere", surface="dome", axis_towards=words.axis_towards, to_deg=300)
    wrong = made_joint(alone, here | {"dome": far}, here, "m")
    mended = made_joint(words, here | {"dome": far}, here, "m")
    assert wrong.problems and "talus in tibia" in mended.carried and not mended.problems


def test_a_piece_of_a_bone_does_not_shrink_the_whole():
    whole = bones()["calcaneus"]
    used, triangles = np.unique(whole.triangles[whole.corners.mean(axis=1)[:, 1] > -34], return_inverse=True)
    piece = Surface(whole.vertices[used], triangles.reshape(-1, 3))
    place = _bone_place(whole, piece, Place(np.eye(3), np.zeros(3)))
    assert place.scale == pytest.approx(1)


def test_bones_in_a_plane_tell_no_side(anatomy, tmp_path):
    flat = bones()
    for name, (x, y, z) in MIDDLES_MM.items():
        flat[name].vertices[:] += [-x, 0, 0]
        write_ply(tmp_path / "reference" / f"{name}.ply", flat[name].vertices / 1000, flat[name].triangles.astype(np.int32), ())
    for bone in flat.values():
        bone.vertices[:] += [100, 0, 0]
    with pytest.raises(Problem, match="do not tell whether this is the side of its reference"):
        carried(anatomy, flat, "mm")


def test_another_part_of_the_body_is_refused(anatomy):
    with pytest.raises(Problem, match="1 bones of its reference .* it takes 4"):
        carried(anatomy, {"tibia": bones()["tibia"], "femur": bones()["talus"]}, "mm")
    strange = bones()
    for name, by in (("tibia", (0, 0, -300)), ("forefoot", (0, -200, 100))):
        strange[name].vertices[:] += by
    with pytest.raises(Problem, match="lie otherwise than in its reference .* is it the same part"):
        carried(anatomy, strange, "mm")


@pytest.mark.parametrize(("old", "new", "words"), [
    ('meshes = "reference"', 'meshes = "nowhere"', ["reference.meshes", "is no folder"]),
    ('unit = "cm"', 'unit = "ell"', ["reference.unit", "mm, cm, m"]),
    ('unit = "cm"', 'units = "cm"', ["reference.units", "meshes, unit"]),
])
def test_a_wrong_reference_is_told_in_one_line(anatomy, tmp_path, old, new, words):
    (tmp_path / "map.toml").write_text(MAP.replace(old, new))
    with pytest.raises(Problem) as problem:
        read_map(tmp_path / "map.toml")
    assert all(word in str(problem.value) for word in words)
