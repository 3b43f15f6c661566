"""Query sets as a library's author meets them: read without the program, answered without it, judged by it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ball_on_box import write_scene
from program import call, complaint, needs_program

pytestmark = needs_program

READERS = Path(__file__).resolve().parents[2] / "datasets" / "queries"
sys.path.append(str(READERS))
from query_set import read_query_set  # noqa: E402

FRAMES = 10


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    done = call("record", write_scene(folder), "--frames", FRAMES, "--out", folder / "ball.steps")
    assert done.returncode == 0, done.stderr
    return folder / "ball.steps"


@pytest.fixture(scope="module")
def written(recording) -> Path:
    file = recording.with_suffix(".queries")
    done = call("queries", recording, "--out", file, "--moments", 5, "--steps", 2, "--around", 100)
    assert done.returncode == 0, done.stderr
    return file


def distances_m(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Unsigned, to every triangle: its face where the foot of the perpendicular lies in it, else its edges."""
    def to_edges(a, b):
        ab = b - a
        share = np.clip(np.einsum("pti,ti->pt", points[:, None] - a, ab) / np.einsum("ti,ti->t", ab, ab), 0, 1)
        return np.linalg.norm(points[:, None] - a - share[..., None] * ab, axis=2)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nearest = np.minimum(np.minimum(to_edges(a, b), to_edges(b, c)), to_edges(c, a))
    height = np.einsum("pti,ti->pt", points[:, None] - a, normals)
    foot = points[:, None] - height[..., None] * normals
    within = np.all([np.einsum("pti,ti->pt", np.cross(end - start, foot - start), normals) >= 0
                     for start, end in ((a, b), (b, c), (c, a))], axis=0)
    return np.where(within, np.minimum(np.abs(height), nearest), nearest).min(axis=1)


def solid_angles(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Winding numbers (Van Oosterom and Strackee 1983)."""
    a, b, c = (vertices[triangles[:, corner]] - points[:, None] for corner in range(3))
    la, lb, lc = (np.linalg.norm(one, axis=2) for one in (a, b, c))
    over = np.einsum("pti,pti->pt", a, np.cross(b, c))
    under = la * lb * lc + sum(np.einsum("pti,pti->pt", one, other) * length
                               for one, other, length in ((a, b, lc), (b, c, la), (c, a, lb)))
    return np.arctan2(over, under).sum(axis=1) / (2 * np.pi)


def test_answers_are_those_of_a_program_of_ten_lines(written):
    found = read_query_set(written)
    (vertices, triangles), = found.bones.values()
    arrays = found.arrays
    points = arrays["points_m"]
    assert len(points) > 200 and "recorded with bvh" in found.about
    unsigned = distances_m(vertices, triangles, points)
    assert np.abs(unsigned - np.abs(arrays["distances_m"])).max() < 1e-12
    clear = unsigned > 1e-6
    inside = solid_angles(vertices, triangles, points) > 0.5
    assert (inside == (arrays["distances_m"] < 0))[clear].all() and inside.any() and not inside.all()
    assert np.abs(np.linalg.norm(points - arrays["closest_m"], axis=1) - unsigned).max() < 1e-12
    around = arrays["difficulty"] == 5
    assert around.sum() == 100 and (arrays["node"][around] == -1).all() and set(arrays["bone"]) == {0}
    assert np.abs(arrays["distances_m"][~around]).max() <= 0.01


def test_queries_of_a_node_follow_each_other(written):
    arrays = read_query_set(written).arrays
    arrays = {name: values[arrays["node"] >= 0] for name, values in arrays.items()}
    assert (np.diff(arrays["step"]) >= 0).all() and len(set(arrays["step"])) == 10
    of_node = arrays["step"][arrays["node"] == arrays["node"][0]]
    assert len(of_node) == len(set(of_node))
    assert set(np.diff(sorted(set(arrays["step"])))) >= {1}


def test_of_too_many_queries_whole_nodes_are_left_out(recording, written, tmp_path):
    done = call("queries", recording, "--out", tmp_path / "few", "--moments", 5, "--steps", 2, "--queries", 100, "--around", 0)
    assert done.returncode == 0, done.stderr
    few, every = read_query_set(tmp_path / "few").arrays, read_query_set(written).arrays
    assert 50 < len(few["node"]) <= 130
    for node in set(few["node"]):
        assert (few["step"][few["node"] == node] == every["step"][every["node"] == node]).all()


def test_exact_backends_agree_and_a_wrong_set_is_told(written, tmp_path):
    done = call("queries", "--check", written)
    assert done.returncode == 0 and done.stdout.rstrip().endswith("held"), done.stdout + done.stderr
    assert "bvh" in done.stdout and "brute_force" in done.stdout
    data = bytearray(written.read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "changed").write_bytes(data)
    (tmp_path / "cut").write_bytes(written.read_bytes()[:-200])
    (tmp_path / "head").write_bytes(written.read_bytes()[:60])
    (tmp_path / "other").write_text("musclebench recording 1\n")
    for name, words in (("changed", "hash"), ("cut", "cut off"), ("head", "cut off"), ("other", "version 1"), ("none", "cannot be read")):
        done = call("queries", "--check", tmp_path / name)
        assert done.returncode == 2 and words in done.stderr and len(complaint(done).splitlines()) == 1, done.stderr


def test_a_distance_that_is_wrong_by_a_nanometre_is_not_held(written, tmp_path):
    """With a hash of its own: somebody else's program wrote it."""
    import hashlib
    data = written.read_bytes()[:-72]
    queries = len(read_query_set(written).arrays["bone"])
    start = len(data) - queries * (8 + 4 * 4)
    distances = np.frombuffer(data[start:start + 8 * queries], "<f8").copy()
    distances[0] += 1e-9
    data = data[:start] + distances.tobytes() + data[start + 8 * queries:]
    (tmp_path / "off").write_bytes(data + b"sha256 " + hashlib.sha256(data).hexdigest().encode() + b"\n")
    done = call("queries", "--check", tmp_path / "off")
    assert done.returncode == 1 and "NOT held" in done.stdout, done.stdout + done.stderr


def test_answers_are_judged_by_bone_and_difficulty(written, tmp_path):
    truth = read_query_set(written).arrays["distances_m"]
    answers = truth + 1e-4
    answers[0], answers[1] = np.nan, -truth[1]
    answers.astype("<f8").tofile(tmp_path / "mine.f64")
    done = call("queries", "--check", written, "--answers", tmp_path / "mine.f64")
    assert done.returncode == 0, done.stderr
    row = done.stdout.splitlines()[-1].split()
    assert row[0] == "all" and int(row[1]) == len(truth) and row[2] == "1" and int(row[3]) >= 1
    assert float(row[4]) == pytest.approx(0.1, rel=0.01) and float(row[5]) >= 0.1
    answers[:-1].tofile(tmp_path / "short.f64")
    done = call("queries", "--check", written, "--answers", tmp_path / "short.f64")
    assert done.returncode == 2 and "one double a query" in done.stderr


def test_the_reader_for_cpp_needs_nothing_else(written, tmp_path):
    (tmp_path / "read.cpp").write_text(
        '#include <iostream>\n#include "query_set.hpp"\n'
        "int main(int, char** argv) {\n  const QuerySet set = read_query_set(argv[1]);\n"
        "  std::cout << set.bones.size() << ' ' << set.bone.size() << ' ' << set.distances_m.back() << '\\n';\n}\n")
    subprocess.run(["c++", "-std=c++17", "-Wall", "-Werror", f"-I{READERS}", tmp_path / "read.cpp", "-o", tmp_path / "read"], check=True)
    done = subprocess.run([tmp_path / "read", written], capture_output=True, text=True, check=True)
    arrays = read_query_set(written).arrays
    bones, queries, last = done.stdout.split()
    assert (int(bones), int(queries)) == (1, len(arrays["bone"])) and float(last) == pytest.approx(arrays["distances_m"][-1], rel=1e-5)


@pytest.mark.parametrize("words, cure", [((), "--check FILE"), (("a.steps",), "--out"), (("a.steps", "--check", "b"), "--check FILE")])
def test_what_is_missing_is_said(words, cure):
    done = call("queries", *words)
    assert done.returncode == 2 and cure in done.stderr and len(complaint(done).splitlines()) == 1
