"""Pages quote nothing that was not measured, and say what measured tables say; publishing rehearsed from end to end."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

import fake_runs
import publish
from musclebench.figures.style import DPI, plt, save_figure
from musclebench.program.cli import Problem
from musclebench.publish import measured as measured_module
from musclebench.publish.blocks import block
from musclebench.publish.measured import Measured, adopt
from musclebench.publish.pages import pages_of, pictures_in, studies_in, written
from musclebench.publish.quoted import unmarked
from musclebench.publish.selection import value_text

PROJECT = Path(publish.PROJECT)
REPORTS = Measured(PROJECT / "reports" / "measured")
PAGES = {str(path.relative_to(PROJECT)): path for path in pages_of(PROJECT)}


@pytest.fixture
def small(tmp_path) -> Measured:
    """A study of two muscles and two backends."""
    folder = tmp_path / "measured" / "paper-lhdl"
    folder.mkdir(parents=True)
    rows = [("iliacus", "voxel", 1.0, 0.2), ("iliacus", "fcl", 361.2, 70.0), ("gluteus_medius", "fcl", 689.0, 48.0),
            ("gluteus_medius", "null", math.nan, 0.0)]
    pd.DataFrame(rows, columns=["muscle", "backend", "ratio", "collision_ms"]).to_csv(
        folder / "table_2_times.csv", index=False)
    source = {"command": "tools/paper", "commit": "abc1234", "machine": "A processor", "build": "g++",
              "date": "2026-11-22", "results_schema": 1}
    (folder / "source.json").write_text(json.dumps(source))
    return Measured(tmp_path / "measured")


def schemas() -> list[int]:
    """The oldest that the program reads, and its own."""
    header = next((PROJECT / "bench").rglob("manifest.hpp")).read_text()
    return [int(re.search(rf"int {name} = (\d+);", header).group(1))
            for name in ("oldest_readable_schema", "schema_version")]


@pytest.mark.parametrize("name", PAGES)
def test_pages_quote_no_number_outside_of_markers(name):
    assert unmarked(PAGES[name].read_text()) == [], f"{name}: CONTRIBUTING.md says how a number gets into a page"


@pytest.mark.parametrize("name", PAGES)
def test_pages_say_what_was_measured(name):
    text = PAGES[name].read_text()
    assert written(text, REPORTS, name) == text, f"{name}: tools/publish --write-only writes it anew"


@pytest.mark.parametrize("study", REPORTS.studies)
def test_measured_results_have_the_programs_schema(study):
    assert REPORTS.source(study).results_schema == schemas()[1], "measure it anew with tools/publish"


def test_studies_of_one_publication_share_commit_machine_and_schema():
    """Those that were measured one by one, with --only, or before publications had a name, are of their own."""
    by_name = {}
    for study in REPORTS.studies:
        source = REPORTS.source(study)
        if source.publication:
            by_name.setdefault(source.publication, []).append(source)
    for name, sources in by_name.items():
        for key in measured_module.ONE_PUBLICATION:
            assert len({getattr(source, key) for source in sources}) == 1, f"publication {name}: {key}"


def test_what_was_published_in_one_go_has_the_newest_schema():
    sources = [REPORTS.source(study) for study in REPORTS.studies]
    if len({source.publication for source in sources}) > 1 or not sources[0].publication:
        pytest.skip("the studies were published one by one")
    assert {source.results_schema for source in sources} == {schemas()[1]}, "publish all anew with tools/publish"


@pytest.mark.parametrize("name", PAGES)
def test_links_of_pages_lead_somewhere(name):
    page = PAGES[name]
    text = re.sub(r"```.*?```|<!--.*?-->", "", page.read_text(), flags=re.S)
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", text):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{name}: {target}"


@pytest.mark.parametrize("name", [*PAGES, "CONTRIBUTING.md"])
def test_commands_that_pages_name_are_there(name):
    for command in set(re.findall(r"(?:^|[`\s])(tools/\w+)(?=[`\s])", (PROJECT / name).read_text())):
        path = PROJECT / command
        assert path.is_dir() or os.access(path, os.X_OK), f"{name}: {command}"


def test_contributing_names_every_preset():
    presets = json.loads((PROJECT / "CMakePresets.json").read_text())["configurePresets"]
    line = re.search(r"tools/build \[PRESET\].*", (PROJECT / "CONTRIBUTING.md").read_text()).group(0)
    assert {one["name"] for one in presets if not one.get("hidden")} <= set(re.findall(r"[\w-]+", line))


LISTS = {"reports/hard_cases/cases.md"}  # looked up, not read


@pytest.mark.parametrize("name", sorted(set(PAGES) - LISTS))
def test_pages_are_short(name):
    assert len(PAGES[name].read_text().splitlines()) <= (90 if name == "README.md" else 250)


@pytest.mark.parametrize("text, found", [
    ("It takes 0.5 ms.", ["0.5 ms"]), ("about 12 MB", ["12 MB"]), ("costs 300 to 570 times", ["300 to 570 times"]),
    ("off by 14 mm", ["14 mm"]), ("5 % slower", ["5 %"]), ("| 0.219 | 195 |", ["0.219", "195"]),
    ("in 0.76 and", ["0.76"]), ("one half to three quarters of it", ["one half", "three quarters"]),
    ("1,169 nodes, 64 cells, 90 degrees, 2022", []), ("option `0.1 mm` and ```\nrun 5 s\n```", []), ("FCL 0.7", []),
    ("see [x](a/1.5-2.png) and $2h \\sqrt5$", []), ("CC BY-NC-SA 2.0 BE", []), ("max(0, s)", []),
    ("four times as fast, hundreds\nof times", ["four times", "hundreds\nof times"]), ("Twice as fast", ["Twice as"]),
    ("more than two hundred times", ["hundred times"]), ("half as much", ["half as"]),
    ("the three times of a row; half-space; one half sphere; half of the edge; two threads over one", []),
    ("at most twice the displacement, two thirds of $h$, many times", []),
    ("<!-- value: a/b.c -->0.96<!-- end --> ms", []), ("frames of 20 ms each", ["20 ms"]),
])
def test_what_counts_as_quoted(text, found):
    assert [words for _, words in unmarked(text)] == found


def test_a_quoted_number_is_found_with_its_line():
    assert unmarked("a\nb\nit takes 3 ms\n") == [(3, "3 ms")]


@pytest.mark.parametrize("specification, text", [
    ("paper-lhdl/table_2_times[backend=fcl].ratio", "361 to 689"),
    ("paper-lhdl/table_2_times[backend=fcl,muscle=iliacus].ratio .1f", "361.2"),
    ("paper-lhdl/table_2_times.collision_ms max", "70.0"), ("paper-lhdl/table_2_times.collision_ms max /1e3", "0.0700"),
    ("paper-lhdl/table_2_times.collision_ms max /1e-3", "70000"),
    ("paper-lhdl/table_2_times[muscle=iliacus].backend", "voxel, fcl"), ("paper-lhdl/table_2_times[backend=fcl].backend count", "2"),
])
def test_values_are_cells_or_ranges(small, specification, text):
    assert value_text(small, specification) == text


@pytest.mark.parametrize("specification, words", [
    ("paper-lhdl/table_2_times[backend=none].ratio", "no row"),
    ("paper-lhdl/table_2_times.nothing", "no column 'nothing'"),
    ("paper-lhdl/table_9.ratio", "table_9.csv"), ("nonsense", "not like"),
    ("paper-lhdl/table_2_times[what=1].ratio", "no column 'what'"),
    ("paper-lhdl/table_2_times.ratio max", "1 of its 4 rows have none"),
    ("paper-lhdl/table_2_times[muscle=gluteus_medius].ratio", "1 of its 2 rows have none"),
])
def test_a_value_that_is_not_there_is_named(small, specification, words):
    with pytest.raises(Problem, match=re.escape(words)):
        value_text(small, specification)


@pytest.mark.parametrize("claim, is_true", [
    ("[backend=fcl].ratio rises", True), ("[backend=fcl].ratio falls", False), ("[backend=fcl].ratio > 361", True),
    ("[backend=fcl].ratio > 361.2", False), ("[backend=fcl].ratio within 361.2 to 689", True),
    ("[backend=fcl].ratio within 362 to 689", False), ("[backend=voxel].ratio falls", False),
    (".collision_ms < 70.1", True), (".collision_ms /1e3 < 0.07", False),
])
def test_a_sentence_that_contradicts_its_table_is_told(small, claim, is_true):
    page = f"<!-- claim: paper-lhdl/table_2_times{claim} --> FCL is slow.\n"
    if is_true:
        assert written(page, small, "page.md") == page
    else:
        with pytest.raises(Problem, match="page.md: claim .* write its sentence anew"):
            written(page, small, "page.md")
        problems = []
        assert written(page, small, "page.md", problems) == page and len(problems) == 1


@pytest.mark.parametrize("claim, words", [
    (".ratio is large", "not like"), ("[backend=fcl].ratio max < 1", "all values are compared"),
    ("[backend=fcl].ratio < much", "no number"), (".ratio < 1000", "1 of its 4 rows have none"),
])
def test_a_claim_that_says_nothing_is_told(small, claim, words):
    with pytest.raises(Problem, match=re.escape(words)):
        written(f"<!-- claim: paper-lhdl/table_2_times{claim} -->", small, "page.md")


def test_tables_are_written_with_their_source_and_stay(small):
    page = "a\n<!-- generated: times paper-lhdl muscle=iliacus -->\nold\n<!-- end -->\nb\n"
    new = written(page, small, "page.md")
    assert "| iliacus | fcl | 70.000 | 361 |" in new and "gluteus" not in new and "old" not in new
    assert "commit abc1234, A processor" in new and "2026-11-22" in new
    assert new.startswith("a\n") and new.endswith("b\n")
    assert written(new, small, "page.md") == new


def test_null_is_a_backend_and_no_missing_value(small):
    new = written("<!-- generated: times paper-lhdl muscle=gluteus_medius -->\n<!-- end -->\n", small, "page.md")
    assert "| gluteus medius | null | 0.000 | - |" in new


def test_a_disturbed_run_is_marked_and_still_found(small):
    path = small.folder / "paper-lhdl" / "table_2_times.csv"
    rows = pd.read_csv(path, keep_default_na=False).assign(status=["ok", "ok *", "ok", "ok"])
    rows.assign(configuration=rows["backend"] + [" *", "", "", ""]).to_csv(path, index=False)
    assert "| iliacus | fcl * |" in block(small, "times paper-lhdl")
    assert value_text(small, "paper-lhdl/table_2_times[configuration=voxel].ratio") == "1.00"


def test_a_marker_without_an_end_is_told(small):
    with pytest.raises(Problem, match="page.md"):
        written("<!-- value: paper-lhdl/table_2_times.ratio -->1", small, "page.md")
    with pytest.raises(Problem, match="no table 'nothing'"):
        block(small, "nothing paper-lhdl")


def test_what_cannot_be_written_stays_and_is_told(small):
    table, problems = "paper-lhdl/table_2_times", []
    page = f"<!-- value: {table}.no -->1<!-- end --> <!-- value: {table}[muscle=iliacus].ratio min -->0<!-- end -->"
    assert written(page, small, "page.md", problems) == page.replace("0<!--", "1.00<!--")
    assert len(problems) == 1 and "page.md" in problems[0]


def test_pictures_keep_their_link_and_get_a_source(small, tmp_path):
    page = "<!-- picture: paper-lhdl fig_6 -->\n![a muscle](reports/gallery/x.png)\n<!-- end -->\n"
    new = written(page, small, "page.md")
    assert "![a muscle](reports/gallery/x.png)" in new and "abc1234" in new
    picture = next(iter(pictures_in(new, tmp_path / "README.md")))
    assert (picture.study, picture.figure) == ("paper-lhdl", "fig_6") and picture.file.name == "x.png"


def test_a_picture_beside_text_keeps_its_place_and_names_its_source_once(small, tmp_path):
    page = '<!-- picture: paper-lhdl fig_6 -->\n<img align="right" alt="a muscle" src="reports/gallery/x.png">\n<!-- end -->\n'
    new = written(page, small, "page")
    assert 'src="reports/gallery/x.png" title="tools/paper' in new and "<sub>" not in new
    assert written(new, small, "page") == new
    assert next(iter(pictures_in(new, tmp_path / "README.md"))).file.name == "x.png"


def test_what_was_not_measured_yet_says_so_until_it_is(small, tmp_path):
    """And keeps its link as a comment."""
    page = "<!-- picture: paper-hip fig -->\n![a hip](x.png)\n<!-- end -->\n<!-- generated: depths paper-hip -->\n" \
           "<!-- end --> <!-- value: paper-hip/table_4_depths.bone_nodes max -->7<!-- end -->"
    new = written(page, small, "page.md")
    assert new.count("yet") == 3 and "<!-- ![a hip](x.png) -->" in new and "7" not in new
    assert written(new, small, "page.md") == new
    shutil.copytree(small.folder / "paper-lhdl", small.folder / "paper-hip")
    (small.folder / "paper-hip" / "table_4_depths.csv").write_text(
        "muscle,scene,backend,bone_depth_mm,bone_nodes\ngluteus_maximus,hip,sdf,0.12345,7\n")
    measured = written(new, small, "page.md")
    assert "\n![a hip](x.png)<br><sub>" in measured and "<!-- ![" not in measured and "yet" not in measured
    assert "| gluteus maximus | sdf | 0.123 | 7 |" in measured and " max -->7.00<!--" in measured
    assert [picture.study for picture in pictures_in(measured, tmp_path / "page.md")] == ["paper-hip"]


def test_tables_of_several_muscles_have_the_stages_of_their_scene(small):
    folder = small.folder / "paper-lhdl"
    (folder / "table_3_frame_times.csv").write_text(
        "muscle,backend,bending_ms,muscle_contact_ms\nhip,null,1.5,2.25\n")
    (folder / "table_5_pairs.csv").write_text(
        'muscle,scene,backend,detect_ms,contacts\n"iliacus, psoas",hip,sdf,0.5,9\n')
    assert "| backend | bending ms | muscle_contact ms |" in block(small, "frame_times paper-lhdl")
    assert "| null | 1.500 | 2.250 |" in block(small, "frame_times paper-lhdl")
    assert "| iliacus, psoas | sdf | 0.500 | 9 |" in block(small, "pairs paper-lhdl")


def test_every_picture_of_the_gallery_is_on_a_page():
    shown = {picture.file for page in PAGES.values() for picture in pictures_in(page.read_text(), page)}
    assert {path.name for path in (PROJECT / "reports" / "gallery").iterdir() if path not in shown} == set()


def test_pictures_of_the_gallery_are_as_they_were_saved():
    """No palette, and the resolution they are printed at. Those of the first schema were made smaller afterwards."""
    for page in PAGES.values():
        for picture in pictures_in(page.read_text(), page):
            if picture.file.suffix == ".png" and REPORTS.source(picture.study).results_schema >= 2:
                assert not has_palette(picture.file), picture.file
                assert dots_per_metre(picture.file) == round(DPI / 0.0254), picture.file


def test_saved_figures_have_their_resolution_and_no_palette(tmp_path):
    picture = save_figure(plt.figure(figsize=(1, 1)), tmp_path / "empty")[0]
    assert not has_palette(picture) and dots_per_metre(picture) == round(DPI / 0.0254)


def has_palette(png: Path) -> bool:
    return png.read_bytes()[25] == 3  # the colour type in the header


def dots_per_metre(png: Path) -> int | None:
    """None where it tells none."""
    _, found, rest = png.read_bytes().partition(b"pHYs")
    return int.from_bytes(rest[:4]) if found else None


@pytest.mark.parametrize("name", PAGES)
def test_publish_measures_what_pages_show(name):
    data = publish.parse_arguments(["--data", "."])
    assert studies_in(PAGES[name].read_text()) <= {step.name for step in publish.steps_of(data)} | measured_module.KEPT


def test_results_are_taken_over_with_commit_machine_and_disturbance(tmp_path):
    out = tmp_path / "out"
    for name in ("voxel", "fcl"):
        fake_runs.write_run(out / "raw" / name, "lhdl/iliacus", name)
    path = out / "raw" / "fcl" / "run.json"
    busy = {"machine_state": {"involuntary_context_switches": 9000}}
    path.write_text(json.dumps(json.loads(path.read_text()) | busy))
    (out / "tables").mkdir()
    (out / "tables" / "table_2_times.csv").write_text("muscle,backend,ratio\niliacus,fcl,200\n")
    source = adopt("paper-lhdl", out, tmp_path / "measured" / "paper-lhdl", "tools/paper")
    assert (source.commit, source.machine, source.results_schema, source.disturbed) == ("abc1234", "A processor", 1, 1)
    kept = Measured(tmp_path / "measured")
    assert kept.studies == ["paper-lhdl"] and "busy" in kept.source("paper-lhdl").words()
    assert value_text(kept, "paper-lhdl/table_2_times.ratio") == "200"


def test_results_of_two_commits_are_refused(tmp_path):
    for name in ("voxel", "fcl"):
        fake_runs.write_run(tmp_path / "raw" / name, "lhdl/iliacus", name)
    path = tmp_path / "raw" / "fcl" / "run.json"
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"build": record["build"] | {"git": "another"}}))
    with pytest.raises(Problem, match="more than one commit"):
        measured_module.source_of(tmp_path, "tools/paper")


def test_the_plan_names_every_study_and_page(capsys, tmp_path):
    assert publish.main(["--dry-run"]) == 0
    text = capsys.readouterr().out
    assert all(f"{kind}-synthetic:" in text for kind in set(measured_module.TABLES) - publish.REAL_ONLY) and "README.md" in text
    (tmp_path / "lhdl.json").write_text("{}")
    assert publish.main(["--dry-run", "--data", str(tmp_path), "--only", "moment-arms"]) == 0
    text = capsys.readouterr().out
    assert publish.main(["--dry-run", "--only", "moment-arms"]) == 2 and "give its folder" in capsys.readouterr().err
    with pytest.raises(Problem, match="arms-lhdl is no study"):
        measured_module.adopt("arms-lhdl", tmp_path, tmp_path / "measured", "tools/arms")
    assert "moment-arms-lhdl: " in text and "moment_arms.py --musclebench" in text and "moment-arms-synthetic" not in text


def test_bad_input_is_one_line(capsys):
    assert publish.main(["--musclebench", "/no/such/program"]) == 2
    assert publish.main(["--data", "/no/such/data"]) == 2
    assert capsys.readouterr().err.count("\n") == 2


def test_the_budget_of_each_muscle_is_a_column(small):
    rows = [("iliacus", "time step", "ok", 3.175, 0.33), ("iliacus", "collision, sdf", "suspect", 0.016, math.nan),
            ("iliacus", "rounding", math.nan, 0.0001, math.nan), ("psoas", "time step", "ok", 1.2, 0.001),
            ("psoas", "collision, sdf", "diverged", math.nan, math.nan)]
    table = pd.DataFrame([(f"lhdl/{row[0]}", *row) for row in rows], columns=["scene", "muscle", "source", "status", "shape_mm", "left_mm"])
    table.to_csv(small.folder / "paper-lhdl" / "budget.csv", index=False)
    text = block(small, "budget_by_muscle paper-lhdl")
    assert text.startswith("| source of error | iliacus, mm | psoas, mm |\n")
    for row in ("| time step | 3.2 ± 0.33 | 1.2 |", "| collision, sdf | 0.016 (suspect) | diverged |", "| rounding | below 0.001 | - |"):
        assert row in text
    assert "psoas" not in block(small, "budget_by_muscle paper-lhdl muscle=iliacus")


@pytest.fixture
def rehearsal(tmp_path, monkeypatch):
    """publish with studies that only leave what fake runs hold; gives (exit code, folder)."""
    def study(command, **_):
        out = Path(command[command.index("--out") + 1])
        if not (out / "raw" / "a").exists():
            fake_runs.write_run(out / "raw" / "a", "synthetic/iliacus", "voxel")
        (out / "tables").mkdir(exist_ok=True)
        shutil.copyfile(PROJECT / "reports" / "measured" / "paper-synthetic" / "table_2_times.csv",
                        out / "tables" / "table_2_times.csv")
        for name in ("table_3_frame_times", "table_4_depths", "table_5_pairs") if "--scene" in command else ():
            (out / "tables" / f"{name}.csv").write_text("muscle,backend\n")
        return subprocess.CompletedProcess(command, 3 if "speed" in command[1] else 0)

    monkeypatch.setattr(publish.subprocess, "run", study)

    def run(*more):
        return publish.main(["--quick", "--musclebench", sys.executable, "--out", str(tmp_path / "out"), *more])

    return run, tmp_path / "out"


def test_a_rehearsal_leaves_the_projects_pages_alone(rehearsal, capsys):
    run, out = rehearsal
    before = {name: path.read_text() for name, path in PAGES.items()}
    assert run("--only", "paper") == 0
    assert {name: path.read_text() for name, path in PAGES.items()} == before
    page = (out / "pages" / "reports/paper.md").read_text()
    assert "commit abc1234, A processor" in page and "[1/2] paper-synthetic" in capsys.readouterr().out


def test_a_publication_is_of_one_commit_and_machine(rehearsal, capsys):
    """What another commit or machine has left is refused with the folder to remove; without it all share a name."""
    run, out = rehearsal
    folder = fake_runs.write_run(out / "budget-synthetic" / "raw" / "a", "synthetic/iliacus", "voxel")
    record = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(record | {"machine": record["machine"] | {"cpu": "Another"}}))
    assert run("--only", "paper", "--only", "budget") == 1
    told = [line for line in capsys.readouterr().err.splitlines() if "another machine" in line]
    assert len(told) == 1 and "(Another, not A processor)" in told[0] and f"remove {folder.parents[1]}" in told[0]
    assert Measured(out / "measured").source("budget-synthetic").machine != "Another"
    shutil.rmtree(folder.parents[1])
    run("--only", "paper", "--only", "budget")
    kept = Measured(out / "measured")
    names = {kept.source(f"{kind}-synthetic").publication for kind in ("paper", "budget")}
    assert len(names) == 1 and names != {""}


def test_pictures_come_from_studies_that_were_taken_over(rehearsal, tmp_path, monkeypatch):
    """One that ended badly keeps the picture that its measured tables are of."""
    reports, (_, out) = tmp_path / "project" / "reports", rehearsal
    (reports / "gallery").mkdir(parents=True)
    names = ("paper-synthetic", "speed-synthetic")
    for name in names:
        (out / name / "figures").mkdir(parents=True)
        (out / name / "figures" / "times.png").write_text("new")
        (reports / "gallery" / f"{name}.png").write_text("old")
    page = "".join(f"<!-- picture: {name} times -->\n![x](reports/gallery/{name}.png)\n<!-- end -->\n"
                   for name in names)
    (tmp_path / "project" / "README.md").write_text(page)
    monkeypatch.setattr(publish, "PROJECT", tmp_path / "project")
    monkeypatch.setattr("musclebench.options.publish.check_tree", lambda: None)
    only = [word for kind in ("paper", "speed") for word in ("--only", kind)]
    assert publish.main(["--musclebench", sys.executable, "--out", str(out), *only]) == 1
    assert [(reports / "gallery" / f"{name}.png").read_text() for name in names] == ["new", "old"]


def test_a_study_that_fails_is_told_and_the_others_are_written(rehearsal, capsys):
    run, out = rehearsal
    assert run("--only", "paper", "--only", "speed") == 1
    told = capsys.readouterr()
    assert "speed-synthetic ended with 3" in told.err and "Not all was published." in told.out
    assert (out / "measured" / "paper-synthetic" / "source.json").is_file()


def test_factors_are_those_of_the_backend_that_is_named():
    """Of a study with choices of several libraries."""
    told = block(REPORTS, "factors accuracy-lhdl fcl muscle=gluteus_maximus,choice=default|OBB")
    rows = pd.read_csv(REPORTS.folder / "accuracy-lhdl" / "fcl_factors.csv").set_index(["muscle", "choice"])
    assert f"{rows.loc[('gluteus_maximus', 'OBB'), 'time_ms']:.2f}" in told and told.count("gluteus maximus") == 2
    with pytest.raises(Problem, match="box2d_factors"):
        block(REPORTS, "factors accuracy-lhdl box2d muscle=iliacus")
