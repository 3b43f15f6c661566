"""The page of results without a browser: what it carries, and that it needs nothing else."""

import base64
import re
import shutil
import sqlite3
import zlib
from contextlib import closing
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import fake_page
import fake_registry
import fake_runs
import report
from musclebench.accuracy import report as accuracy_report
from musclebench.figures import style
from musclebench.figures.paper_figures import caption
from musclebench.history.history import Finding, Measure, Night, opened
from musclebench.page import bundle, helps, of_study, packed, page_file, views
from musclebench.page.html import page_html, plain_html
from musclebench.page.page_file import write_page
from musclebench.page.paper_part import paper_section
from musclebench.page.parts import Chart, TablePart
from musclebench.page.sections import sections_of
from musclebench.page.told_of_runs import what_was_run
from musclebench.paper.published import read_published
from musclebench.results.run_folder import read_runs
from musclebench.tables import paper_tables

ROLES = fake_registry.roles()


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return fake_page.write_paper(tmp_path_factory.mktemp("page") / "paper")


def page_of(*folders) -> str:
    return page_html(sections_of(list(folders)), list(folders), "/* program */")


def parts_of(section, kind) -> dict:
    return {part.name: part for part in section.parts if isinstance(part, kind)}


def unpacked(text: str, bits: int) -> np.ndarray:
    """As tools/page/unpack.js does it."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(bits // 8, -1).astype(np.int64)
    words = sum(plane << (8 * number) for number, plane in enumerate(planes))
    return np.where(words % 2 == 0, words // 2, -(words + 1) // 2)


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_whole_numbers_come_back(bits):
    half = 1 << (bits - 1)
    values = np.array([0, 1, -1, half - 1, -half, 17])
    assert (unpacked(packed.packed_words(values, bits), bits) == values).all()


def test_an_order_of_neighbours_has_every_vertex_once():
    ball = fake_page.MUSCLE
    order = packed.neighbours_order(len(ball.vertices_m) + 2, ball.triangles)  # two of no triangle
    assert sorted(order) == list(range(len(ball.vertices_m) + 2)) and set(order[-2:]) == {len(order) - 2, len(order) - 1}
    steps = np.linalg.norm(np.diff(ball.vertices_m[order[:-2]], axis=0), axis=1)
    shuffled = np.random.default_rng(1).permutation(ball.vertices_m)
    assert steps.mean() < 0.5 * np.linalg.norm(np.diff(shuffled, axis=0), axis=1).mean()


@pytest.mark.parametrize("reach_m", [0.05, 300.0])
def test_positions_come_back_within_half_a_step(reach_m):
    """Even of a run that threw its muscle far away."""
    random = np.random.default_rng(3)
    shapes = random.uniform(-reach_m, reach_m, (4, 50, 3))
    order = random.permutation(50)
    made = packed.packed_shapes(shapes, order)
    steps = unpacked(made.text, 16).reshape(4, 3, 50).cumsum(axis=2).cumsum(axis=0) % 65536
    back = np.array(made.origin_m)[:, None] + made.step_m * steps
    assert np.abs(back - shapes[:, order].transpose(0, 2, 1)).max() <= 0.5001 * made.step_m
    assert made.step_m == pytest.approx(max(packed.STEP_M, 2 * reach_m / packed.STEPS), rel=0.1)


def test_triangles_come_back_as_the_same_surface():
    ball = fake_page.MUSCLE
    order = packed.neighbours_order(len(ball.vertices_m), ball.triangles)
    corners = unpacked(packed.packed_triangles(ball.triangles, order), 32).cumsum().reshape(-1, 3)

    def turned(triangles):
        return {tuple(np.roll(triangle, -int(np.argmin(triangle)))) for triangle in triangles.tolist()}

    assert turned(order[corners]) == turned(ball.triangles)


def test_charts_hold_the_rows_of_the_runs(results):
    charts = parts_of(paper_section(results), Chart)
    times = charts["fig_7_collision_time"].rows
    assert set(times["muscle"]) == set(fake_page.MUSCLES) and ROLES.control not in set(times["backend"])
    assert (times.loc[times["backend"] == ROLES.field, "collision_ms"] == 3.0).all() and len(times) == 2 * 3 * fake_page.FRAMES
    memory = charts["fig_8_memory"].rows
    ours = memory[(memory["backend"] == ROLES.unit) & (memory["muscle"] == "iliacus") & (memory["source"] == "here")]
    assert ours["resident_mb"].iloc[0] == pytest.approx(110.001)
    theirs = memory[(memory["backend"] == ROLES.unit) & (memory["muscle"] == "iliacus") & (memory["source"] == "paper")]
    assert list(theirs["resident_mb"]) == [537, 688]  # of reports/published
    assert charts["depth_by_frame"].rows["max_depth_mm"].max() == pytest.approx(2.0)


def test_tables_are_those_of_the_experiment(results):
    table = paper_tables.time_table(read_runs(results / "raw"), read_published())
    shown = parts_of(paper_section(results), TablePart)["table_2_times"]
    assert [group for group, _ in shown.groups] == ["gluteus medius", "iliacus"]
    assert shown.csv == table.rows.to_csv(index=False)


def test_views_hold_shape_depth_and_poses(results):
    told = fake_page.data_of_views(page_of(results), "paper-view")
    scene = next(scene for scene in told["scenes"] if scene["muscle"] == "iliacus")
    run = scene["runs"][0]
    assert run["frames"] == list(fake_page.KEPT) and run["angles_deg"] == [0, 45, 90, 45, 0]
    assert [run["backend"] for run in scene["runs"]] == fake_runs.backends()
    count = scene["vertices"]
    order = unpacked(scene["order"], 32).cumsum()
    wanted = np.array([shot.depth_m for shot in fake_page.snapshots()])[:, order]
    assert wanted.max() > 3e-3
    for kind, factor in (("node", 1), ("surface", 2)):
        depths = unpacked(run["depths"][kind]["text"], 16).reshape(5, count).cumsum(axis=1) * run["depths"][kind]["step_m"]
        assert np.abs(depths - factor * wanted).max() < 1e-6
    assert np.reshape(run["poses"][2][1][:9], (3, 3)) == pytest.approx(fake_runs.turn_about_x(90, (0, 0, 0))[0])
    assert len(told["meshes"]) == 2 and len(told["scenes"]) == 2  # bones are shared by the scenes


def test_moments_are_left_out_where_a_page_would_grow_too_large(results, monkeypatch):
    monkeypatch.setattr(views, "BUDGET_CHARACTERS", 1000)
    made = views.views_of(paper_tables.by_case(read_runs(results / "raw")), "")
    assert made.scenes[0]["runs"][0]["frames"] == [0, 6, 12]  # where it starts, is turned farthest and ends
    assert "Runs kept up to 5 moments. The page shows every" in made.words
    assert views.views_of(made.cases, "").words == made.words


def test_all_moments_stay_where_they_fit(results):
    made = views.views_of(paper_tables.by_case(read_runs(results / "raw")), "")
    assert made.scenes[0]["runs"][0]["frames"] == list(fake_page.KEPT) and "Of up to" not in made.words
    every = [entry["frame"] for entry in views.kept_moments(next(iter(made.cases.values())), 2)]
    assert every == [0, 6, 12]


def test_a_page_of_several_folders_stays_small(results, tmp_path, monkeypatch):
    """Its moments go, evenly, and its tables stay; where there is room for all but a few, it is used."""
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    whole = write_page([results, results], tmp_path / "whole.html").stat().st_size
    monkeypatch.setattr(page_file, "LARGEST_BYTES", whole - 1000)
    small = write_page([results, results], tmp_path / "small.html")
    assert whole - 1000 >= small.stat().st_size
    for name in ("paper-1-view", "paper-2-view"):
        run = fake_page.data_of_views(small.read_text(), name)["scenes"][0]["runs"][0]
        assert run["frames"] == [0, 6, 12], name
    assert small.read_text().count("tools/report --export vtk has all") == 2


def test_a_page_needs_no_other_file(results, tmp_path):
    page = page_of(results, fake_page.write_hard(tmp_path / "hard"))
    assert not re.search(r"""(src|href)\s*=\s*["'](?!#)""", page) and "@import" not in page and "url(" not in page
    for name in ("paper-fig_7_collision_time", "paper-fig_8_memory", "paper-depth_by_frame", "paper-table_1_memory", "hard-cells"):
        assert len(fake_page.embedded(page, name).splitlines()) > 2, name
    assert page.count("<figure") == page.count("class=\"save-rows\"") + 1  # each figure but the view


def test_every_picture_has_words_for_a_screen_reader(results):
    page = page_of(results)
    ids = set(re.findall(r'id="([^"]+)"', page))
    for figure in re.findall(r'<div class="chart"[^>]*>', page):
        assert 'role="img"' in figure and 'tabindex="0"' in figure
        assert set(re.findall(r'aria-(?:labelledby|describedby)="([^"]+)"', figure)) <= ids
    assert re.search(r'<html lang="en">', page) and page.count("<th") == len(re.findall(r"<th[^>]* scope=", page)) + page.count("<thead")


def test_words_of_results_are_no_html(tmp_path):
    page = page_of(fake_page.write_hard(tmp_path / "hard"))
    assert "<b>no</b>" not in page and "&lt;b&gt;no" in page


def test_a_backend_called_null_is_a_backend(tmp_path):
    page = page_of(fake_page.write_hard(tmp_path / "hard"))
    assert ">no collision</span></th>" in page and "thin breaks with grid: breaks; depth 0.25 mm, bar 0.1 mm" in page


@pytest.mark.long
def test_what_a_study_wrote_is_shown_as_it_is(study, monkeypatch):
    monkeypatch.setattr(style, "FORMATS", [".svg"])
    accuracy_report.write_report(study)
    section = sections_of([study])[0]
    charts, tables = parts_of(section, Chart), parts_of(section, TablePart)
    assert tables["price_list"].csv == (study / "tables" / "price_list.csv").read_text()
    drawn = pd.read_csv(study / "figures" / "pareto_replay.csv", keep_default_na=False, na_values=[""])
    assert list(charts["pareto_replay"].rows["error_mm"]) == list(drawn["error_mm"])
    assert set(section.backends) <= set(drawn["backend"]) and section.muscles
    assert charts["pareto_replay"].options["exact_words"] == "exact (below 1 nm)"
    for kind in (".csv", ".md"):
        shutil.copyfile(study / "figures" / f"pareto_replay{kind}", study / "figures" / f"pareto_pressure{kind}")
    percent = parts_of(sections_of([study])[0], Chart)["pareto_pressure"]
    assert percent.options["exact_words"] == "same (below 0.000001 %)"


def test_what_failed_is_told_before_anything_else(tmp_path):
    accuracy, effects = sections_of([fake_page.write_accuracy(tmp_path)])
    assert accuracy.problems == ["b: failed, out of luck"] and accuracy.muscles == list(fake_page.MUSCLES)
    assert parts_of(accuracy, TablePart)["price_list"].groups == [("iliacus", [["0.1", "grid 64"]])]
    assert "effect_costs_chart" in parts_of(effects, Chart)


@pytest.mark.parametrize(("folder", "words"), [("nowhere", "no such folder"), (".", "holds no results")])
def test_a_folder_without_results_is_one_line(tmp_path, folder, words, capsys, monkeypatch):
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    assert report.main([str(tmp_path / folder)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and words in told and str(tmp_path) in told
    assert not list(tmp_path.glob("*.html"))


@pytest.fixture
def without_npm(monkeypatch, tmp_path):
    monkeypatch.setattr(bundle.shutil, "which", lambda name: None)
    monkeypatch.setattr(page_file, "page_script", lambda: bundle.page_script(built=tmp_path / "built"))


def test_without_npm_a_plain_page_is_made_and_one_line_says_what_is_missing(without_npm, capsys, tmp_path):
    folder = fake_page.write_paper(tmp_path / "paper", ("iliacus",))
    (folder / "figures").mkdir()
    (folder / "figures" / "fig_8_memory.png").write_bytes(b"a picture")
    assert report.main([str(folder)]) == 0
    assert capsys.readouterr().err == "report: left out charts and runs in space, so that the page is plain: npm is missing; " \
        "the page needs JavaScript libraries. Install npm with tools/setup npm nodejs\n"
    page = (folder / "report.html").read_text()
    assert "A plain page: npm is missing" in page and base64.b64encode(b"a picture").decode() in page
    assert not re.search(r"<script|<canvas|<button|<select|class=\"has-(chart|view)", page)
    table = parts_of(paper_section(folder), TablePart)["table_2_times"]
    assert all(cell in page for _, lines in table.groups for cells in lines for cell in cells)
    linked = re.search(r'href="data:text/csv;base64,([^"]+)" download="table_2_times.csv"', page)
    assert base64.b64decode(linked[1]).decode() == table.csv


def test_a_plain_page_keeps_its_size_and_says_what_it_left_out(without_npm, monkeypatch, tmp_path):
    folder = fake_page.write_hard(tmp_path / "hard")
    (folder / "figures").mkdir()
    for name, size in (("a", 30), ("b", 3000), ("c", 30)):
        (folder / "figures" / f"{name}.png").write_bytes(size * b"x")
    whole = page_file.plain_page(sections_of([folder]), [folder], "why")
    monkeypatch.setattr(page_file, "LARGEST_BYTES", len(whole.encode()) - 1000)
    text = page_file.plain_page(sections_of([folder]), [folder], "why")
    assert text.count("<img") == 2 and "1 more pictures" in text and len(text.encode()) < len(whole.encode()) - 3000


def test_a_study_without_npm_ends_with_a_plain_page(without_npm, capsys, tmp_path):
    folder = fake_page.write_hard(tmp_path / "hard")
    assert of_study.page_of("hard", folder, SimpleNamespace(no_page=False)) == [folder / "report.html"]
    assert "npm is missing" in capsys.readouterr().err
    assert '<td class="breaks" title="breaks; depth 0.25 mm' in (page := (folder / "report.html").read_text()) and "<button" not in page


def test_a_page_that_cant_be_made_is_no_failure_of_a_study(capsys, tmp_path):
    assert of_study.page_of("paper", tmp_path, SimpleNamespace(no_page=False)) == []
    assert "paper: left out" in capsys.readouterr().err and not (tmp_path / "report.html").exists()


def test_a_page_that_is_not_wanted_is_not_made(results):
    assert of_study.page_of("paper", results, SimpleNamespace(no_page=True)) == [] and not (results / "report.html").exists()


def test_words_are_explained_where_they_stand():
    known = helps.helps()
    word = helps.explained("suspect", known)
    assert 'tabindex="0" aria-describedby="help-suspect"' in word and "beyond its limit" in known["suspect"]
    assert known["distance field"] == known["sdf"] and "Discregrid" in known["sdf"] and "bending" in known
    told = helps.explained_in("2 suspect, <b> suspect", known)
    assert told.count("aria-describedby") == 1 and "&lt;b&gt;" in told
    assert helps.explained("unknown word", known) == "unknown word"


def test_more_than_ten_backends_are_toggles_behind_a_filter(results):
    section = sections_of([results])[0]
    looks_like = next(iter(section.colours.values()))
    names = [f"setting {number}" for number in range(14)]
    chart = next(part for part in section.parts if isinstance(part, Chart))
    many = replace(chart, rows=pd.concat([chart.rows.assign(backend=name) for name in names]))
    page = page_html([replace(section, parts=[many], colours={name: looks_like for name in names})], [results], "")
    assert page.count('aria-pressed="true"') == 10 and page.count('class="choose-backend"') == 14 and "filter-backends" in page


def test_a_page_of_one_study_says_once_what_was_run(results):
    page = page_of(results)
    title = "The paper&#39;s experiment: gluteus medius, iliacus (synthetic)"
    assert f"<title>{title}</title>" in page and f"<h1>{title}</h1>" in page and "Sections" not in page


def test_a_page_and_its_captions_say_whose_shapes_they_show(results):
    runs = read_runs(results / "raw")
    assert not any(name.startswith("Licence") for name, _ in what_was_run(runs))
    for run in runs:
        run.record["source"] = {"licence": "CC BY 4.0", "cite": ["A (2022)", "B (2023)"], "non_commercial": False}
    runs[0].record["source"] = {"licence": "CC BY-NC 2.0", "non_commercial": True}
    told = dict(what_was_run(runs))
    assert told["Licence of the shapes"] == "CC BY-NC 2.0, not for commercial use; CC BY 4.0" and told["Cite"] == "A (2022); B (2023)"
    assert "shapes: CC BY-NC 2.0, not for commercial use; shapes: CC BY 4.0" in caption(runs)


def test_moment_arms_have_a_page(tmp_path):
    (tmp_path / "tables").mkdir()
    course = "angle_deg,mean_mm,p10_mm,p90_mm\n0,30,20,40\n10,31,21,41\n"
    for name in ("iliacus", "iliacus_active"):
        (tmp_path / "tables" / f"moment_arms_{name}.csv").write_text(course)
    (tmp_path / "tables" / "moment_arms.csv").write_text("muscle,angle_deg\niliacus,0\n")
    section = sections_of([tmp_path])[0]
    assert section.backends == ["passive", "active"] and section.muscles == ["iliacus"]
    assert "moment_arms" in parts_of(section, TablePart)


def test_runs_of_no_study_stand_beside_each_other(tmp_path):
    """Of one backend: told apart by their folders, in colours of their own."""
    for name in ("before", "after"):
        fake_runs.write_run(tmp_path / name, "synthetic/iliacus", ROLES.unit, fake_page.FRAMES, bones=fake_page.BONES,
                            triangles=fake_page.MUSCLE.triangles, snapshots=fake_page.snapshots(), motions=fake_page.MOTIONS)
    section = sections_of([tmp_path])[0]
    assert section.backends == ["after", "before"] and len({look["colour"] for look in section.colours.values()}) == 2
    assert set(parts_of(section, Chart)["memory"].rows["backend"]) == {"after", "before"}
    assert [run["name"] for run in parts_of(section, views.Views)["view"].scenes[0]["runs"]] == ["after", "before"]
    one = sections_of([tmp_path / "before"])[0]
    assert one.backends == [ROLES.unit]


def test_a_history_shows_steps_answers_and_what_lies_between(tmp_path):
    file = fake_page.write_history(tmp_path / "history.sqlite")
    (section,) = sections_of([file])
    chart, tables = parts_of(section, Chart)["nights"], parts_of(section, TablePart)
    rows = chart.rows[(chart.rows["case"] == fake_page.TREE) & (chart.rows["metric"] == "collision_ns")]
    values = np.array([fake_page.night_value(fake_page.TREE, night) / 1e6 for night in range(1, fake_page.NIGHTS + 1)])
    assert rows["value"].to_numpy() == pytest.approx(values) and set(rows["unit"]) == {"ms"}
    assert rows["low"].to_numpy() == pytest.approx(0.98 * values) and rows["high"].to_numpy() == pytest.approx(1.03 * values)
    split = fake_page.STEP_NIGHT - 1
    assert rows["level"].to_numpy() == pytest.approx(np.repeat([np.median(values[:split]), np.median(values[split:])],
                                                               [split, len(values) - split]))
    assert list(rows["changed"] != "") == [night == fake_page.STEP_NIGHT for night in range(1, fake_page.NIGHTS + 1)]
    assert {one.column: one.first for one in chart.choosers} == {"case": fake_page.TREE, "metric": "collision_ns"}
    assert tables["changes"].groups == [("", [[fake_page.TREE, "collision_ns", "2026-01-09T02:00:00Z", "1.99 ms", "2.2 ms", "1.100",
                                               "1.080 to 1.120", "2e-06", "change point", "commit8..commit9"]])]
    assert tables["answers"].groups == [("", [[fake_page.BALL, "state_hash", "2026-01-11T02:00:00Z", "0123", "4567", "commit10..commit11"]])]
    assert len(tables["measured"].groups[0][1]) == fake_page.NIGHTS
    assert "state_hash" not in set(chart.rows["metric"]) and "1, answers: 1" in dict(section.what)["Changed"]


def test_what_all_cases_share_is_a_series_and_other_machines_are_left_out(tmp_path):
    file = tmp_path / "history.sqlite"
    with opened(file) as history:
        for night, factor in enumerate((1.0, 1.0, 1.2), 1):
            history.append(Night(f"2026-01-0{night}T02:00:00Z", "same", "same", "This one", "cc"),
                           [Measure(f"case{one}", "frame_ns", "time", "ns", 5e3 * factor, quartile=5e3 * factor) for one in range(4)])
        history.append(Night("2025-12-31T02:00:00Z", "same", "same", "That one", "cc"), [Measure("old", "frame_ns", "time", "ns", 1.0)])
        history.note(3, [Finding("all cases", "frame_ns", 3, "change point", "", "", 1.2)])
    section = sections_of([tmp_path])[0]
    rows = parts_of(section, Chart)["nights"].rows
    shared = rows[rows["case"] == "all cases"]
    assert list(shared["value"]) == pytest.approx([1.0, 1.0, 1.2]) and "old" not in set(rows["case"])
    assert list(shared["between"]) == ["", "", "none: same was measured in both nights"]
    assert "That one" in dict(section.what)["Left out"]


def history_from_the_future(file):
    fake_page.write_history(file)
    with sqlite3.connect(file) as connection:
        connection.execute("PRAGMA user_version = 7")


def history_without_a_night(file):
    with opened(file):
        pass


BAD_HISTORIES = [(history_from_the_future, "a history of schema 7"), (lambda file: file.write_bytes(b""), "no history"),
                 (lambda file: file.write_text("nights\n" * 99), "no history"), (history_without_a_night, "has no night yet")]


@pytest.mark.parametrize(("make", "words"), BAD_HISTORIES, ids=["from the future", "empty", "no database", "without a night"])
def test_a_history_that_cant_be_read_is_one_line_and_the_rest_goes_on(make, words, results, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    make(tmp_path / "history.sqlite")
    assert report.main([str(tmp_path / "history.sqlite")]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and words in told and str(tmp_path / "history.sqlite") in told and not list(tmp_path.glob("*.html"))
    assert report.main([str(results), str(tmp_path / "history.sqlite"), "--out", str(tmp_path / "page.html")]) == 0
    told, page = capsys.readouterr().err, (tmp_path / "page.html").read_text()
    assert told.count("\n") == 1 and words in told and words in page and "Fig. 7" in page


def test_a_history_that_another_process_keeps_for_itself_is_left_out(results, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("musclebench.history.history.WAIT_SECONDS", 0.1)
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    file = fake_page.write_history(tmp_path / "history.sqlite")
    with closing(sqlite3.connect(file, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")  # one that adds a night: it can be read all the same
        assert parts_of(sections_of([file])[0], Chart)
        other.execute("COMMIT")
        other.execute("PRAGMA locking_mode = EXCLUSIVE")
        other.execute("BEGIN EXCLUSIVE")
        assert report.main([str(file)]) == 2 and "another process writes it" in capsys.readouterr().err
        assert report.main([str(results), str(file), "--out", str(tmp_path / "page.html")]) == 0
    assert "another process writes it" in (tmp_path / "page.html").read_text()


def test_damaged_runs_are_left_out_where_other_results_are_whole(results, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(page_file, "page_script", lambda: "")
    run = fake_runs.write_run(tmp_path / "runs" / "one", "synthetic/iliacus", ROLES.unit, fake_page.FRAMES)
    (run / "run.json").write_text("{")
    assert report.main([str(tmp_path / "runs")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert report.main([str(tmp_path / "runs"), str(results), "--out", str(tmp_path / "page.html")]) == 0
    assert "left out" in capsys.readouterr().err and "run.json" in (tmp_path / "page.html").read_text()


def test_a_reason_stands_under_its_row_as_wide_as_the_table(results):
    section = sections_of([results])[0]
    lines = [["sdf 64", "0.2", "the volume is off its target by more than its limit allows"], ["bvh", "0.1", "-"]]
    section.parts[:] = [TablePart("t", "a table", "words", ["configuration", "ms", "detail"], [False, True, False], [("", lines)], "a\n1\n")]
    page = plain_html([section], [results], "no npm", {})
    assert page.count('<tr class="below">') == 1
    assert '<td colspan="2">detail: the volume is off its target' in page
    assert "<th scope=\"col\">detail</th>" not in page and '<td class="number">0.1</td></tr>' in page
    lines += [["sdf 32", "0.1", "short"], ["sdf 16", "0.1", "short"]]
    assert '<tr class="below">' not in plain_html([section], [results], "no npm", {}), "one long cell wraps among short ones"
