"""Points in, contacts and distances out: against the analytic ball, without copies, from several threads."""

import gc
import threading
import tracemalloc

import numpy as np
import pytest

import musclebench

RADIUS_M, FACETS_M = 0.1, 2e-4  # of the ball, and how far its triangles are inside of it at most


@pytest.fixture(scope="module")
def bone(ball):
    vertices, triangles = ball
    return musclebench.Bone("ball", vertices, triangles)


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(1).uniform(-0.15, 0.15, (4000, 3)) + (1.0, 0.0, 0.0)


def away(points):
    return np.linalg.norm(points - (1.0, 0.0, 0.0), axis=1)


def backends(**wanted):
    return [each["name"] for each in musclebench.catalogue()["backends"] if all(each[key] == value for key, value in wanted.items())]


@pytest.mark.parametrize("name", backends())
def test_contacts_are_those_of_a_ball_within_the_declared_bound(name, bone, points):
    try:
        backend = musclebench.Backend(name, [bone])
    except musclebench.UnsupportedInput as refused:
        assert "collides whole surfaces" in str(refused)
        return
    missed_m, false_m = backend.bound("ball")
    found = backend.detect(points)
    is_found = np.isin(np.arange(len(points)), found["node"])
    depth_m = RADIUS_M - away(points)
    assert (np.diff(found["node"]) > 0).all() and (found["bone"] == 0).all()
    assert is_found[depth_m > missed_m + FACETS_M].all()
    assert not is_found[depth_m < -false_m - FACETS_M].any()
    told = found[found["depth_m"] > 0]
    off_m = np.abs(told["depth_m"] - depth_m[told["node"]])
    assert len(told) == 0 or off_m.max() <= max(missed_m, false_m) + FACETS_M
    assert len(told) == 0 or np.abs(np.linalg.norm(told["normal"], axis=1) - 1).max() < 1e-9


@pytest.mark.parametrize("name, tolerance_m", [("bvh", FACETS_M), ("sdf", 1e-3), ("embree", FACETS_M)])
def test_both_sides_of_a_ball(name, tolerance_m, bone, points):
    if name not in backends():
        pytest.skip(f"this build has no {name}")
    located = musclebench.Backend(name, [bone]).locate(points, 0)
    near = np.abs(away(points) - RADIUS_M) < 0.003  # within the box of the bone: beyond it a field tells less
    outwards = (points - (1.0, 0.0, 0.0)) / away(points)[:, None]
    assert np.abs(located["signed_distance_m"] - (away(points) - RADIUS_M))[near].max() < tolerance_m
    assert (located["normal"] * outwards).sum(axis=1)[near].min() > 0.99
    assert np.abs(away(located["closest_m"]) - RADIUS_M)[near].max() < tolerance_m


def test_a_backend_that_knows_only_the_inside_says_nothing_of_the_outside(bone, points):
    truth = musclebench.Backend("bvh", [bone]).locate(points)["signed_distance_m"]
    told = musclebench.Backend("brute_force", [bone]).locate(points)
    inside = truth < 0
    assert np.isnan(told["signed_distance_m"][~inside]).all()
    np.testing.assert_allclose(told["signed_distance_m"][inside], truth[inside], atol=1e-15)
    with pytest.raises(musclebench.UnsupportedInput, match="tells no depth of a single point"):
        musclebench.Backend("voxel", [bone]).locate(points)


def test_points_that_are_no_numbers_have_no_contact_and_no_distance(bone):
    points = np.array([[1.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    backend = musclebench.Backend("bvh", [bone])
    assert backend.detect(points)["node"].tolist() == [0]
    assert np.isnan(backend.locate(points)["signed_distance_m"]).tolist() == [False, True, True]


@pytest.mark.parametrize("name", backends())
def test_nothing_is_inside_from_afar(name, bone):
    """Rounding would give a far point either side, and a ray that is none ends a library's program."""
    try:
        backend = musclebench.Backend(name, [bone])
        located = backend.locate([[1e20, 0, 0], [-1e12, 1e12, 1e12], [1e300, 1e300, 1e300], [1e8, -2e8, 3e8]])
    except musclebench.UnsupportedInput:
        return
    assert np.isnan(located["signed_distance_m"][:3]).all() and not located["signed_distance_m"][3] < 0
    assert len(backend.detect([[1e12, 0, 0], [1e8, -2e8, 3e8]])) == 0


def test_poses_move_the_bone(scene):
    backend = musclebench.Backend("bvh", scene)
    poses = scene.poses(scene.frames)
    inside = np.array([[0.0, 0.0, 0.0]])
    moved = inside @ poses[0, :3, :3].T + poses[0, :3, 3]
    (at_rest,), (after,) = backend.detect(inside), backend.detect(moved, poses)
    assert after["depth_m"] == pytest.approx(at_rest["depth_m"], abs=1e-15)
    np.testing.assert_allclose(poses[0, :3, :3] @ at_rest["normal"], after["normal"], atol=1e-12)


def test_arrays_are_read_and_given_where_they_are(bone):
    points = np.random.default_rng(2).uniform(-1, 1, (500_000, 3))  # 12 MB
    backend = musclebench.Backend("bvh", [bone])
    backend.detect(points)
    tracemalloc.start()  # NumPy tells it of every array that it makes
    found = backend.detect(points)
    _, peak_bytes = tracemalloc.get_traced_memory()
    backend.detect(points.astype(np.float32))
    _, with_copy_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak_bytes < 100_000 < points.nbytes < with_copy_bytes
    assert not found.flags.owndata


def test_other_arrays_are_converted(bone, points):
    backend = musclebench.Backend("bvh", [bone])
    expected = backend.detect(points)
    assert (backend.detect(points.tolist()) == expected).all()
    assert (backend.detect(np.asfortranarray(points)) == expected).all()
    unaligned = np.frombuffer(b"x" + points.tobytes(), dtype=np.uint8)[1:].view("V24").view(np.float64).reshape(-1, 3)
    assert (backend.detect(unaligned) == expected).all()
    assert len(backend.detect(np.zeros((0, 3)))) == 0
    wide = np.zeros((len(points), 6))
    wide[:, ::2] = points
    assert (backend.detect(wide[:, ::2]) == expected).all()


def test_views_keep_what_they_show(scene_file):
    scene = musclebench.load_scene(scene_file)
    nodes, bone = scene.nodes, scene.bones[0]
    backend = musclebench.Backend("bvh", scene)
    expected = nodes.sum()
    del scene
    gc.collect()
    assert nodes.sum() == expected and bone.vertices.shape == (8, 3)
    assert len(backend.detect(nodes, None)) >= 0
    with pytest.raises(ValueError, match="read-only"):
        nodes[0] = 1


def test_two_threads_ask_one_backend(bone, points):
    backend = musclebench.Backend("bvh", [bone])
    expected, answers = backend.detect(points), []

    def ask():
        for _ in range(20):
            answers.append((backend.detect(points) == expected).all())

    asking = [threading.Thread(target=ask) for _ in range(2)]
    for each in asking:
        each.start()
    for each in asking:
        each.join()
    assert len(answers) == 40 and all(answers)


@pytest.mark.parametrize("call, words", [
    (lambda bone: musclebench.Backend("bhv", [bone]), "did you mean 'bvh'"),
    (lambda bone: musclebench.Backend(3, [bone]), "has no name"),
    (lambda bone: musclebench.Backend("sdf", [bone], {"cell": 3}), "did you mean 'cells'"),
    (lambda bone: musclebench.Backend("sdf", [bone], {"cells": [3]}), "type list; give a bool, a number or a string"),
    (lambda bone: musclebench.Backend("bvh", []), "give a scene, or at least one bone"),
    (lambda bone: musclebench.Backend("bvh", [bone], threads=0), "give at least 1"),
    (lambda bone: musclebench.Backend("bvh", [bone], threads=4096), "cores of this machine"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(np.zeros((3, 2))), "shape (3, 2); give an array of shape (n, 3)"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(), "only a backend over a scene has nodes"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(np.zeros((1, 3)), np.eye(4)), "of shape (1, 4, 4)"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(np.zeros((1, 3)), 2 * np.eye(4)[None]), "no rigid motion"),
    (lambda bone: musclebench.Backend("bvh", [bone]).locate(np.zeros((1, 3)), "bal"), "there are 0 to 0: ball"),
    (lambda bone: musclebench.Backend("bvh", [bone]).locate(np.zeros((1, 3)), -1), "-1 is none of them"),
    (lambda bone: musclebench.Backend("sdf", [bone], {"cells": 2**70}), "parameters (sdf).cells: is too large"),
    (lambda bone: musclebench.Backend("sdf", [bone], {"cells": np.array(32.9)}), "type ndarray; give a bool"),
    (lambda bone: musclebench.Backend("sdf", [bone], {"cells": float("nan")}), "is nan; give a finite number"),
    (lambda bone: musclebench.Backend("bvh", ["femur"]), "no Bone"),
    (lambda bone: musclebench.Backend("bvh", [bone], [1]), "parameters: are no dict"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(1j * np.ones((3, 3))), "type complex128; give real numbers"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect([["a", "b", "c"]]), "give real numbers"),
    (lambda bone: musclebench.Backend("bvh", [bone]).detect(np.ma.masked_array(np.ones((3, 3)))), "masked array"),
    (lambda bone: musclebench.Backend("bvh", [bone]).locate(np.zeros((1, 3)), np.array(0.9)), "type ndarray; give an integer"),
    (lambda bone: musclebench.Backend("bvh", [bone]).locate(np.zeros((1, 3)), 2**70), "bone: is too large"),
    (lambda bone: musclebench.Bone("b", [[0, 0, 0]], [[0, 0, 0.9]]), "triangles: has elements of type float64; give integers"),
    (lambda bone: musclebench.Bone("b", [[0, 0, 0]], np.array([[0, 0, 2**32]])), "triangle 0 names vertex 4294967296"),
    (lambda bone: musclebench.Bone("b", [[0, 0, 1e20]], [[0, 0, 0]]), "vertex 0 is farther than 1e+09 m"),
    (lambda bone: musclebench.Bone("b", [[0, 0, 0]], [[0, 0, 1]]), "triangle 0 names vertex 1, and there are 0 to 0"),
    (lambda bone: musclebench.Bone("b", [[0, 0, np.nan]], [[0, 0, 0]]), "vertex 0 is not finite"),
])
def test_bad_input_is_one_line_with_a_cure(call, words, bone):
    with pytest.raises(musclebench.InputError) as refused:
        call(bone)
    assert words in str(refused.value) and "\n" not in str(refused.value)
