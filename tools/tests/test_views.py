"""Cameras look at the muscle from the right side of a right leg."""

import numpy as np
import pytest

from musclebench.pictures import views

LEFT, BACK, UP = np.eye(3)  # the frame of the anatomical data: x left, y back, z up


@pytest.fixture
def body():
    femur = np.array([[0.1, 0.2, -0.1], [0.1, 0.22, -0.5]])
    return views.body_directions(-2.0 * LEFT, np.array([0.1, 0.21, 0.0]), femur)


def test_directions_follow_from_the_axis_of_flexion_and_the_femur(body):
    assert body.lateral == pytest.approx(-LEFT) and body.anterior == pytest.approx(-BACK)
    assert body.superior == pytest.approx(UP)


def test_the_overview_holds_every_shape(body):
    shapes = np.array([[0.1, 0.2, 0.2], [0.12, 0.1, 0.1], [0.08, 0.3, -0.1]])
    view = views.overview(body, "iliacus", np.repeat(shapes, 50, axis=0))
    assert view.towards_eye @ body.anterior > 0.5 and view.towards_eye @ body.lateral < 0
    assert np.abs((shapes - view.focus_m) @ view.up).max() < view.half_height_m


def test_a_node_that_flies_off_does_not_shrink_the_picture(body):
    shape = np.random.default_rng(1).uniform(-0.1, 0.1, (2000, 3))
    lost = np.vstack([shape, [[50.0, 50.0, 50.0]]])
    assert views.overview(body, "iliacus", lost).half_height_m == pytest.approx(
        views.overview(body, "iliacus", shape).half_height_m, rel=0.02)


def test_the_cut_keeps_the_muscle(body):
    shape = np.random.default_rng(2).uniform(-0.1, 0.1, (200, 3))
    plane = views.cut_beside(body, shape)
    assert ((shape - plane.origin_m) @ plane.normal).min() == pytest.approx(views.CUT_MARGIN_M)
