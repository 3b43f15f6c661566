"""A backend in Python: exact where it can be, marked in results, and refused where its answers don't fit."""

import re
import signal
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import numpy as np
import pytest

import musclebench


class Box:
    """Takes each bone for the box around it. Of a box that is exact."""

    name = "numpy_box"
    implementation = "box 1.0, MIT"
    parameters = {"margin_m": 0.0}

    def build(self, name, vertices, triangles):
        return BoxStructure(vertices.min(axis=0), vertices.max(axis=0))


class BoxStructure:
    bound_m = 1e-12
    bytes = 48

    def __init__(self, lower, upper):
        self.lower, self.upper = lower, upper

    def detect(self, points):
        to_faces_m = np.hstack([points - self.lower, self.upper - points])
        inside = np.flatnonzero((to_faces_m > 0).all(axis=1))
        face = to_faces_m[inside].argmin(axis=1)
        return inside, to_faces_m[inside, face], np.vstack([-np.eye(3), np.eye(3)])[face]


def test_an_exact_one_runs_as_ours(scene):
    ours, theirs = musclebench.run(scene, "bvh"), musclebench.run(scene, Box())
    assert theirs.record["outcome"]["true_contacts"] > 40
    for column in ("contacts", "nodes_inside", "missed_contacts", "false_contacts"):
        assert (ours.frames[column] == theirs.frames[column]).all(), column
    np.testing.assert_allclose(ours.frames["max_depth_m"], theirs.frames["max_depth_m"], atol=1e-12)
    assert theirs.status == ours.status


def test_results_mark_it(scene, tmp_path):
    run = musclebench.run(scene, Box(), out=tmp_path / "run")
    assert run.record["implementations"] == {"numpy_box": "box 1.0, MIT (in Python)"}
    assert run.record["case"]["parameters"] == {"margin_m": 0.0} and run.record["structure_bytes"] == 48


def test_the_judge_holds_it_to_its_bound(scene, tmp_path):
    recording = musclebench.record(scene, tmp_path / "steps")
    replay = musclebench.replay(recording, Box())
    accuracy, declared = replay.record["accuracy"], replay.record["declared"]
    assert replay.status == "ok" and accuracy["true_contacts"] > 80
    assert accuracy["missed_contacts"] == accuracy["false_contacts"] == 0
    assert accuracy["max_depth_error_m"] < 1e-12 == declared["missed_depth_m"]
    probed = musclebench.probe(scene, Box(), points=2000)
    assert probed["wrong_side"].max() == 0 and probed["max_error_m"].max() < 1e-12


@pytest.mark.parametrize("answer, words", [
    (lambda points: (np.array([], dtype=int), np.array([]), np.zeros((0, 3))), "missed a contact"),
    (lambda points: (np.arange(len(points)), np.full(len(points), 0.1), np.tile(UP, (len(points), 1))), "found a contact"),
])
def test_the_judge_sees_a_broken_bound(answer, words, scene, tmp_path):
    recording = musclebench.record(scene, tmp_path / "steps")
    replay = musclebench.replay(recording, answering(None, detect=answer))
    assert replay.status == "suspect" and words in replay.record["status_detail"]
    assert "declares none" in replay.record["status_detail"]


def example() -> object:
    """The backend that the docstring of the module shows, in at most 20 lines."""
    code = textwrap.dedent(re.search(r"^    class .*", musclebench.__doc__, re.S | re.M).group())
    assert len([line for line in code.splitlines() if line.strip()]) <= 20
    names = {"numpy": np}
    exec(code, names)
    return names["Balls"]()


def test_the_example_of_the_docstring_holds_what_it_declares(ball):
    balls = example()
    long_box = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-0.2, 0.2) for z in (-0.1, 0.1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (20_000, 3)) * (1, 0.5, 0.5)
    for bone in (musclebench.Bone("box", long_box, triangles), musclebench.Bone("ball", *ball)):
        truth_m = musclebench.Backend("bvh", [bone]).locate(points)["signed_distance_m"]
        backend = musclebench.Backend(balls, [bone])
        found = np.isin(np.arange(len(points)), backend.detect(points)["node"])
        missed_m, false_m = backend.bound()
        assert -truth_m[~found].min() <= missed_m and truth_m[found].max(initial=0) <= false_m
    assert found.sum() > 10


def answering(answer, **more):
    """A backend whose structures answer so."""
    structure = SimpleNamespace(**({"bound_m": 0.001, "detect": lambda points: answer} | more))
    return SimpleNamespace(name="mine", implementation="mine 1, MIT", build=lambda name, vertices, triangles: structure)


UP = np.array([[0.0, 0.0, 1.0]])
ONE = np.array([0])


@pytest.mark.parametrize("answer, words", [
    (None, "is no tuple of three arrays"),
    ((ONE, np.array([0.1])), "is no tuple of three arrays"),
    ((np.array([0.0]), np.array([0.1]), UP), "indices: has elements of type float64; give integers"),
    ((np.array([True]), np.array([0.1]), UP), "indices: has elements of type bool; give integers"),
    ((ONE, np.array(["0.1"]), UP), "depths_m: has elements of type <U3; give real numbers"),
    ((ONE, np.array([0.1, 0.2]), UP), "arrays of different lengths"),
    ((ONE, np.array([0.1]), np.vstack([UP, UP])), "arrays of different lengths"),
    ((ONE, np.array([0.1]), UP[0]), "give an array of shape (n, 3)"),
    ((np.array([99]), np.array([0.1]), UP), "names point 99, and there are 2"),
    ((np.array([-1]), np.array([0.1]), UP), "names point -1"),
    ((np.array([1, 0]), np.array([0.1, 0.1]), np.vstack([UP, UP])), "indices that do not ascend"),
    ((np.array([1, 1]), np.array([0.1, 0.1]), np.vstack([UP, UP])), "indices that do not ascend"),
    ((ONE, np.array([-0.1]), UP), "a depth of -0.1 m"),
    ((ONE, np.array([np.nan]), UP), "a depth of nan m"),
    ((ONE, np.array([np.inf]), UP), "a depth of inf m"),
    ((ONE, np.array([0.1]), 2 * UP), "a normal of length 2"),
    ((ONE, np.array([0.1]), np.nan * UP), "a normal of length nan"),
])
def test_an_answer_that_does_not_fit_is_refused(answer, words, ball):
    backend = musclebench.Backend(answering(answer), [musclebench.Bone("ball", *ball)])
    with pytest.raises(musclebench.InputError, match="backend 'mine' over ball") as refused:
        backend.detect(np.zeros((2, 3)))
    assert words in str(refused.value)


@pytest.mark.parametrize("change, words", [
    ({"bound_m": -1.0}, "bound_m has to be at least 0 m"),
    ({"bound_m": float("nan")}, "bound_m has to be at least 0 m"),
    ({"bound_m": "wide"}, "bound_m is no length"),
    ({"bound_m": True}, "bound_m has to be at least 0 m"),
    ({"bound_m": (1.0, 2.0, 3.0)}, "no pair of them"),
    ({"bytes": -1}, "has -1 bytes"),
    ({"bytes": 1.5}, "bytes: is of type float; give an integer"),
])
def test_a_bound_that_is_none_is_refused(change, words, ball):
    with pytest.raises(musclebench.InputError, match=words):
        musclebench.Backend(answering(None, **change), [musclebench.Bone("ball", *ball)])


@pytest.mark.parametrize("change, words", [
    ({"name": "bvh"}, "has the name of a backend of this build"),
    ({"name": "../x"}, "small letters, digits and _ only"),
    ({"name": ""}, "small letters, digits and _ only"),
    ({"implementation": None}, None),
])
def test_a_name_that_would_mislead_is_refused(change, words, ball):
    backend = answering(None)
    for key, value in change.items():
        setattr(backend, key, value)
    if words is None:
        del backend.implementation
        words = "say whose code it is"
    with pytest.raises(musclebench.InputError, match=words):
        musclebench.Backend(backend, [musclebench.Bone("ball", *ball)])


def test_its_own_error_comes_out_of_a_run_and_nothing_is_written(scene, tmp_path):
    def fail(points):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        musclebench.run(scene, answering(None, detect=fail), out=tmp_path / "out")
    assert not list(tmp_path.iterdir())
    assert musclebench.run(scene, "bvh").status  # the scene is as it was


def test_no_contacts_are_three_empty_lists(ball):
    backend = musclebench.Backend(answering(([], [], []), bound_m=np.array(0.1)), [musclebench.Bone("ball", *ball)])
    assert len(backend.detect(np.zeros((2, 3)))) == 0 and backend.bound() == (0.1, 0.1)


def test_it_may_not_ask_itself(scene):
    def ask(points):
        return backend.detect(points)

    backend = musclebench.Backend(answering(None, detect=ask), scene)
    for _ in range(2):
        with pytest.raises(musclebench.InputError, match="mine: is asked while it answers"):
            backend.detect(np.zeros((5, 3)))


def test_its_results_are_never_those_of_an_earlier_one(scene, tmp_path):
    musclebench.run(scene, Box(), out=tmp_path / "out")
    with pytest.raises(musclebench.InputError, match="may have changed since"):
        musclebench.run(scene, Box(), out=tmp_path / "out")
    musclebench.run(scene, Box(), out=tmp_path / "out", force=True)


def test_what_a_property_raises_is_told(scene):
    class Broken(Box):
        @property
        def name(self):
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        musclebench.Backend(Broken(), scene)


def test_two_scenes_that_wait_for_each_other_end_with_ctrl_c(scene_file):
    waiting = subprocess.Popen([sys.executable, "-c", TWO_SCENES, str(scene_file)], stdout=subprocess.PIPE, text=True)
    assert waiting.stdout and waiting.stdout.readline() == "ready\n"
    time.sleep(1.5)
    waiting.send_signal(signal.SIGINT)
    assert waiting.communicate(timeout=20)[0] == "interrupted\n"


TWO_SCENES = """
import os, sys, threading, time, musclebench, numpy as np
scenes = [musclebench.load_scene(sys.argv[1]) for _ in range(2)]
trees = [musclebench.Backend("bvh", scene) for scene in scenes]
class Asks:
    name, implementation, bound_m = "asks", "asks 1, MIT", 1.0
    def __init__(self, other):
        self.other = other
    def build(self, *mesh):
        return self
    def detect(self, points):
        time.sleep(0.5)
        self.other.detect(points)
        return [], [], []
asking = [musclebench.Backend(Asks(other), scene) for scene, other in zip(scenes, trees[::-1])]
threading.Thread(target=asking[1].detect, daemon=True).start()
print("ready", flush=True)
try:
    asking[0].detect()
except KeyboardInterrupt:
    print("interrupted", flush=True)
os._exit(0)
"""


def test_it_may_keep_its_points(scene):
    kept = []

    def keep(points):
        kept.append(points)
        return np.array([], dtype=int), np.array([]), np.zeros((0, 3))

    musclebench.run(scene, answering(None, detect=keep))
    sums = [points.sum() for points in kept]
    musclebench.run(scene, "bvh")
    assert [points.sum() for points in kept] == sums and len(kept) > 10


def test_it_may_ask_another_backend_of_the_same_scene(scene):
    exact = musclebench.Backend("bvh", scene)

    def ask(points):
        found = exact.detect(points)
        return found["node"].astype(int), found["depth_m"], found["normal"]

    assert musclebench.run(scene, answering(None, detect=ask)).frames["missed_contacts"].sum() == 0
