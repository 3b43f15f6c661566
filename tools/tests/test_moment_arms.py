"""Moment arms beside published ones: reading them, comparing, the command."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import fake_registry
import moment_arms
from musclebench.cases.case import Folders
from musclebench.experiments.experiment_file import experiment_path, of_project
from musclebench.experiments.selection import scenes_with_other_muscles
from musclebench.experiments.swept_case import SweptCase
from musclebench.experiments.sweeps import Configuration
from musclebench.figures.moment_arms import draw_moment_arms
from musclebench.moment_arms.moment_report import arm_table, course_of
from musclebench.moment_arms.published import read_published
from musclebench.program.cli import Problem
from musclebench.results.run_folder import Run

SAME_HIP = "muscle,hip_flexion_deg,fibres,min_mm,p10_mm,mean_mm,p90_mm,max_mm\n" \
           "iliacus,0,100,-40,-35,-30,-25,-20\niliacus,50,100,-50,-45,-40,-35,-30\ngluteus_maximus,0,100,30,40,60,80,90\n" \
           "psoas,0,100,-25,-24,-21,-18,-17\n"
ELEMENTS = "muscle,hip_flexion_deg,bound,moment_arm_mm\niliacus,0,upper,32\niliacus,60,upper,50\niliacus,0,lower,20\n" \
           "iliacus,60,lower,25\ngluteus_maximus,0,upper,66\ngluteus_maximus,0,lower,14\n"
ARNOLD = "hip_flexion_deg,psoas_subject_1_mm,psoas_subject_2_mm,psoas_subject_3_mm\n0,24,28,29\n"
MEASURED = "hip_flexion_deg,gluteus_maximus_mm\n0,76.8\n60,51.1\n"
DOSTAL = "hip_flexion_deg,gluteus_medius_flexion_mm\n0,-8.8\n"


@pytest.fixture
def data(tmp_path):
    folder = tmp_path / "data" / "moment_arms"
    folder.mkdir(parents=True)
    for name, text in (("modenese_kohout_2020.csv", SAME_HIP), ("blemker_delp_2005.csv", ELEMENTS),
                       ("nemeth_ohlsen_1985.csv", MEASURED), ("dostal_1986.csv", DOSTAL), ("arnold_2000.csv", ARNOLD)):
        (folder / name).write_text(text)
    return folder.parent


def band(angles, mean):
    """fibres.csv of a muscle whose fibres differ by 10 mm either way."""
    mean = np.asarray(mean, dtype=float)
    columns = {f"{name}_moment_arm_m": 1e-3 * (mean + off) for name, off in
               (("min", -10), ("p10", -8), ("mean", 0), ("p90", 8), ("max", 10))}
    return pd.DataFrame({"frame": range(len(mean)), "angle_deg": angles, "moment_arm_error_m": 1e-4} | columns)


def run_with(fibres):
    fibres = fibres if "muscle" in fibres else fibres.assign(muscle="iliacus")
    return Run(Path("nowhere"), {"status": "ok", "case": {"scene": "lhdl/iliacus"}}, pd.DataFrame(), fibres=fibres)


def test_published_arms_have_the_sign_of_the_program(data):
    published = read_published(data)
    iliacus = published["iliacus"]
    assert iliacus.same_hip["mean"].at(25) == pytest.approx(-35)
    assert np.isnan(iliacus.same_hip["mean"].at(53))
    # Flexion positive as published; a flexor grows shorter in flexion.
    assert iliacus.finite_elements["lower"].at(0) == -32 and iliacus.finite_elements["upper"].at(0) == -20
    assert published["gluteus_maximus"].finite_elements["lower"].at(0) == 14
    assert published["gluteus_maximus"].measured.at(0) == 76.8
    assert iliacus.measured is None and published["psoas"].measured.at(0) == -27


def test_without_data_nothing_is_published(tmp_path):
    assert read_published(None) == {} and read_published(tmp_path) == {}
    table = arm_table({"iliacus": course_of([run_with(band([0, 2, 4], [1, 2, 3]))])}, {}, {})
    assert "nothing is published" in table.caption and set(table.rows["holds"]) == {"-"}


@pytest.mark.parametrize("text, words", [("muscle,angle\niliacus,0\n", "lacks the columns hip_flexion_deg"), (None, "can't be read")])
def test_a_damaged_file_is_one_line(data, text, words):
    file = data / "moment_arms" / "modenese_kohout_2020.csv"
    file.write_text(text) if text else file.unlink()
    with pytest.raises(Problem, match="modenese_kohout_2020.csv: .*" + words):
        read_published(data)


def test_a_course_joins_both_ways_from_rest():
    course = course_of([run_with(band([0, -2], [9, 0])), run_with(band([0, 2, 4], [1, 2, 3]))])
    assert list(course["angle_deg"]) == [-2, 0, 2, 4] and list(course["mean_mm"]) == [0, 1, 2, 3]
    assert course["p10_mm"].iloc[1] == pytest.approx(-7)


def forces(angles, torques, fibre_force, muscle="iliacus", untold=()):
    """forces.csv: in each frame an attachment and contact with the bone that turns, and a joint where contact is told."""
    rows = []
    for frame, (angle, torque) in enumerate(zip(angles, torques), start=1):
        common = {"frame": frame, "angle_deg": angle, "muscle": muscle, "force_n": 1.0}
        rows.append(common | {"source": "attachment", "torque_n_m": torque - 0.1, "fibres_n": fibre_force, "active_n": 10,
                              "passive_n": -0.5})
        rows.append(common | {"source": "attachment", "fibres_n": fibre_force, "active_n": 10, "passive_n": -0.4})  # stands
        rows.append(common | {"source": "bone", "torque_n_m": 0.1})
        if frame not in untold:
            rows.append(common | {"muscle": None, "source": "joint", "torque_n_m": torque})
    return pd.DataFrame(rows)


def test_torque_over_force_stands_beside_the_slope_of_the_length():
    run = replace(run_with(band([0, 2, 4, 6], [-20, -20, -20, -20])), forces=forces([2, 4, 6], [0.2, 0.21, 0.4], 10, untold=(2,)))
    course = course_of([run]).set_index("angle_deg")
    assert course.loc[2, "torque_mm"] == pytest.approx(-20) and course.loc[2, "others_percent"] == pytest.approx(5)
    assert course.loc[[0, 4], "torque_mm"].isna().all() and course.loc[6, "torque_mm"] == pytest.approx(-40)
    assert "torque_mm" not in course_of([run_with(band([0, 2, 4], [1, 2, 3]))])
    pushed = pd.DataFrame([{"frame": 3, "angle_deg": 6, "muscle": "iliacus", "source": "muscle", "force_n": 0.1}])
    course = course_of([replace(run, forces=pd.concat([run.forces, pushed]))]).set_index("angle_deg")
    assert np.isnan(course.loc[6, "torque_mm"]) and course.loc[2, "torque_mm"] == pytest.approx(-20)


def test_of_an_angle_that_is_passed_twice_the_later_counts():
    run = run_with(band([0, -2, -4, -2.0000000001, 0, 2], [9, 9, 9, -1, -2, -3]))
    run = replace(run, forces=forces([-2, -4, -2.0000000001, 0, 2], [0.9, 0.9, 0.01, 0.02, 0.03], 10))
    course = course_of([run])
    assert list(course["angle_deg"]) == [-4, -2, 0, 2] and list(course["mean_mm"])[1:] == pytest.approx([-1, -2, -3])
    assert list(course["torque_mm"])[1:] == pytest.approx([-1, -2, -3])


def test_arms_that_part_are_not_compared(data):
    angles = [0, 10, 20]
    passive = {"iliacus": course_of([run_with(band(angles, [-30, -32, -34]))])}
    active = run_with(band(angles, [-30, -32, -34]))
    for torque, word in ((0.3, "yes"), (0.2, "dL/dθ and torque part by 12.0 mm")):
        course = course_of([replace(active, forces=forces([10, 20], [torque, torque], 10))])
        row = arm_table(passive, {"iliacus": course}, read_published(data)).rows.set_index("angle_deg").loc[10]
        assert row["active_holds"] == word and np.isnan(row["active_difference_mm"]) == (word != "yes")
        assert row["torque_mm"] == pytest.approx(-100 * torque) and row["active_mm"] == pytest.approx(-32)


def test_a_scene_of_several_gives_the_muscles_that_have_none_of_their_own():
    alone = run_with(band([0, 2, 4], [1, 2, 3]).assign(muscle="iliacus"))
    both = Run(Path("nowhere"), {"status": "ok", "case": {"scene": "lhdl/flexors"}}, pd.DataFrame(), fibres=pd.concat(
        [band([0, 2, 4], [7, 8, 9]).assign(muscle="iliacus"), band([0, 2, 4], [4, 5, 6]).assign(muscle="psoas")]))
    found = moment_arms.runs_by_muscle([both, alone])
    assert list(found) == ["iliacus", "psoas"]
    assert list(course_of(found["iliacus"])["mean_mm"]) == [1, 2, 3] and list(course_of(found["psoas"])["mean_mm"]) == [4, 5, 6]


def test_scenes_with_other_muscles_are_taken_in():
    registry = fake_registry.registry()
    own = [f"lhdl/{muscle}" for muscle in ("adductor_brevis", "gluteus_maximus", "gluteus_medius", "iliacus")]
    assert scenes_with_other_muscles(own, "lhdl", registry) == ["lhdl/flexors"]
    assert scenes_with_other_muscles(["synthetic/hip"], "synthetic", registry) == []


def test_the_goal_is_five_millimetres_or_fifteen_percent(data, tmp_path):
    angles = np.arange(-10, 61, 5)
    courses = {"iliacus": course_of([run_with(band(angles, -33.0 - 0.25 * angles))]),
               "gluteus_maximus": course_of([run_with(band(angles, 51.5 + 0 * angles))])}
    published = read_published(data)
    active = course_of([run_with(band(angles, -33.0 - 0.25 * angles))])
    rows = arm_table(courses, {}, published).rows.set_index(["muscle", "angle_deg"])
    assert rows.loc[("iliacus", 0), "difference_mm"] == pytest.approx(-3) and rows.loc[("iliacus", 0), "holds"] == "yes"
    assert rows.loc[("iliacus", 50), "difference_percent"] == pytest.approx(-13.75)
    assert rows.loc[("iliacus", 50), "holds"] == "yes" and rows.loc[("iliacus", 60), "holds"] == "-"
    assert rows.loc[("gluteus_maximus", 0), "holds"] == "yes"  # 8.5 mm, and 14 % of 60
    assert all(path.is_file() for path in draw_moment_arms(courses, {"iliacus": active}, published, tmp_path / "figure"))


def test_the_table_says_that_the_motion_was_squeezed(tmp_path):
    (tmp_path / "experiment.json").write_text('{"schema_version": 1, "cases": [], "settings": {"frames_limit": "12"}}')
    course = course_of([run_with(band([0, 30], [-30, -40]))])
    table, files = moment_arms.write_tables({"iliacus": course}, {}, {}, tmp_path)
    assert table.caption.endswith("squeezed into 12 frames, so that bones move faster.")
    assert all("into 12 frames" in path.read_text() for path in files if path.suffix in (".md", ".tex"))


def test_passive_muscles_go_from_rest_to_both_ends_and_active_ones_over_the_range(tmp_path):
    groups = {group.name: group for group in of_project("moment_arms").groups}
    assert list(groups) == ["active_course", "passive_flexion", "passive_extension"]
    assert [group.frames for group in groups.values()] == [(61,), (45,), (5,)]

    def arguments(name):
        scene = fake_registry.scene("synthetic/iliacus", groups[name].frames[0])
        return SweptCase(scene, groups[name], Configuration("bvh")).arguments(Folders(tmp_path))

    active, passive = arguments("active_course"), arguments("passive_extension")
    assert "fibre_force:level=0.05,rise_s=0.0" in active and "settle_substeps=2000" in active and "--forces" in active
    assert {"course=rest_first", "from_deg=-16", "to_deg=90", "substeps=160", "time_step_s=0.000125"} <= set(active)
    assert active[active.index("--snapshots") + 1] == "0,30,61"
    assert "to_deg=-10" in passive and "settle_substeps=100" in passive and "--effect" not in passive
    assert passive[passive.index("--fibres") + 1] == "100" and passive[passive.index("--snapshots") + 1] == "0"


@pytest.mark.parametrize("old, new, words", [
    ('name = "active_course"', 'name = "tense"', "'tense'.*begin with passive_ or active_"),
    ('name = "passive', 'name = "active_passive', "none of its .* begins with passive_"),
    ('[[cases]]', '[[cases]]\nmode = "replay"', "mode run"),
])
def test_a_file_of_ones_own_tells_passive_from_active(tmp_path, old, new, words):
    file = tmp_path / "own.toml"
    file.write_text(experiment_path("moment_arms").read_text().replace(old, new))
    options = moment_arms.parse_arguments(["--musclebench", "no", "--experiment", str(file)])
    with pytest.raises(Problem, match=words):
        moment_arms.asked_experiment(options)


def test_a_file_that_follows_no_fibres_or_tells_an_angle_twice_is_refused(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(experiment_path("moment_arms").read_text().replace('"--fibres", "100", ', ""))
    with pytest.raises(Problem, match="follows no fibres"):
        moment_arms.asked_experiment(moment_arms.parse_arguments(["--musclebench", "no", "--experiment", str(file)]))
    with pytest.raises(Problem, match="more than one tells of 2 degrees"):
        course_of([run_with(band([0, 2, 4], [1, 2, 3])), run_with(band([0, 2, 4], [1, 2, 3]))])


def test_passive_only_leaves_the_active_out():
    options = moment_arms.parse_arguments(["--musclebench", "no", "--passive-only"])
    assert [group.name for group in moment_arms.asked_experiment(options).groups] == ["passive_flexion", "passive_extension"]


@pytest.mark.parametrize("arguments, words", [(["--jobs", "0"], "--jobs 0"), (["--backend", "magic"], "--backend magic"),
                                              (["--experiment", "none.toml"], "none.toml"), (["--muscle", "biceps"], "'biceps'")])
def test_bad_input_is_one_line(tmp_path, capfd, arguments, words):
    program = Path(__file__).resolve().parent / "fake_musclebench.py"
    code = moment_arms.main(["--musclebench", str(program), "--out", str(tmp_path / "out"), *arguments])
    errors = capfd.readouterr().err
    assert code == 2 and errors.count("\n") == 1 and words in errors


def test_the_shell_wrapper_answers_for_help_without_building():
    wrapper = Path(moment_arms.__file__).with_name("moment-arms")
    done = subprocess.run([wrapper, "--help"], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and "usage: tools/moment-arms [" in done.stdout
