"""`field`: distance fields in files, as a user meets them."""

import json
import re
import resource
import struct

import pytest

from program import call, complaint, needs_program

pytestmark = needs_program


def test_writes_discregrids_format(folder):
    out = folder / "deep" / "box.cdf"
    done = call("field", folder / "scene.toml", "--param", "cells=8", "--out", out)
    assert done.returncode == 0, done.stderr
    assert "8 x 8 x 8" in done.stdout
    assert re.search(r"error near the surface +\d\.\d+ mm", done.stdout)
    content = out.read_bytes()
    lower, upper = struct.unpack_from("<3d", content, 0), struct.unpack_from("<3d", content, 24)
    assert all(low < -0.03 and high > 0.03 for low, high in zip(lower, upper, strict=True))
    assert struct.unpack_from("<3I", content, 48) == (8, 8, 8)
    cells, fields, lists, nodes = struct.unpack_from("<4Q", content, 108)
    assert (cells, fields, lists) == (512, 1, 1)
    assert nodes == 9**3 + 2 * 3 * 8 * 9 * 9
    values = struct.unpack_from(f"<{nodes}d", content, 140)
    assert values[0] > 0 and min(values) == pytest.approx(-0.03, abs=1e-3)
    assert list(out.parent.iterdir()) == [out]


def test_runs_use_the_field_in_place_of_building_one(folder):
    fields = folder / "fields"
    assert call("field", folder / "scene.toml", "--param", "cells=8", "--out", fields / "box.cdf").returncode == 0
    point = [*"probe --backend sdf --points 500".split()[1:], "--out", folder / "probe", "--force"]
    done = call("probe", folder / "scene.toml", *point, "--param", f"discregrid={fields}")
    assert done.returncode == 0, done.stderr
    (fields / "box.cdf").write_bytes((fields / "box.cdf").read_bytes()[:-1])
    done = call("probe", folder / "scene.toml", *point, "--param", f"discregrid={fields}")
    assert done.returncode == 2
    assert "box.cdf" in done.stderr and "truncated" in done.stderr and complaint(done).count("\n") == 1
    (fields / "box.cdf").unlink()
    done = call("probe", folder / "scene.toml", *point, "--param", f"discregrid={fields}")
    assert done.returncode == 2
    assert "cannot be read" in done.stderr and "leave out `discregrid`" in done.stderr


@pytest.mark.parametrize(("damage", "words"), [
    (lambda value: 1.87e304, "is damaged"),
    (lambda value: -value, "leave out `discregrid`"),
])
def test_refuses_a_field_with_one_damaged_node(folder, damage, words):
    fields = folder / "fields"
    assert call("field", folder / "scene.toml", "--param", "cells=9", "--out", fields / "box.cdf").returncode == 0
    content = bytearray((fields / "box.cdf").read_bytes())
    middle = 140 + 8 * (4 * 10 * 10 + 4 * 10 + 4)
    struct.pack_into("<d", content, middle, damage(struct.unpack_from("<d", content, middle)[0]))
    (fields / "box.cdf").write_bytes(content)
    done = call("probe", folder / "scene.toml", "--backend", "sdf", "--out", folder / "probe", "--param",
                f"discregrid={fields}")
    assert done.returncode == 2
    assert "box.cdf" in done.stderr and words in done.stderr and complaint(done).count("\n") == 1


@pytest.mark.parametrize(("cells", "words"), [("cells=2000", "sdf: cells: needs"),
                                              ("cell_size_m=0.00003", "sdf: cell_size_m: needs")])
def test_says_what_fits_where_memory_is_short(folder, cells, words):
    gigabyte = 10**9
    done = call("field", folder / "scene.toml", "--param", cells, "--out", folder / "box.field",
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (gigabyte, gigabyte)))
    assert done.returncode == 2
    assert words in done.stderr and "fit" in done.stderr and complaint(done).count("\n") == 1


def test_leaves_nothing_where_the_file_may_not_grow_so_large(folder):
    out = folder / "deep" / "box.field"
    done = call("field", folder / "scene.toml", "--param", "cells=32", "--out", out,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10**5, 10**5)))
    assert done.returncode == 2
    assert "box.field: cannot be written" in done.stderr and complaint(done).count("\n") == 1
    assert not list(out.parent.iterdir())


def test_writes_the_adaptive_field_that_a_backend_keeps(folder):
    out, kept = folder / "box-0.2mm.octree", folder / "structures"
    done = call("field", folder / "scene.toml", "--param", "max_error_mm=0.2", "--out", out, "--threads", "2")
    assert done.returncode == 0, done.stderr
    error_mm = float(re.search(r"surface +(\d\.\d+) mm", done.stdout).group(1))
    assert 0 < error_mm <= 0.2
    manifests = []
    for name in ("first", "second"):
        done = call("probe", folder / "scene.toml", "--backend", "sdf", "--param", "max_error_mm=0.2", "--param",
                    f"structures={kept}", "--points", "500", "--out", folder / name)
        assert done.returncode == 0, done.stderr
        manifests.append(json.loads((folder / name / "run.json").read_text()))
    field, note = sorted(kept.iterdir())
    assert field.read_bytes() == out.read_bytes() and note.name == field.name + ".json"
    assert [one["structures"] for one in manifests] == ["built", "loaded"]
    assert [one["kept_build_ns"] for one in manifests] == [None, json.loads(note.read_text())["build_ns"]]


def test_reports_progress_in_lines(folder):
    done = call("field", folder / "scene.toml", "--param", "cells=48", "--out", folder / "box.field", "--progress")
    assert done.returncode == 0
    assert all(line.split()[0] == "progress" for line in complaint(done).splitlines())


@pytest.mark.parametrize(("arguments", "words"), [
    (["--out", "box.vdb"], "has to end in .cdf or .field"),
    (["--out", "box.cdf", "--param", "max_error_mm=0.1"], "has to end in .octree"),
    (["--out", "box.octree", "--param", "max_error_mm=0.1", "--param", "cell_size_m=0.01"], "leave out this"),
    (["--out", "box.octree", "--param", "max_error_mm=500"], "makes sense"),
    (["--out", "box.octree", "--param", "max_error_mm=1e-9"], "makes sense"),
    (["--out", "box.field", "--bone", "femur"], "has the bones box"),
    (["--out", "box.field", "--backend", "bvh"], "has no distance field"),
    (["--out", "box.field", "--param", "discregrid=here"], "leave it out to build one"),
])
def test_refuses_bad_input_with_one_line_and_writes_nothing(folder, arguments, words):
    arguments = [str(folder / word) if word.startswith("box.") else word for word in arguments]
    done = call("field", folder / "scene.toml", *arguments)
    assert done.returncode == 2
    assert words in done.stderr and complaint(done).count("\n") == 1
    assert not list(folder.glob("box.[!o]*")) or list(folder.glob("box.*")) == [folder / "box.off"]
