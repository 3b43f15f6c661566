"""Cameras follow from the scene: its muscle, its bones and the axis that it turns about."""

import numpy as np
import pytest

from musclebench.pictures import views

LEFT, BACK, UP = np.eye(3)  # the frame of the anatomical data: x left, y back, z up
RANDOM = np.random.default_rng(1)
MUSCLE = RANDOM.uniform(-1, 1, (2000, 3)) * [0.01, 0.02, 0.1] + [0.1, 0.12, 0.0]  # upright, before the axis
BONES = np.vstack([RANDOM.uniform(-0.02, 0.02, (500, 3)) + [0.1, 0.21, height] for height in (-0.1, 0.0, 0.1)])


@pytest.fixture
def joint():
    femur = np.array([[0.1, 0.2, -0.1], [0.1, 0.22, -0.5]])
    return views.joint_directions(-2.0 * LEFT, np.array([0.3, 0.21, 0.0]), femur, MUSCLE)


def test_directions_follow_from_the_axis_and_the_bone_that_moves(joint):
    assert joint.axis == pytest.approx(-LEFT) and joint.front == pytest.approx(-BACK) and joint.up == pytest.approx(UP)
    assert joint.centre_m == pytest.approx([MUSCLE[:, 0].mean(), 0.21, 0.0])  # level with the muscle


@pytest.mark.parametrize("moved", [np.zeros((2, 3)), np.array([[5.0, 0, 0], [-5.0, 0, 0]])])
def test_a_bone_on_the_axis_leaves_the_muscle_upright(moved):
    joint = views.joint_directions(LEFT, np.zeros(3), moved, MUSCLE)
    assert abs(joint.up @ UP) > 0.99


def test_the_muscle_is_seen_before_its_bones_and_in_its_whole_length(joint):
    eye = views.side_of_muscle(joint, MUSCLE, BONES)
    assert eye @ -BACK > 0.5 and abs(eye @ views.principal_axes(MUSCLE)[0]) < 0.1
    assert abs(eye @ joint.axis) > 0.3  # much of the turn is in the picture


def test_the_overview_holds_every_shape(joint):
    shapes = np.repeat(np.array([[0.1, 0.2, 0.2], [0.12, 0.1, 0.1], [0.08, 0.3, -0.1]]), 50, axis=0)
    view = views.overview(joint, views.side_of_muscle(joint, MUSCLE, BONES), [shapes])
    assert np.abs((shapes - view.focus_m) @ view.up).max() < view.half_height_m
    assert view.up @ view.towards_eye == pytest.approx(0, abs=1e-12)


def test_the_overview_holds_a_small_muscle_at_the_moment_when_it_is_far_out(joint):
    small = MUSCLE[:100] + [0.0, -0.3, 0.0]
    shapes = [MUSCLE] * 20 + [small]
    view = views.overview(joint, views.side_of_muscle(joint, MUSCLE, BONES), shapes)
    right = np.cross(view.up, view.towards_eye)
    for along in (right, view.up):
        assert np.abs((small - view.focus_m) @ along).max() < view.half_height_m


def test_a_node_that_flies_off_does_not_shrink_the_picture(joint):
    lost, eye = np.vstack([MUSCLE, [[50.0, 50.0, 50.0]]]), views.side_of_muscle(joint, MUSCLE, BONES)
    assert views.overview(joint, eye, [lost]).half_height_m == pytest.approx(
        views.overview(joint, eye, [MUSCLE]).half_height_m, rel=0.02)


def test_the_cut_keeps_the_muscle_and_takes_the_side_with_more_bone(joint):
    bones = np.vstack([BONES, BONES + 0.3 * LEFT])
    plane = views.cut_beside(joint, MUSCLE, bones)
    assert ((MUSCLE - plane.origin_m) @ plane.normal).min() == pytest.approx(views.CUT_MARGIN_M)
    assert ((bones - plane.origin_m) @ plane.normal < 0).sum() >= len(BONES)
