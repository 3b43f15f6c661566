"""Tendons that the importer adds: where they run, how they are sewn to muscles, and their rings."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from anatomy_shapes import ball, spindle
from musclebench.anatomy.joint_axis import Axis
from musclebench.anatomy.joints import turned
from musclebench.anatomy.mesh_file import open_edges
from musclebench.anatomy.rings import ROOM_MM, ring_around
from musclebench.anatomy.self_crossings import crossing_triangles
from musclebench.anatomy.sewing import Unsewable, border_loops, clipped, sew, without_bays, without_bumps
from musclebench.anatomy.surface import Surface, largest_gap, merged
from musclebench.anatomy.tendon import GAP_MM, Tendon, deepest_in_bones, reach_of_tendon, tendon_path, with_tendon
from musclebench.anatomy.tendon_route import route
from musclebench.program.cli import Problem
from program import needs_native_module

pytestmark = needs_native_module


def test_a_tendon_goes_the_shortest_way_around_a_bone():
    """Over a ball: straight, an arc at the tendon's distance, straight. The length is known."""
    muscle, radius = spindle(), 2.0
    bone, end = ball(15, (0, 0, 130), cells=60), ball(4, (0, 3, 170))
    tendon = Tendon("end", end.distance.nearest(np.array([0, 3.0, 165.0])), np.array([[0.0, 18.5, 131.0]]), radius)
    bones = {"bone": bone, "end": end}
    path = tendon_path(muscle, tendon, bones)
    assert deepest_in_bones(path, tendon, bones) == ("", 0.0)
    assert bone.distance(path).min() > radius + GAP_MM - 0.1
    assert np.linalg.norm(path[-1] - [0, 3, 166]) < 0.05 and np.abs(path[:, 0]).max() < 0.5
    start, over, reach = path[0], np.array([0, 0, 130.0]), 15 + radius + GAP_MM
    sides = [np.linalg.norm(point - over) for point in (start, path[-1])]
    between = np.arccos((start - over) @ (path[-1] - over) / sides[0] / sides[1])
    arc = between - sum(np.arccos(reach / side) for side in sides)
    shortest = sum(np.sqrt(side**2 - reach**2) for side in sides) + reach * arc
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert shortest - 0.2 < length < 1.03 * shortest
    whole = with_tendon(muscle, path, radius)
    beyond = np.linalg.norm(np.diff(path[path[:, 2] > 104], axis=0), axis=1).sum()
    assert open_edges(whole) == 0 and whole.volume - muscle.volume == pytest.approx(np.pi * radius**2 * beyond, rel=0.25)
    away = muscle.corners[cKDTree(path).query(muscle.vertices)[0][muscle.triangles].min(axis=1) > reach_of_tendon(radius)].reshape(-1, 9)
    assert len(away) > 500 and not set(map(tuple, away)) - set(map(tuple, whole.corners.reshape(-1, 9)))  # the muscle's own triangles
    assert len(crossing_triangles(whole)) == 0


def test_surfaces_are_sewn_along_borders_of_any_number():
    """A ball without its belt, and the belt of a finer one."""
    coarse, fine = ball(10.0, cells=24), ball(10.0, cells=60)
    caps = clipped(coarse, np.abs(coarse.vertices[:, 2]), 4.0, False)
    belt = clipped(fine, np.abs(fine.vertices[:, 2]), 3.0, True)
    assert sorted(len(border_loops(one)) for one in (caps, belt)) == [2, 2]
    whole = sew(caps, belt)
    assert open_edges(whole) == 0 and not len(crossing_triangles(whole))
    assert coarse.volume < whole.volume < fine.volume and largest_gap(whole, fine) < 0.2
    with pytest.raises(Unsewable):
        sew(clipped(coarse, coarse.vertices[:, 2], 4.0, False), belt)


def test_what_comes_near_a_border_without_crossing_it_stays():
    surface = ball(10.0, cells=40)
    x, z = surface.vertices[:, 0], surface.vertices[:, 2]
    bump = np.where(x > 9.5, 5.5, np.minimum(z, 4.0))  # above 5 at a place of its own, and nowhere above 6
    high = np.where(z > 8, 7.0, bump)
    kept = without_bumps(surface, high, 5.0, 6.0)
    assert kept[x > 9.5].max() == 5.0 and kept[z > 8].min() == 7.0
    assert np.array_equal(without_bays(surface, -high, -6.0, -5.0), -kept)


def test_a_ring_lies_around_its_tendon_and_no_other_part():
    tendon = Surface(spindle(120.0, 3.0).vertices, spindle().triangles)
    beside = Surface(tendon.vertices + [30.0, 0, 0], tendon.triangles)
    path = np.column_stack([np.zeros(60), np.zeros(60), np.linspace(1, 119, 60)])
    ring = ring_around(merged([tendon, beside]), path, "bone", np.array([5.0, 1.0, 61.0]))
    assert np.abs(ring.axis) == pytest.approx([0, 0, 1]) and ring.centre == pytest.approx([0, 0, 61], abs=0.1)
    assert ring.radius == pytest.approx(3.0 + ROOM_MM, abs=0.05)
    with pytest.raises(Problem, match="a ring is 22 mm from its tendon"):
        ring_around(tendon, path, "bone", np.array([22.0, 0, 61]))


def test_a_tendon_that_has_to_go_through_a_bone_is_told():
    bones = {"bone": ball(15, (0, 0, 95)), "end": ball(5, (0, 0, 150))}
    tendon = Tendon("end", np.array([0, 0, 145.0]), np.empty((0, 3)), 2.0)
    name, depth = deepest_in_bones(tendon_path(spindle(), tendon, bones), tendon, bones)
    assert name == "bone" and depth > 5


def test_a_tendon_finds_a_way_around_a_bone_that_splits_it():
    """Half of its straight way is nearer to one side of the bone, half to the other: a plate that leans across it."""
    plate = ball(1.0, cells=40)
    plate.vertices = plate.vertices * [40.0, 8.0, 40.0] @ turned(np.eye(3), Axis(np.array([1.0, 0, 0]), np.zeros(3)), -20.0) + [0, 0, 140.0]
    bones = {"bone": plate, "end": ball(5, (0, 0, 200))}
    tendon = Tendon("end", np.array([0, 0, 195.0]), np.empty((0, 3)), 2.0)
    path = tendon_path(spindle(), tendon, bones)
    between = np.concatenate([path[:-1] + share * np.diff(path, axis=0) for share in np.linspace(0, 1, 9)])
    assert plate.distance(between).min() > tendon.radius - 0.2 and path[-1] == pytest.approx(tendon.at)


def test_a_way_keeps_room_where_there_is_room_and_takes_the_shortest():
    wall = ball(20.0, (0, 3.0, 0), cells=40)
    way = route(np.array([0, 0, -50.0]), np.array([0, 0, 50.0]), [wall.distance], 2.0)
    assert wall.distance(way).min() > 1.0 and way[:, 1].min() < -17  # past the nearer side
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).sum() < 1.25 * 100
    start, end = np.array([0, 0, -50.0]), np.array([90.0, 40, 20])
    assert route(start, end, [], 2.0) == pytest.approx(np.array([start, end]))
    assert route(start, end * 9, [], 2.0) == pytest.approx(np.array([start, end * 9]))  # of larger cells


def test_a_path_that_jumps_through_a_bone_is_told():
    """Its places are outside, and the line between two of them is not."""
    path = np.array([[0, 0, -30.0], [0, 0, -16.0], [0, 0, 16.0], [0, 0, 30.0]])
    name, depth = deepest_in_bones(path, Tendon("end", path[-1], np.empty((0, 3)), 2.0), {"bone": ball(15.0)})
    assert name == "bone" and depth == pytest.approx(17.0, abs=0.2)
