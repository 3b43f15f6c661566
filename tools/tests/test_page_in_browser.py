"""The page of results in a headless browser: it opens without a complaint, and what the mouse and the keyboard do."""

import re

import pandas as pd
import pytest

import fake_page
import fake_registry
from in_browser import told_by
from musclebench.page.page_file import write_page

pytestmark = pytest.mark.long
ROLES = fake_registry.roles()
TITLES = {backend.name: backend.title for backend in fake_registry.registry().backends}


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> dict:
    folder = tmp_path_factory.mktemp("browser")
    return told_by("page_in_browser.mjs", lambda: [write_page([
        fake_page.write_paper(folder / "paper"), fake_page.write_accuracy(folder / "accuracy"), fake_page.write_history(folder / "history.sqlite")]), folder])


def test_it_opens_without_a_complaint_and_asks_no_network(found):
    assert found["errors"] == []


def test_the_slider_moves_the_muscle(found):
    assert "frame 0," in found["start"]["words"] and "frame 6, joint at 90" in found["middle"]["words"]
    assert found["middle"]["lowest"] - found["start"]["lowest"] == pytest.approx(6e-3, abs=3e-5)
    assert found["middle"]["picture"] != found["start"]["picture"]


def test_a_click_on_a_node_tells_its_depth_and_distance(found):
    node = found["clicked"]
    assert node == found["spot"]["node"] and found["cellWidth"] > 200
    depth_mm = 1e3 * fake_page.snapshots()[2].depth_m[node]
    lines = [re.split(r"\t", line) for line in found["readout"].splitlines() if "\t" in line][1:]
    assert len(lines) == 4 and all(float(line[1]) == pytest.approx(depth_mm, abs=1e-3) for line in lines)
    assert all(float(line[2]) == pytest.approx(2 * depth_mm, abs=2e-3) for line in lines)  # of the surface around it
    moved = fake_page.snapshots()[2].vertices_m[node]
    ball = fake_page.BONES["pelvis"].vertices_m.mean(axis=0)
    assert {line[5] for line in lines} <= {"pelvis", "femur"} and all(0 <= float(line[4]) < 100 for line in lines)
    if lines[0][4] == "pelvis":  # a sphere of 30 mm
        away_mm = abs(1e3 * sum((moved - ball) ** 2) ** 0.5 - 30)
        assert float(lines[0][3]) == pytest.approx(away_mm, abs=1.0)


def test_colours_show_the_depth_of_nodes_or_of_the_surface(found):
    node, surface = ([float(text.split()[1]) for text in found["deepest"][kind]["words"]] for kind in ("node", "surface"))
    assert min(node) > 0 and surface == pytest.approx([2 * depth for depth in node], rel=1e-2)
    assert found["deepest"]["node"]["picture"] != found["deepest"]["surface"]["picture"]


def test_colours_show_the_pressure_on_bones(found):
    told = found["deepest"]["bone_pressure"]
    assert {float(text.split()[2]) for text in told["words"]} == {max(fake_page.PRESSED_PA.values())}
    assert told["picture"] not in {found["deepest"][kind]["picture"] for kind in ("node", "surface")}


def test_hovering_shows_what_the_file_holds(found):
    rows = pd.read_csv(pd.io.common.StringIO(found["file"]))
    frame = int(re.search(r"frame (\d+)", found["tip"])[1])
    told = {name: float(value) for name, value in re.findall(r"^([\w ]+): ([\d.]+)$", found["tip"], re.MULTILINE)}
    wanted = rows[(rows["muscle"] == "iliacus") & (rows["frame"] == frame)].set_index("backend")["collision_ms"].rename(TITLES)
    assert frame == 7 and told == pytest.approx(wanted.to_dict()) and len(told) == 3


def test_the_pareto_picture_tells_of_the_point_under_the_mouse(found):
    assert found["point"].splitlines()[:3] == [f"{ROLES.field} 64", "collision time a frame (ms): 0.3 (95 % interval 0.27 to 0.36)",
                                               "surface offset, 99th percentile (mm): 0.05"]
    assert "on the Pareto front" in found["point"] and "collision time a frame (ms): 0.6 " in found["pointOfOther"]
    assert found["bar"].splitlines()[0] == "self contact: 1.5 ms a frame"


def test_a_backend_is_clicked_away(found):
    assert set(found["shown"]) - set(found["without"]) == {found["shown"][0]} and found["cells"] == 3


def test_a_chart_whose_series_are_off_says_so(found):
    assert "switched off" in found["nothing"]


def test_the_keyboard_tells_what_a_backend_is(found):
    assert "no collision" in found["help"]


def test_it_prints_whole(found):
    assert found["printed"]["blank"] == [] and max(found["printed"]["widths"]) < 700
    assert len(found["printed"]["stills"]) == 1 and found["printed"]["stills"][0] > 0.05 and found["printed"]["after"] == 0


def test_depth_stands_on_a_log_axis(found):
    assert found["depth"]["type"] == "log" and found["depth"]["least"] >= 1e-3


def test_another_muscle_comes(found):
    assert found["muscle"] == "gluteus_medius"


def test_the_keyboard_does_what_the_mouse_does(found):
    assert found["turned"] and found["zoomed"] < 100
    assert "frame 1" in found["heard"] and f"{TITLES[ROLES.field]}: 3" in found["heard"]
    assert found["rowsBehind"] == 3 * fake_page.FRAMES


def test_a_change_point_is_told_by_mouse_and_keyboard(found):
    history = found["history"]
    night, value = fake_page.STEP_NIGHT, fake_page.night_value(fake_page.TREE, fake_page.STEP_NIGHT) / 1e6
    lines = history["tip"].splitlines()
    told = re.fullmatch(r"collision \(ms\): ([\d.]+) \(95 % interval ([\d.]+) to ([\d.]+)\)", lines[1])
    assert lines[0] == f"night 2026-01-{night:02}T02:00:00Z" and lines[2] == f"commit: commit{night}"
    assert [float(number) for number in told.groups()] == pytest.approx([value, 0.98 * value, 1.03 * value], rel=1e-3)
    assert "1.100 times (95 % 1.080 to 1.120), p 2e-06" in lines[3] and f"commit{night - 1}..commit{night}" in lines[4]
    assert lines[3].partition(": ")[2] in history["heard"] and history["marks"] == ["× 1.1"]


def test_another_case_and_figure_of_the_history_are_chosen(found):
    history = found["history"]
    assert history["shown"] == [fake_page.TREE, "collision_ns"] and "Changed in the night of 2026-01-09" in history["words"]
    assert history["otherWords"].startswith(f"{fake_page.BALL}, structure: ") and "No change was found" in history["otherWords"]
    assert history["otherAxis"] == "structure (MB)" and history["otherMarks"] == [] and history["rowsBehind"] == fake_page.NIGHTS


def test_it_fits_a_phone_and_a_dark_screen(found):
    assert found["phone"]["sideways"] <= 0 and found["dark"]["sideways"] <= 0
    assert found["phone"]["page"] != found["dark"]["page"]
