"""`check --trial` and `effects = "auto"` with [wanted] find the effects that a scene takes, and what they promise holds in a run
that is judged in every frame."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from musclebench.cases.project_scenes import project_scenes

from ball_on_box import SCENE, ball, box, off
from program import call, complaint, needs_program

pytestmark = needs_program
DATASETS = Path(__file__).resolve().parents[2] / "datasets"
KNEE, SCENES = DATASETS / "examples" / "knee.py", DATASETS / "scenes"
WANTED = '[wanted]\nsurface_mm = 0.1\n'


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "box.off").write_text(off(*box(0.02)))
    (tmp_path / "ball.off").write_text(off(*ball(0.01, [0, 0, 0.0305])))
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def tried(scene, *options) -> dict:
    done = call("check", scene, "--trial", "--json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["trial"]


def run(scene, out, *options) -> dict:
    done = call("run", scene, "--backend", "bvh", "--out", out, "--force", *options)
    assert done.returncode == 0, done.stderr
    return json.loads((out / "run.json").read_text())


def test_what_a_trial_finds_is_written_and_holds_in_a_run_of_its_own(tmp_path):
    found = tried("effects/no_passage", "--no-effect", "no_passage", "--out", tmp_path / "found.toml")
    assert [one["effect"] for one in found["added_effects"]] == ["no_passage"] and found["unmet"] == []
    assert "# Added [trial]: when it was tried, without it" in (tmp_path / "found.toml").read_text()
    assert all(one["holds"] for one in found["figures"])
    with_it = run(tmp_path / "found.toml", tmp_path / "with")
    without = run("effects/no_passage", tmp_path / "without", "--no-effect", "no_passage")
    assert with_it["status"] == "ok" and without["status"] == "suspect"
    assert with_it["outcome"]["muscle_crossing_triangles"] == 0 < without["outcome"]["muscle_crossing_triangles"]


def test_a_trial_is_told_in_words(tmp_path):
    done = call("check", "effects/self_contact", "--trial", "--no-effect", "self_contact")
    assert done.returncode == 0, done.stderr
    for words in ["wanted: depth 0.1 mm", "as it is: ", "+ self_contact: holds all that is wanted",
                  "added self_contact [trial]: when it was tried, without it", "needless attachment: ", "holds all that is wanted"]:
        assert words in done.stdout, words


def test_a_scene_that_says_what_it_wants_is_asked_when_it_runs(folder):
    """The box turns under the ball at 15 m/s: its nodes are through before contact sees them."""
    text = SCENE.replace("to_deg = 20", "to_deg = 80").replace("[effects.gravity]", WANTED + "[effects]\nauto = true\n[effects.gravity]")
    (folder / "scene.toml").write_text(text)
    told = run(folder / "scene.toml", folder / "out")
    found = tried(folder / "scene.toml")
    assert told["added_effects"] == found["added_effects"]
    assert ("wanted" in {warning["rule"] for warning in told["warnings"]}) == bool(found["unmet"])
    again = run(folder / "out" / "resolved_scene.toml", folder / "again")
    assert again["state_hash"] == told["state_hash"]


@pytest.fixture
def asking(folder, monkeypatch):
    """A scene that asks for effects, and a cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    (folder / "scene.toml").write_text(SCENE.replace("to_deg = 20", "to_deg = 80").replace(
        "[effects.gravity]", WANTED + "[effects]\nauto = true\n[effects.gravity]"))
    return folder


def searched(folder, *options, out="out") -> tuple[bool, dict]:
    """Whether a run with `sdf` looked for effects itself, and its run.json."""
    done = call("run", folder / "scene.toml", "--backend", "sdf", "--out", folder / out, *options)
    assert done.returncode == 0, done.stderr
    return "an earlier search" not in done.stderr, json.loads((folder / out / "run.json").read_text())


def same_but_for_times(told) -> dict:
    return {key: told[key] for key in ("run_id", "status", "status_detail", "warnings", "added_effects", "state_hash")}


def test_what_a_search_found_is_kept_for_the_next_run_of_the_scene(asking):
    first, told = searched(asking)
    again, same = searched(asking, out="again")
    forced, anew = searched(asking, "--force")
    assert (first, again, forced) == (True, False, True)
    assert same_but_for_times(same) == same_but_for_times(told) == same_but_for_times(anew)
    (asking / "scene.toml").write_text((asking / "scene.toml").read_text().replace("to_deg = 80", "to_deg = 70"))
    assert searched(asking, out="other")[0]


def write_without(folder, effect):
    """The scene that shows the effect, which a search has to add."""
    text = project_scenes()[f"effects/{effect}"].read_text().partition(f"[effects.{effect}]")[0]
    (folder / "scene.toml").write_text(text + "[effects]\nauto = true\n" + WANTED)


@pytest.mark.parametrize("effect", ["self_contact", "tunnelling_guard"])
def test_what_was_kept_gives_the_same_run(asking, effect):
    write_without(asking, effect)
    _, told = searched(asking)
    again, same = searched(asking, out="again")
    assert not again and effect in [one["effect"] for one in told["added_effects"]]
    assert same_but_for_times(same) == same_but_for_times(told)
    assert (asking / "again/resolved_scene.toml").read_text() == (asking / "out/resolved_scene.toml").read_text()


def spike_that_pokes_once(folder: Path) -> Path:
    """A ball hangs on a plate. A needle pokes into one of its faces in frame 33 of 120, and nowhere near a node."""
    vertices, triangles = ball(0.01, [0, 0, 0], rings=30, around=36)
    face = vertices[[1 + 14 * 36, 2 + 14 * 36, 2 + 15 * 36]].mean(axis=0)
    tip, out = face * (1 + 3e-4 / np.linalg.norm(face)), face / np.linalg.norm(face)
    corners = [tip + 0.02 * out + 3e-3 * np.array([0, y, z]) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    (folder / "ball.off").write_text(off(vertices, triangles))
    (folder / "needle.off").write_text(off([tip, *corners], [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4), (1, 2, 3), (1, 3, 4)]))
    (folder / "plate.off").write_text(off(*(part if i else part + [0, 0, 0.0255] for i, part in enumerate(box(0.015)))))
    rows = "".join(f"{row}\t{-0.1 if row == 33 else 0}\n" for row in range(121))
    (folder / "poke.mot").write_text("poke\nversion=1\nnRows=121\nnColumns=2\ninDegrees=yes\nendheader\ntime\tangle\n" + rows)
    (folder / "scene.toml").write_text(f"""title = "a needle pokes a ball once"
[[bone]]
name = "plate"
mesh = "plate.off"
[[bone]]
name = "needle"
mesh = "needle.off"
[bone.motion]
axis = [0, 1, 0]
centre_m = [{tip[0]}, 0, -0.5]
table = "poke.mot"
column = "angle"
course = "there"
[muscle]
name = "ball"
mesh = "ball.off"
[[attachment]]
name = "hold"
bone = "plate"
distance_m = 0.003
outline_m = [[-0.01, -0.01, 0.0105], [0.01, -0.01, 0.0105], [0.01, 0.01, 0.0105], [-0.01, 0.01, 0.0105]]
[effects]
auto = true
[effects.edge_length]
[effects.bending]
[effects.volume]
[effects.damping]
[loop]
frames = 120
substeps = 2
{WANTED}""")
    return folder / "scene.toml"


def test_what_trials_did_not_look_at_is_searched_for_again(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    scene = spike_that_pokes_once(tmp_path)
    done = call("run", scene, "--backend", "bvh", "--out", tmp_path / "out")
    assert done.returncode == 0 and "all frames now" in done.stderr, done.stderr
    told = json.loads((tmp_path / "out" / "run.json").read_text())
    assert told["status"] == "ok" and "surface_contact" in [one["effect"] for one in told["added_effects"]], told["status_detail"]
    again = call("run", scene, "--backend", "bvh", "--out", tmp_path / "again")
    assert "all frames now" not in again.stderr
    assert json.loads((tmp_path / "again" / "run.json").read_text())["state_hash"] == told["state_hash"]


@pytest.mark.parametrize(("options", "word"), [
    (["--for", "no_bone=bvh"], "no_bone"),
    (["--response", "nonsense"], "nonsense"),
    (["--backend", "bvh", "--response", "backtrack"], "backtrack"),
    (["--out", "taken"], "taken"),
])
def test_a_command_that_can_not_run_says_so_before_it_searches(asking, options, word):
    (asking / "taken").write_text("a file")
    options = [*options, *(["--backend", "sdf"] if "--backend" not in options else []), *(["--out", "out"] if "--out" not in options else [])]
    done = call("run", "scene.toml", *options, cwd=asking)
    assert done.returncode == 2 and word in complaint(done)
    assert not (asking / "cache").exists()


def test_an_option_may_name_what_a_search_adds(asking):
    write_without(asking, "surface_contact")
    scene = asking / "scene.toml"
    scene.write_text(scene.read_text().replace("auto = true", "auto = true\nno_passage = false\ntunnelling_guard = false"))
    done = call("run", "scene.toml", "--backend", "sdf", "--for", "faces=bvh", "--out", "out", cwd=asking)
    assert done.returncode == 0 and "added surface_contact" in done.stderr, done.stderr


def flying_muscles(folder: Path, wanted: str = "") -> Path:
    """A scene in which two balls are in each other in one frame of ten."""
    for name, x in (("left", -0.0195), ("right", 0.0195)):
        (folder / f"{name}.off").write_text(off(*ball(0.01, [x, 0, 0.5])))
    text = SCENE.partition("[bone.motion]")[0]
    for name, speed in (("left", 20), ("right", -20)):
        text += f'[[muscle]]\nname = "{name}"\nmesh = "{name}.off"\nvelocity_m_per_s = [{speed}, 0, 0]\n'
    (folder / "scene.toml").write_text(f"{text}[loop]\nframes = 10\nsubsteps = 1\n[effects.edge_length]\n[effects.volume]\n{wanted}")
    return folder / "scene.toml"


@pytest.mark.parametrize("threads", ["1", "2"])
def test_muscles_that_fly_through_each_other_are_seen(folder, threads):
    told = run(flying_muscles(folder), folder / "out", "--threads", threads)
    assert told["status"] == "suspect" and "pass through right" in told["status_detail"]


@pytest.mark.parametrize("threads", ["1", "2"])
def test_muscles_that_fly_through_each_other_miss_what_is_wanted(folder, threads):
    scene = flying_muscles(folder, "[wanted]\nnothing_passes = true\n")
    told = run(scene, folder / "out", "--threads", threads)
    assert told["status"] == "suspect" and "wanted 0" in told["status_detail"]
    assert not all(one["holds"] for one in tried(scene, "--no-effect", "volume")["figures"])


@pytest.mark.parametrize(("wanted", "words"), [("returns_mm = 1", "bones do not come back"), ("volume_percent = 1", "no muscle has a closed")])
def test_a_wish_that_can_not_be_judged_is_not_ok(folder, wanted, words):
    text = SCENE.replace("to_deg = 20", 'to_deg = 20\ncourse = "there"').replace("[effects.volume]\n", "")
    (folder / "scene.toml").write_text(text + f"[wanted]\n{wanted}\n")
    vertices, triangles = ball(0.01, [0, 0, 0.0305])
    (folder / "ball.off").write_text(off(vertices, triangles[1:]))
    told = run(folder / "scene.toml", folder / "out")
    assert told["status"] == "suspect" and words in told["status_detail"]
    assert any(words in one["what"] for one in tried(folder / "scene.toml")["unmet"])


@pytest.mark.parametrize("surface_mm", [0.1, 50])
def test_what_binds_a_muscle_stays_whatever_is_wanted(folder, surface_mm):
    """The bone is back in the middle and at the end, and moves the muscle by less than 50 mm."""
    rows = "".join(f"{row}\t{angle}\n" for row, angle in enumerate([0, 15, 0, -15, 0]))
    (folder / "swing.mot").write_text("swing\nversion=1\nnRows=5\nnColumns=2\ninDegrees=yes\nendheader\ntime\tangle\n" + rows)
    text = SCENE.replace("from_deg = 0\nto_deg = 20\n", 'table = "swing.mot"\ncolumn = "angle"\n').replace("frames = 12", "frames = 24")
    text = text.replace("[effects.gravity]", f"[wanted]\nsurface_mm = {surface_mm}\n[effects]\nauto = true")
    (folder / "scene.toml").write_text(text + '[[attachment]]\nname = "hold"\nbone = "box"\ndistance_m = 0.008\n'
                                       "outline_m = [[-0.02, -0.02, 0.02], [0.02, -0.02, 0.02], [0.02, 0.02, 0.02], [-0.02, 0.02, 0.02]]\n")
    told = run(folder / "scene.toml", folder / "out")
    assert "attachment" in [one["effect"] for one in told["added_effects"]]


def test_a_run_that_nobody_judges_says_that_wishes_are_not_looked_at(asking):
    done = call("run", asking / "scene.toml", "--backend", "sdf", "--out", asking / "out", "--no-referee")
    assert done.returncode == 0 and "what is wanted is not looked at" in done.stderr
    told = json.loads((asking / "out" / "run.json").read_text())
    assert told["status"] == "ok" and any("not looked at" in one["text"] for one in told["warnings"])


def test_a_run_that_misses_what_its_scene_wants_is_suspect(folder):
    (folder / "scene.toml").write_text(SCENE + "[wanted]\nreturns_mm = 0.001\n")
    told = run(folder / "scene.toml", folder / "out")
    assert told["status"] == "suspect" and "ball ends" in told["status_detail"] and "wanted 0.001 mm" in told["status_detail"]
    (folder / "scene.toml").write_text(SCENE + "[wanted]\nreturns_mm = 1000\nsurface_mm = 100\nvolume_percent = 50\n")
    assert run(folder / "scene.toml", folder / "out")["status"] == "ok"


@pytest.mark.parametrize(("command", "words"), [
    (["check", "scene.toml", "--out", "found.toml"], ["--out", "--trial"]),
    (["check", "scene.toml", "--wanted", "surface_mm=1"], ["--wanted", "--trial"]),
    (["check", "scene.toml", "--trial", "--wanted", "surface=1"], ["surface", "surface_mm"]),
    (["check", "scene.toml", "--trial", "--wanted", "surface_mm=0"], ["--wanted", "surface_mm", "0"]),
    (["check", "box.off", "--trial"], ["box.off", "--trial"]),
    (["check", "scene.toml", "--trial", "--out", "scene.toml"], ["--out scene.toml", "is the scene itself"]),
    (["check", "scene.toml", "--trial", "--out", "nowhere/found.toml"], ["nowhere/found.toml", "does not exist"]),
    (["check", "scene.toml", "--trial", "--out", "box.off"], ["--out box.off", ".toml"]),
    (["record", "asked.toml", "--backend", "bvh", "--out", "x.recording"], ["asked.toml", "check asked.toml --trial --out"]),
])
def test_what_makes_no_sense_is_refused(folder, command, words):
    (folder / "asked.toml").write_text(SCENE.replace("[effects.gravity]", WANTED + "[effects]\nauto = true\n[effects.gravity]"))
    before = sorted(folder.iterdir())
    done = call(*command, cwd=folder)
    assert done.returncode == 2, done.stdout
    assert all(word in complaint(done) for word in words), done.stderr
    assert sorted(folder.iterdir()) == before


def test_a_check_of_such_a_scene_says_who_chooses(folder):
    (folder / "scene.toml").write_text(SCENE.replace("[effects.gravity]", WANTED + "[effects]\nauto = true\n[effects.gravity]"))
    assert "--trial shows which" in call("check", "scene.toml", cwd=folder).stdout


@pytest.mark.long
def test_a_strangers_meshes_are_asked(tmp_path):
    """OBJ, STL and PLY in millimetres and metres: what the trial says holds is what the judge of the run finds."""
    subprocess.run([sys.executable, str(KNEE), "knee"], cwd=tmp_path, check=True, capture_output=True)
    scene = next(tmp_path.rglob("*.toml"))
    found = tried(scene, "--out", tmp_path / "found.toml", "--wanted", "surface_mm=0.2")
    told = run(tmp_path / "found.toml", tmp_path / "out")
    depths_m = [one["value"] for one in found["figures"] if one["requirement"] == "bone_depth"]
    assert depths_m and told["outcome"]["max_surface_depth_m"] == pytest.approx(depths_m[0], abs=1e-4)
    assert {one["what"] for one in found["unmet"]} == {one["text"] for one in found["figures"] if not one["holds"]}
    assert (told["status"] == "ok") == (found["unmet"] == []), told["status_detail"]
