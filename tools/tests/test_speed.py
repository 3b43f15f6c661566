"""The speed table from end to end with stand-ins for both programs, and the pieces that it is made of."""

import itertools
import json
import math
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

import experiment
import fake_registry
import fake_runs
import speed
from fake_sweep import FakeScenes, swept
from musclebench.cases.case import Folders
from musclebench.cases.case_queue import CaseQueue
from musclebench.experiments import kernels as kernel_cases
from musclebench.experiments.expansion import Expansion
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.kernels import MICRO_PROGRAM
from musclebench.program.machine_state import Reading
from musclebench.program.registry import parse_registry
from musclebench.results.run_folder import read_runs
from musclebench.results import samples
from musclebench.speed import bars, quick, targets
from musclebench.speed.kernel_results import read_kernels

PROGRAM = Path(__file__).resolve().parent / "fake_speed.py"
TOOLS = PROGRAM.parent.parent
MUSCLES = ("adductor_brevis", "iliacus")
REGISTRY = fake_registry.registry()
SCENES = tuple(fake_registry.scene(f"lhdl/{muscle}") for muscle in MUSCLES)
ILIACUS = (fake_registry.scene("synthetic/iliacus"),)
QUICK_ILIACUS = (fake_registry.scene("synthetic/iliacus", quick.FRAMES),)
FILE = of_project("speed")
FOLDERS = Folders(Path("out"))


def of_group(name: str, cases: list) -> list:
    return [case for case in cases if case.group.name == name]


def of_kernels(cases: list) -> list:
    return [case for case in cases if case.group.mode == "kernels"]


class Table:
    """Runs tools/speed.py on two muscles."""

    def __init__(self, folder: Path, monkeypatch, capfd):
        self.out, self._log, self._monkeypatch, self._capfd = folder / "out", folder / "log", monkeypatch, capfd

    def __call__(self, *more, behaviour=""):
        """(exit code, standard output, standard error, calls of the programs but `list`)"""
        self._monkeypatch.setenv("FAKE_BEHAVIOUR", behaviour)
        self._monkeypatch.setenv("FAKE_LOG", str(self._log))
        self._log.write_text("")
        muscles = [word for muscle in MUSCLES for word in ("--muscle", muscle)]
        code = speed.main(["--musclebench", str(PROGRAM), "--micro", str(PROGRAM), "--out", str(self.out), *muscles,
                           "--repetitions", "1", *more])
        text, errors = self._capfd.readouterr()
        return code, text, errors, [line for line in self._log.read_text().splitlines() if not line.endswith(("list", "--version"))]

    def rows(self) -> dict[str, dict]:
        """The lines of the table by what they are about."""
        written = json.loads((self.out / "speed.json").read_text())["rows"]
        return {row["what"]: row for row in written if not row["part"]}


@pytest.fixture
def table(tmp_path, monkeypatch, capfd) -> Table:
    """On a quiet machine, whatever else this one does."""
    moments = itertools.count(step=10**9)
    monkeypatch.setattr(kernel_cases, "reading", lambda core: Reading(next(moments), 0, 7, 0.5, 2500.0, None))
    return Table(tmp_path, monkeypatch, capfd)


@dataclass
class Measured:
    """What the command has answered, and the folder that it left."""

    out: Path
    answer: tuple | None = None


@pytest.fixture(scope="module")
def once(tmp_path_factory) -> Measured:
    return Measured(tmp_path_factory.mktemp("measured") / "out")


@pytest.fixture
def measured(table, once) -> Table:
    """After `table()`, which runs for the first of these tests; the others get what it left. `answer`: what it said."""
    if once.answer is None:
        answer = table()
        shutil.copytree(table.out, once.out)
        once.answer = answer
    else:
        shutil.copytree(once.out, table.out)
    table.answer = once.answer
    return table


def test_the_table_has_every_bar_with_its_median_spread_and_verdict(measured):
    code, text, _, _ = measured.answer
    rows = measured.rows()
    assert code == 0
    expected = {
        "collision time, bvh / voxel 64": (2.5, "no"),
        "collision time, sdf 64 / voxel 64": (1.2, "yes"),
        "collision time, bvh no cache / voxel 64": (10.0, ""),
        "sdf value + gradient / voxel test, near points": (11, "no"),
        "sdf build per node / cold closest point of bvh near": (0.25, "yes"),
        "MB of sdf 64, a bone": (7.6, "yes"),
        "two threads over one, detect of all nodes, bvh": (1.8, "yes"),
        "two threads over one, detect of all nodes, sdf": (1.5, "no"),
        "two threads over one, sdf build": (1.9, "yes"),
        "exponent x of a step of bvh over the muscle's nodes (time ~ nodes^x)": (1.0, "yes"),
        "exponent x of a step of bvh over log(triangles)": (0.0, "yes"),
        "heap allocations in a frame after the second": (3.0, "no"),
        "edge length, ns a constraint: one by one / SIMD lanes": (4.0, "yes"),
        "edge length: PBDlib's formulas / SIMD lanes": (15.0, ""),
        "bending, ns a constraint: one by one / SIMD lanes (of AVX-512)": (4.0, "no"),
        "bending: one by one / SIMD lanes of AVX2": (3.2, "no"),
        "bending: PBDlib's formulas / SIMD lanes": (6.0, ""),
        "loop without collision, `standard`: scalar / SIMD lanes, one thread": (4.0, "yes"),
        "two threads over one, loop without collision, `standard`": (1.6, "no"),
        "a frame with collision over one without, `paper`, scalar constraints": (1.2, ""),
        "a frame with collision over one without, `paper`, SIMD lanes, one thread": (2.0, ""),
        "frames a second with sdf, `paper`, one thread: over those of scalar constraints": (3.0, "yes"),
        "frames a second with sdf, `standard`, two threads: over those of scalar constraints": (5.0, "yes"),
        "a frame (20 ms) of four muscles in contact, `standard`, sdf, two threads, ms": (30.6, "yes"),
        "two threads over one, four muscles in contact, `standard`, sdf": (2.0, ""),
    }
    for what, (value, held) in expected.items():
        row = rows[what]
        assert row["measured"] == pytest.approx(value, abs=1e-9) and row["held"] == held, what
        assert row["low"] <= row["measured"] + 1e-9 and row["measured"] <= row["high"] + 1e-9, what
        assert what in text
    setup = rows["CPU before the first frame / of a judged run whose fields are stored, largest muscle"]
    not_judged = rows["CPU before the first frame, less structures / of a run without the Referee"]
    assert (setup["measured"], setup["held"]) == (pytest.approx(0.125), "yes")
    assert (not_judged["measured"], not_judged["held"]) == (pytest.approx(0.1), "")
    assert setup["note"].endswith("iliacus")
    assert rows["heap allocations in a frame after the second"]["note"] == "voxel/backtrack"
    assert rows["sdf value + gradient / voxel test, near points"]["note"] == "femur"


def test_the_table_says_whose_the_backends_are(measured):
    for name in ("speed.md", "speed.txt"):
        assert "bvh: library of bvh" in (measured.out / name).read_text()


def test_all_forms_of_the_table_say_the_same(measured):
    csv = pd.read_csv(measured.out / "speed.csv")
    written = json.loads((measured.out / "speed.json").read_text())
    assert len(csv) == len(written["rows"]) and written["build"] == {"git": "abc"}
    markdown = (measured.out / "speed.md").read_text()
    for what in measured.rows():
        assert f"| {what} |" in markdown
    assert (csv["part"].fillna("") == "bvh / voxel").sum() == len(MUSCLES)


def test_kernels_tell_build_machine_and_its_state_as_the_program_does(measured):
    raw = measured.out / "raw"
    kernels, race = (json.loads((raw / name / "run.json").read_text())
                     for name in ("kernels-queries-r0", "iliacus-bvh-r0"))
    assert all(kernels[key] == race[key] for key in ("schema_version", "build", "machine"))
    assert kernels["wall_ns"] == 1e9 and kernels["machine_state"] == {
        "involuntary_context_switches": 0, "voluntary_context_switches": 0, "governor": None,
        "load_average_1m": {"before": 0.5, "after": 0.5}, "cpu_mhz": {"before": 2500.0, "after": 2500.0}}


def test_rows_of_a_busy_machine_are_marked(measured):
    """Of a race, the set-up and kernels; not of counts, which other work does not change."""
    for name in ("kernels-queries-r0", "kernels-allocations-r0", "iliacus-bvh-r0"):
        path = measured.out / "raw" / name / "run.json"
        busy = {"wall_ns": 1e9, "machine_state": {"involuntary_context_switches": 900}}
        path.write_text(json.dumps(json.loads(path.read_text()) | busy))
    measured("--report-only")
    marked = {what for what, row in measured.rows().items() if (row["note"] or "").endswith("*")}
    near = "sdf value + gradient / voxel test, near points"
    assert near in marked and not any("allocations" in what or "two threads" in what for what in marked)
    parts = {row["part"] for row in json.loads((measured.out / "speed.json").read_text())["rows"]
             if row["part"] and (row["note"] or "").endswith("*")}
    assert {"bvh / voxel", "set-up / run, bvh"} <= parts


def test_the_mark_of_a_row_is_that_of_what_it_shows():
    parts = [targets.Row("a", measured=samples.exact(1.0)), targets.Row("b", measured=samples.exact(2.0))]
    parts[0].is_disturbed = True
    assert targets.worst("row", parts, "<= 2", at_most=2).remark == ""
    assert targets.worst("row", parts[:1], "<= 2", at_most=2).remark == "*"


def test_what_is_not_built_or_not_known_says_so(measured):
    code, _, _, calls = measured.answer
    rows = measured.rows()
    near = rows["Embree's point query / cold bvh with sign, near"]
    assert code == 0 and near["measured"] is None and near["held"] == ""
    assert near["note"] == "not built: musclebench_embree" and not any("embree" in call for call in calls)
    assert rows["adaptive sdf, p99 error 0.05 mm: bytes / uniform grid's"]["note"] == "not built: sdf: no 'max_error_mm'"


def test_a_backend_that_is_not_built_is_no_failure(table, tmp_path, monkeypatch):
    built = {name: fake_registry.study_of(name) for name in ("voxel", "sdf")}
    (tmp_path / "registry.json").write_text(fake_registry.with_studies(built))
    monkeypatch.setenv("FAKE_REGISTRY", str(tmp_path / "registry.json"))
    code, _, _, calls = table()
    assert code == 0 and "collision time, bvh / voxel 64" not in table.rows()
    assert table.rows()["collision time, sdf 64 / voxel 64"]["measured"] == pytest.approx(1.2)
    assert not any("--backend bvh" in call for call in calls)


def test_a_failure_is_told_and_leaves_the_other_rows(measured):
    for name in ("kernels-queries-r0", "iliacus-bvh-r0"):  # one to fail, one that comes after it
        shutil.rmtree(measured.out / "raw" / name)
    code, _, errors, _ = measured(behaviour="voxel_test=crash")
    assert code == 1 and "kernels-queries-r0: failed" in errors
    row = measured.rows()["sdf value + gradient / voxel test, near points"]
    assert row["measured"] is None and "something went wrong" in row["note"]
    assert measured.rows()["collision time, bvh / voxel 64"]["measured"] == pytest.approx(2.5)


def test_complete_cases_are_not_run_again_and_failed_ones_are(measured):
    shutil.rmtree(measured.out / "raw" / "kernels-allocations-r0")
    assert measured(behaviour="allocations=crash")[0] == 1
    code, text, _, calls = measured()
    assert code == 0 and len(calls) == 1 and "allocations" in calls[0] and "are complete already" in text
    assert measured()[3] == []


def test_cases_run_one_at_a_time_each_on_one_core_but_for_two_threads(measured):
    _, _, _, calls = measured.answer
    for call in calls:
        cores = [word for word in call.split("--")[0].split() if word.isdigit()]
        of_two = any(words in call for words in ("detect_threads", "^(loop", "^(muscles"))
        assert len(cores) == (2 if of_two else 1), call


def test_all_forms_of_the_table_say_that_the_motion_was_squeezed(measured):
    assert "squeezed" not in (measured.out / "speed.md").read_text()
    plan = measured.out / "experiment.json"
    plan.write_text(json.dumps({**json.loads(plan.read_text()), "settings": {"frames_limit": "60"}}))
    assert "squeezed into 60 frames" in measured("--report-only")[1]
    assert all("squeezed into 60 frames" in (measured.out / f"speed.{kind}").read_text() for kind in ("md", "txt"))


def test_the_report_alone_runs_nothing(measured):
    before = measured.rows()
    assert measured("--report-only")[3] == [] and measured.rows() == before
    shutil.rmtree(measured.out)
    code, _, errors, _ = measured("--report-only")
    assert code == 2 and "holds no study" in errors and len(errors.splitlines()) == 1


def test_a_round_has_everything_once_and_muscles_stay_together():
    cases, count = swept(FILE, *SCENES), len(bars.settings(REGISTRY))
    assert len({case.name for case in cases}) == len(cases)
    assert [case.repetition for case in cases] == sorted(case.repetition for case in cases)
    orders = []
    for repetition in range(3):
        races = [case for case in of_group("race", cases) if case.repetition == repetition]
        assert len(races) == len(MUSCLES) * count
        assert races[0].scene == races[count - 1].scene != races[-1].scene
        first = cases.index(races[0])
        assert cases[first:first + count] == races[:count]  # with nothing else among them
        orders.append([case.configuration.label for case in races if case.scene.key == "iliacus"])
    assert orders[0] != orders[1] or orders[1] != orders[2]
    assert all("--no-referee" in case.arguments(FOLDERS) for case in of_group("race", cases))
    once = [case for case in of_kernels(cases) if case.group.samples == 1]
    assert {case.repetition for case in once} == {0} and {case.group.name for case in once} == {"bytes", "allocations"}


def test_the_largest_muscle_is_judged_once_with_the_fields_of_its_first_race():
    cases = swept(FILE, *SCENES)
    judged = of_group("judged", cases)
    assert len(judged) == len(bars.settings(REGISTRY)) and {case.scene.key for case in judged} == {"iliacus"}
    assert not any("--no-referee" in case.arguments(FOLDERS) for case in judged)
    storing = {case.configuration.label for case in cases if case.configuration.stores}
    assert storing
    for case in [*judged, *of_group("race", cases)]:
        label = case.configuration.label
        builder = f"{case.scene.key}-{label}-r0" if label in storing else ""
        assert case.builder == builder and case.needs == ((builder,) if builder not in ("", case.name) else ())
        kept = [word for word in case.arguments(FOLDERS) if "structures" in word]
        assert [word.partition("=")[2] for word in kept] == ([f"out/structures/{case.scene.key}/{label}"] if builder else [])


def test_kernels_measure_the_muscle_that_is_wanted_where_it_is_raced():
    everything = swept(FILE, *fake_registry.scenes("lhdl"))
    assert {case.group.name: case.scene.name for case in of_kernels(everything)} == {
        **dict.fromkeys((group.name for group in FILE.groups if group.mode == "kernels"), "lhdl/iliacus"),
        "constraints": "lhdl/gluteus_maximus", "loop": "lhdl/gluteus_maximus", "muscles": "lhdl/hip"}
    brevis = swept(FILE, fake_registry.scene("lhdl/adductor_brevis"))
    assert {case.scene.name for case in of_kernels(brevis)} == {"lhdl/adductor_brevis", "lhdl/hip"}


def test_quick_means_less_of_everything():
    whole = swept(FILE, *ILIACUS)
    some = swept(quick.quick(FILE), *QUICK_ILIACUS)
    assert sum(case.guessed_seconds for case in some) < sum(case.guessed_seconds for case in whole) / 3
    words = of_group("race", some)[0].arguments(FOLDERS)
    assert "--frames" in words and "--no-referee" in words
    wanted = "--benchmark_repetitions=3", "--benchmark_min_time=0.02"
    assert all(set(wanted) <= set(case.arguments(FOLDERS)) for case in of_kernels(some) if case.group.samples > 1)


@pytest.mark.parametrize("name, is_in_quick", [
    ("muscle_size/bvh/100000/manual_time", True), ("muscle_size/bvh/1000000/manual_time", False),
    ("bone_size/bvh_locate/5120", True), ("bone_size/bvh_step/1310720/manual_time", False),
])
def test_quick_leaves_out_the_largest_sizes(name, is_in_quick):
    for file, expected in ((FILE, True), (quick.quick(FILE), is_in_quick)):
        patterns = [case.at("kernels").value for case in of_kernels(swept(file, *ILIACUS))]
        assert any(re.search(pattern, name) for pattern in patterns) == expected


def test_every_target_without_a_backend_is_measured_by_its_group():
    patterns = {case.group.name: case.at("kernels").value for case in of_kernels(swept(FILE, *ILIACUS))}
    for target in bars.COMMON_TARGETS:
        for kernel in (target[key] for key in ("kernel", "below") if key in target):
            assert re.search(patterns[target["group"]], kernel), kernel


def test_a_group_of_kernels_that_no_backend_names_has_no_case():
    without = fake_registry.listed()
    for backend in without["backends"]:
        backend["study"].pop("target", None)
    whole = Expansion(FILE, parse_registry(json.dumps(without), "fixture"), FakeScenes(ILIACUS))
    assert {case.group.name for case in of_kernels(whole.firsts())} == {"constraints", "allocations"}


def test_the_dry_run_lists_the_cases(table):
    code, text, _, calls = table("--dry-run")
    assert code == 0 and calls == [] and "iliacus-bvh-r0" in text and "about" in text.splitlines()[-1]


def test_the_experiment_lists_and_runs_without_the_report(tmp_path, capfd):
    """Whose kernels are in micro/ beside the program, or nowhere."""
    words = ["speed", "--musclebench", str(PROGRAM), "--muscle", "iliacus", "--repetitions", "1", "--out", str(tmp_path / "out")]
    assert experiment.main([*words, "--list-cases"]) == 0
    names = capfd.readouterr().out.split()
    assert {"iliacus-bvh-r0", "iliacus-bvh-judged-r0", "kernels-muscles-r0"} <= set(names)
    assert experiment.main([*words, "--dry-run"]) == 0 and not (tmp_path / "out").exists()
    assert f"{len(names)} cases; about" in capfd.readouterr().out.splitlines()[-1]
    assert experiment.main([*words, "--filter", "kernels-queries", "--filter", "iliacus-sdf-r0"]) == 0
    answers, times = (pd.read_csv(tmp_path / "out" / name).set_index("name") for name in ("answers.csv", "times.csv"))
    wanted = ["iliacus-sdf-r0", "kernels-queries-r0"]
    assert list(answers.loc[wanted, "status"]) == ["ok", "unsupported"]
    assert times.loc[wanted[1], "status_detail"] == "not built: musclebench_micro"


def test_nothing_runs_beside_kernels():
    cases = swept(FILE, *ILIACUS)
    kernel, race = of_group("queries", cases)[0], of_group("race", cases)[0]
    for some in ([kernel, race], [race, kernel]):
        queue = CaseQueue(some)
        assert queue.take() == some[0] and queue.take() is None


def test_a_scene_of_several_muscles_is_raced(table):
    code, text, errors, _ = table("--scene", "synthetic/hip", "--dry-run")
    assert code == 0 and "hip-bvh-r0" in text, errors


@pytest.mark.parametrize("arguments, words", [
    (["--repetitions", "0"], "--repetitions 0: must be 1 or more"),
    (["--micro", "/nowhere/micro"], "/nowhere/micro: no such program"),
    (["--data", "/nowhere"], "/nowhere: has no lhdl.json"),
    (["--muscle", "biceps"], "--muscle 'biceps': no synthetic scene has this muscle"),
])
def test_bad_options_are_answered_in_one_line(table, arguments, words):
    code, _, errors, calls = table(*arguments)
    assert code == 2 and words in errors and len(errors.splitlines()) == 1 and calls == []


def test_a_file_that_is_no_result_counts_as_none(tmp_path):
    folder = tmp_path / "kernels-queries-r0"
    folder.mkdir()
    (folder / "kernels.json").write_text("{")
    (folder / "run.json").write_text('{"case": {"group": "queries", "repetition": 0}}')
    assert read_kernels(tmp_path).samples == {}


def test_ratios_pair_samples_of_the_same_moment():
    slow_machine = pd.Series([1.0, 1.0, 5.0, 1.0, 1.0, 5.0])
    estimate = samples.ratio(3 * slow_machine, slow_machine)
    assert (estimate.value, estimate.low, estimate.high) == (3, 3, 3)
    assert math.isnan(samples.ratio(slow_machine, pd.Series(dtype=float)).value)


def test_few_samples_have_no_interval():
    estimate = samples.median(pd.Series([1.0, 2.0, 3.0]))
    assert estimate.value == 2 and math.isnan(estimate.low)


def test_the_power_is_that_of_the_growth():
    times = {size: pd.Series([factor * size**1.5 for factor in (1.0, 1.1, 0.9, 1.0, 1.2)]) for size in (10, 100, 1000)}
    assert samples.power(times).value == pytest.approx(1.5)
    assert math.isnan(samples.power({10: times[10], 100: times[100]}).value)


@pytest.mark.parametrize("value, at_most, at_least, held", [
    (2, 2, None, "yes"), (2.1, 2, None, "no"), (3, None, 3, "yes"), (2.9, None, 3, "no"), (1, None, None, ""),
    (float("nan"), 2, None, ""),
])
def test_a_bar_is_held_up_to_its_value(value, at_most, at_least, held):
    estimate = samples.median(pd.Series([value]))
    assert targets.Row("what", "target", at_most, at_least, estimate).held == held


def test_scenes_that_share_a_muscle_are_raced_apart(tmp_path):
    for name, scene in (("iliacus-bvh-r0", "synthetic/iliacus"), ("lhdl-iliacus-bvh-r0", "lhdl/iliacus")):
        fake_runs.write_run(tmp_path / name, scene, "bvh")
    runs = read_runs(tmp_path)
    assert [(run.muscle, targets.label_of(run)) for run in runs] == [("synthetic-iliacus", "bvh"), ("lhdl-iliacus", "bvh")]


def test_the_worst_part_stands_for_the_row():
    parts = [targets.Row(str(value), measured=samples.exact(value), note=f"at {value}") for value in (1.0, 3.0, 2.0)]
    assert targets.worst("row", parts, "<= 2", at_most=2).note == "at 3.0"
    assert targets.worst("row", parts, ">= 2", at_least=2).note == "at 1.0"
    parts.append(targets.Row("unknown", note="why"))
    assert targets.worst("row", parts, "<= 2", at_most=2).note == "at 3.0; 1 of 4 missing"
    assert targets.worst("row", parts[-1:], "<= 2", at_most=2).note == "why"


def test_the_shell_wrapper_answers_for_help_without_building():
    result = subprocess.run([str(TOOLS / "speed"), "--help"], capture_output=True, text=True, timeout=60,
                            env={**os.environ, "COLUMNS": "100"}, check=False)
    assert result.returncode == 0 and "--quick" in result.stdout


def test_the_plan_asks_for_kernels_that_there_are():
    program = Path(os.environ.get("MUSCLEBENCH_BINARY", "")).parent / "micro" / MICRO_PROGRAM
    if not program.is_file():
        pytest.skip("MUSCLEBENCH_BINARY names no program with kernels beside it")
    listed = subprocess.run([str(program), "--benchmark_list_tests"], capture_output=True, text=True, check=True).stdout
    for file in (FILE, quick.quick(FILE)):
        for case in of_kernels(swept(file, *ILIACUS)):
            if case.group.program == MICRO_PROGRAM:
                pattern = re.compile(case.at("kernels").value)
                assert any(pattern.search(name) for name in listed.splitlines()), case.group
