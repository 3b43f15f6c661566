"""What the importer reads of files, mends and decimates."""

import numpy as np
import pytest

from anatomy_shapes import WRITERS, ball, write
from musclebench.anatomy.mesh_file import mend, open_edges, read_mesh
from musclebench.anatomy.resolution import decimated
from musclebench.anatomy.self_crossings import crossing_triangles
from musclebench.anatomy.surface import Surface, largest_gap, merged
from musclebench.program.cli import Problem
from program import needs_native_module

pytestmark = needs_native_module


def test_every_triangle_faces_outward():
    sound, other = ball(10), ball(8, (40, 0, 0))
    mixed = sound.triangles.copy()
    mixed[::3] = mixed[::3, ::-1]
    mended = mend(Surface(sound.vertices, mixed), "mixed")
    assert mended.surface.volume == pytest.approx(sound.volume) and mended.repairs == [f"{len(mixed[::3])} triangles turned outward"]
    inverted = merged([sound, Surface(other.vertices, other.triangles[:, ::-1])])
    assert mend(inverted, "two").surface.volume == pytest.approx(sound.volume + other.volume)


def test_what_an_export_rounds_is_one_vertex_and_nothing_is_no_surface():
    sound = ball(10)
    apart = Surface(sound.corners.reshape(-1, 3) + np.random.default_rng(1).uniform(-1e-6, 1e-6, (3 * len(sound.triangles), 3)),
                    np.arange(3 * len(sound.triangles)).reshape(-1, 3))
    assert len(mend(apart, "apart").surface.vertices) == len(sound.vertices)
    many = merged([ball(1, (5 * i, 0, 0), 8) for i in range(60)])
    assert mend(many, "many").surface.volume == pytest.approx(60 * ball(1, cells=8).volume)
    with pytest.raises(Problem, match="encloses no volume|is open"):
        mend(Surface(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 1]])), "sheet")


@pytest.mark.parametrize("suffix", WRITERS)
def test_all_formats_are_read_alike(tmp_path, suffix):
    surface = mend(read_mesh(write(ball(12.5, (1, 2, 3)), tmp_path / f"ball{suffix}")), "ball").surface
    assert open_edges(surface) == 0 and len(surface.vertices) == len(ball(cells=24).vertices)
    assert surface.volume == pytest.approx(ball(12.5).volume, rel=1e-5)


def test_meshes_are_mended():
    sound = ball(10)
    with_debris = merged([sound, ball(0.5, (30, 0, 0)), Surface(sound.vertices, sound.triangles[:1])])
    mended = mend(with_debris, "ball")
    assert mended.surface.volume == pytest.approx(sound.volume, rel=1e-9) and len(mended.repairs) == 2
    (a, b, _), tip = sound.triangles[0], len(sound.vertices)
    folded = Surface(np.concatenate([sound.vertices, [[0, 0, 11.0]]]), np.concatenate([sound.triangles, [[a, b, tip], [b, a, tip]]]))
    assert open_edges(mend(folded, "fold").surface) == 0 and mend(folded, "fold").surface.volume == pytest.approx(sound.volume, rel=1e-9)
    hole = mend(Surface(sound.vertices, sound.triangles[1:]), "ball")
    assert open_edges(hole.surface) == 0 and "holes closed" in hole.repairs[0] and hole.surface.volume == pytest.approx(sound.volume, rel=1e-3)
    with pytest.raises(Problem, match="is open"):
        mend(Surface(sound.vertices, sound.triangles[sound.corners.mean(axis=1)[:, 2] > 0]), "half")


def test_decimation_keeps_the_wanted_error():
    fine = ball(20, cells=60)
    for error in (0.05, 0.5):
        coarse, told = decimated(fine, error)
        assert told <= error and told == pytest.approx(largest_gap(fine, coarse)) and open_edges(coarse) == 0
        # By the shape itself: no point of either is farther than told from a sphere, but for the fine mesh's own chords.
        off = np.abs(np.linalg.norm(coarse.corners.mean(axis=1), axis=1) - 20).max()
        assert error / 10 < off <= error + 0.03
    assert len(coarse.triangles) < len(decimated(fine, 0.05)[0].triangles) < len(fine.triangles)


def test_triangles_that_pass_through_others_are_counted():
    assert len(crossing_triangles(ball(10))) == 0
    assert len(crossing_triangles(merged([ball(10), ball(10, (5, 0, 0))]))) > 20
    fan = Surface(np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1.0]]), np.array([[0, 1, 2], [0, 3, 4]]))
    assert len(crossing_triangles(fan)) == 2  # they share a vertex, and pass elsewhere
    fan.vertices[3:] -= [3, 3, 0]
    assert len(crossing_triangles(fan)) == 0
