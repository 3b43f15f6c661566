"""The importer reproduces the LHDL data folder from the upstream files, and refuses what it can't use."""

import hashlib
import json

import numpy as np
import pytest

import import_lhdl
from musclebench.lhdl import legacy_vtk, upstream
from musclebench.lhdl.closest_point import closest_on_mesh, closest_on_triangles
from musclebench.lhdl.hip_joint import axes_from_body_fixed_xyz
from musclebench.lhdl.mesh_quality import mesh_quality
from musclebench.lhdl.motions import read_motion

PUBLISHED = ["pelvis", "femur_r", "adductor_brevis_r", "gluteus_maximus_r", "gluteus_medius_r", "iliacus_r", "psoas_r"]


@pytest.fixture(scope="module")
def imported(lhdl_upstream, tmp_path_factory):
    out = tmp_path_factory.mktemp("import") / "lhdl"
    assert import_lhdl.main([str(lhdl_upstream), str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def both_descriptions(imported, lhdl_folder):
    return [json.loads((folder / "lhdl.json").read_text()) for folder in (imported, lhdl_folder)]


def test_the_pinned_digests_are_those_of_sha256sums(lhdl_upstream):
    published = dict(reversed(line.split()) for line in (lhdl_upstream / "SHA256SUMS").read_text().splitlines())
    assert set(upstream.SHA256) <= set(published)
    for name, digest in upstream.SHA256.items():
        assert published[name] == digest
        assert hashlib.sha256((lhdl_upstream / name).read_bytes()).hexdigest() == digest


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_meshes_are_reproduced_byte_for_byte(imported, lhdl_folder, name):
    ours, theirs = [(folder / "meshes" / f"{name}.ply").read_bytes() for folder in (imported, lhdl_folder)]
    assert ours == theirs


def test_the_decimated_adductor_brevis_has_the_given_triangles_and_vertices(imported, lhdl_folder):
    files = [folder / "meshes" / "adductor_brevis_r_502.ply" for folder in (imported, lhdl_folder)]
    ours, theirs = [_numbers(file, 502) for file in files]
    assert np.array_equal(ours[1], theirs[1])
    assert np.abs(ours[0] - theirs[0]).max() <= 5e-8  # single precision in millimetres, and VTK versions differ in it


def _numbers(path, vertex_count):
    body = path.read_bytes().split(b"end_header\n", 1)[1]
    return np.frombuffer(body, "<f8", 3 * vertex_count), np.frombuffer(body, "u1", offset=24 * vertex_count)


def test_joint_landmarks_and_fibres_equal_the_given_description(both_descriptions):
    ours, theirs = both_descriptions
    joint_keys = ["centre_m", "centre_m_child", "parent_axes_columns_xyz", "child_axes_columns_xyz"]
    for key in [*joint_keys, "scan_pose_coordinates_deg"]:
        assert ours["hip_joint"][key] == theirs["hip_joint"][key], key
    for axis in ("flexion", "adduction", "rotation"):
        assert ours["hip_joint"]["axes"][axis] == theirs["hip_joint"]["axes"][axis]
    for key in ("landmarks_m", "fibres", "units", "licence", "citations", "sources"):
        assert ours[key] == theirs[key], key


def test_motions_equal_the_given_description(both_descriptions):
    ours, theirs = both_descriptions
    assert set(ours["motions"]) == set(theirs["motions"])
    for name, motion in ours["motions"].items():
        for key in ("file", "frames", "columns", "rows"):
            assert motion[key] == theirs["motions"][name][key], (name, key)
    assert "note" in ours["motions"]["hip_flexion"]


def test_attachments_equal_the_given_description_where_upstream_has_the_finest_bone(both_descriptions):
    ours, theirs = both_descriptions
    assert len(ours["attachments"]) == len(theirs["attachments"])
    for mine, given in zip(ours["attachments"], theirs["attachments"]):
        coarser_femur = mine["muscle"] == "adductor_brevis_r" and mine["bone"] == "femur_r"
        compared = [key for key in given if not (coarser_femur and key == "points_m")]
        assert {key: mine.get(key) for key in compared} == {key: given[key] for key in compared}


def test_the_derived_femur_points_lie_in_the_area_of_the_given_ones(both_descriptions):
    ours, theirs = [np.array(d["attachments"][-1]["points_m"]) for d in both_descriptions]
    gaps = np.linalg.norm(ours[:, None] - theirs[None], axis=2).min(axis=1)
    assert len(ours) == 20 and gaps.max() < 0.006


def test_mesh_entries_and_counts_equal_the_given_description(both_descriptions):
    ours, theirs = both_descriptions
    given = {mesh["name"]: mesh for mesh in theirs["meshes"]}
    for mesh in ours["meshes"]:
        expected = given[mesh["name"]]
        for key in ("file", "kind", "set", "vertices", "triangles", "bbox_m", "upstream_files", "vertices_in_paper"):
            if key in expected:
                assert mesh[key] == expected[key], (mesh["name"], key)
        _compare_quality(mesh, expected)
    for mine, expected in zip(ours["meshes"][0]["parts"], given["pelvis"]["parts"]):
        assert {k: v for k, v in mine.items() if k != "quality"} == {k: expected[k] for k in mine if k != "quality"}
        _compare_quality(mine, expected)


def _compare_quality(mesh, expected):
    for key, value in mesh["quality"].items():
        if key in expected["quality"]:
            assert value == pytest.approx(expected["quality"][key], abs=1e-3), (mesh["name"], key)


def test_no_half_folder_is_left(imported):
    assert sorted(entry.name for entry in imported.parent.iterdir()) == ["lhdl"]


def test_an_existing_folder_is_kept_unless_forced(tmp_path, capsys):
    (tmp_path / "mine").write_text("keep")
    assert import_lhdl.main([str(tmp_path), str(tmp_path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "mine").read_text() == "keep"


def test_a_missing_upstream_file_is_named_in_one_line(tmp_path, capsys):
    assert import_lhdl.main([str(tmp_path), str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "415.vtk: not there" in error
    assert not list(tmp_path.iterdir())


def test_changed_upstream_bytes_are_refused(tmp_path, capsys):
    for name in upstream.SHA256:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"changed")
    assert import_lhdl.main([str(tmp_path), str(tmp_path / "out")]) == 2
    assert "SHA-256" in capsys.readouterr().err


def test_a_truncated_vtk_file_is_refused(tmp_path):
    path = tmp_path / "cut.vtk"
    path.write_bytes(b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n\0\0")
    with pytest.raises(upstream.ImportProblem, match="ends too early"):
        legacy_vtk.read_legacy_vtk(path)


def test_binary_and_ascii_vtk_files_read_alike(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], dtype=">f4")
    head = b"# vtk DataFile Version 3.0\nx\n%s\nDATASET POLYDATA\nPOINTS 3 float\n"
    cells = np.array([3, 0, 1, 2], dtype=">i4")
    (tmp_path / "b.vtk").write_bytes(head % b"BINARY" + points.tobytes() + b"\nPOLYGONS 1 4\n" + cells.tobytes())
    (tmp_path / "a.vtk").write_bytes(head % b"ASCII" + b"0 0 0 1 0 0\n0 1 0.5\nPOLYGONS 1 4\n3 0 1 2\n")
    for name in ("a.vtk", "b.vtk"):
        data = legacy_vtk.read_legacy_vtk(tmp_path / name)
        assert data.points.tolist() == points.tolist() and data.cells.tolist() == [[0, 1, 2]]


def test_closest_points_cover_every_region_of_a_triangle():
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    answers = {
        (0.2, 0.2, 1): (0.2, 0.2, 0), (-1, -1, 0): (0, 0, 0), (3, -1, 0): (1, 0, 0), (-1, 3, 0): (0, 1, 0),
        (0.5, -1, 0): (0.5, 0, 0), (-1, 0.5, 0): (0, 0.5, 0), (1, 1, 0): (0.5, 0.5, 0),
    }
    for point, expected in answers.items():
        assert closest_on_triangles(np.array(point), triangle)[0] == pytest.approx(expected)


def test_points_beyond_the_limit_have_infinite_distance():
    vertices, triangles = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    gaps, _ = closest_on_mesh(np.array([[0.2, 0.2, 0.1], [0.2, 0.2, 0.4]]), vertices, triangles, 0.3)
    assert gaps[0] == pytest.approx(0.1) and np.isinf(gaps[1])


def test_body_fixed_rotations_are_applied_in_the_order_x_y_z():
    axes = axes_from_body_fixed_xyz(np.radians([90.0, 90.0, 0.0]))
    assert axes[:, 0] == pytest.approx([0, 1, 0], abs=1e-12)  # x -> y turned first leaves x, y after it gives +y


def test_quality_counts_the_defects_of_a_small_mesh():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 5, 5]])
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    clean = mesh_quality(vertices, tetrahedron)
    assert clean["unreferenced_vertices"] == 1 and clean["boundary_edges"] == 0
    assert clean["euler_characteristic"] == 2 and clean["volume_ml"] == pytest.approx(1e6 / 6, abs=1e-3)
    flipped = tetrahedron.copy()
    flipped[0] = flipped[0, ::-1]
    assert mesh_quality(vertices, flipped)["edges_with_inconsistent_orientation"] == 3
    assert mesh_quality(vertices, tetrahedron[:3])["boundary_edges"] == 3


def test_a_motion_without_the_hip_columns_is_refused(tmp_path):
    (tmp_path / "x.mot").write_text("nRows=1\nendheader\ntime knee\n0 1\n")
    with pytest.raises(upstream.ImportProblem, match="hip_flexion_r"):
        read_motion(tmp_path / "x.mot", "x.mot")
