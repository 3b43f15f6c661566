"""The board in a headless browser: what the slider, the keyboard and the address do."""

from pathlib import Path

import pytest

import fake_page
from in_browser import told_by
from musclebench.board.bundle import Bundle
from musclebench.board.made import bundle_of
from musclebench.board.site import write_site
from musclebench.page import bundle
from musclebench.page.sections import sections_of
from musclebench.page.views import Views
from published_bundle import PUBLISHED

pytestmark = pytest.mark.long
SCENE = "synthetic/iliacus"


def with_shapes(published: Bundle, folder: Path) -> Bundle:
    sections = sections_of([fake_page.write_paper(folder)])
    views = next(part for section in sections for part in section.parts if isinstance(part, Views))
    return Bundle(published.header, published.rows, {SCENE: views.data})


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> dict:
    folder = tmp_path_factory.mktemp("board")

    def make() -> list[Path | str]:
        write_site([with_shapes(bundle_of(PUBLISHED), folder / "paper")], [], folder / "board")
        return [folder / "board", folder, "scenes/synthetic-iliacus.html"]

    return told_by("board_in_browser.mjs", make)


def test_it_opens_without_a_complaint_and_asks_no_network(found):
    assert found["errors"] == [] and found["first"]["drawn"] > 40


def test_a_page_loads_only_what_it_draws(found, tmp_path):
    scripts = {name: bundle.page_script(entry=name) for name in (bundle.BOARD, bundle.SHAPES)}
    assert "WebGLRenderer" not in scripts[bundle.BOARD] and "WebGLRenderer" in scripts[bundle.SHAPES]
    assert len(scripts[bundle.BOARD]) < 750_000


def test_the_first_ranking_holds_a_tenth_of_a_millimetre(found):
    first = found["first"]
    assert "is the cheapest that holds 0.1 mm" in first["words"] and first["address"] == "" and first["cut"] == [0.1]
    assert [line[0] for line in first["ranking"]] == [str(number) for number in range(1, len(first["ranking"]) + 1)]
    times = [float(line[3].split()[0]) for line in first["ranking"]]
    assert times == sorted(times) and len(times) > 5


def test_the_same_error_stands_for_all_scenes(found):
    heads, *lines = found["scenes"]
    assert heads == ["backend", SCENE] and [line[1] for line in lines] == [line[4].split()[0] for line in found["first"]["ranking"]]


def test_the_slider_moves_the_line_and_the_ranking(found):
    coarse, fine = found["coarse"], found["fine"]
    assert "holds 0.1 mm" not in coarse["words"] and coarse["address"].startswith("#at=") and coarse["cut"][0] > 0.3
    assert float(coarse["ranking"][0][3].split()[0]) <= float(found["first"]["ranking"][0][3].split()[0])
    assert "0.00001" in fine["words"] or "1.00e-5" in fine["words"]
    assert all("exact" in line[5] or "e-6" in line[5] for line in fine["ranking"]) and len(fine["ranking"]) < len(coarse["ranking"])


def test_what_is_chosen_stands_in_the_address(found):
    assert "error=arm" in found["arm"]["address"] and "off=" in found["arm"]["address"]
    assert found["again"] == found["arm"] and found["arm"]["ranking"] != found["first"]["ranking"]


def test_another_address_is_followed(found):
    followed = found["followed"]
    assert followed["off"] == ["fcl", "vtk"] and "%" in followed["words"] and "error=torque" in followed["address"]


def test_what_can_not_win_is_crossed_out(found):
    assert found["crossed"] and all(why.startswith(("wrong", "several threads")) for why in found["crossed"])


def test_an_address_may_hold_anything(found):
    strange = found["strange"]
    assert strange["drawn"] == found["first"]["drawn"] and "holds" in strange["words"]


def test_it_fits_a_telephone_and_is_dark_there(found):
    assert found["phone"]["wide"] <= found["phone"]["shown"] and found["phone"]["page"] != "rgb(255, 255, 255)"


def test_paper_tells_the_scene(found):
    assert found["printed"].startswith("synthetic/iliacus, accuracy-synthetic")


def test_everything_that_can_be_used_has_a_name(found):
    assert found["nameless"] == []


def test_the_camera_stands_in_the_address(found):
    assert "camera=" in found["shapes"]["address"] and found["shapes"]["cells"] > 1
    assert found["beside"]["sight"] == pytest.approx(found["shapes"]["sight"], rel=1e-3, abs=1e-6)
