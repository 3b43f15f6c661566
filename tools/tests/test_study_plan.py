"""Which cases the accuracy study has, in which order, and what may run beside what."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

import accuracy
import fake_registry
from fake_sweep import expansion, swept
from musclebench.cases.case import Folders
from musclebench.cases.case_queue import CaseQueue
from musclebench.experiments.expansion import in_shard, stride_of
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.record_case import RecordCase
from musclebench.experiments.sweeps import Configuration

FOLDERS = Folders(Path("out"), Path("data"))
MUSCLES = fake_registry.scenes("lhdl")
ILIACUS = fake_registry.scene("lhdl/iliacus")
FILE = of_project("accuracy")


def plan(*scenes, file=FILE):
    return swept(file, *(scenes or [ILIACUS]))


def quick(*scenes):
    return swept(replace(FILE, repetitions=1, groups=tuple(map(accuracy._quick, FILE.groups))), *scenes)


def measured(*scenes, file=FILE):
    return [case for case in plan(*scenes, file=file) if not isinstance(case, RecordCase)]


def of_group(cases, name):
    return [case for case in cases if not isinstance(case, RecordCase) and case.group.name == name]


def seconds(cases):
    return sum(case.guessed_seconds for case in cases if not case.is_too_long)


def test_names_are_unique_and_every_muscle_is_recorded_first():
    cases = plan(*MUSCLES)
    assert len({case.name for case in cases}) == len(cases)
    assert [case.scene for case in cases[:4]] == list(MUSCLES)
    assert all(isinstance(case, RecordCase) for case in cases[:4])


def test_the_full_study_has_what_the_study_asks_for():
    firsts = [case for case in measured() if case.repetition == 0]
    count = Counter((case.group.name, case.configuration.backend) for case in firsts)
    assert count["replay", "voxel"] == count["coupled", "voxel"] == 10 and count["probe", "voxel"] == 9
    assert count["replay", "sdf"] == count["coupled", "sdf"] == 14 and count["probe", "sdf"] == 13
    assert count["replay", "fcl"] > 20 and count["coupled", "fcl"] == 5  # one for each distinct answer
    assert count["replay", "bvh"] == count["coupled", "bvh"] == 2 and count["replay", "brute_force"] == 1
    assert count["coupled", "null"] == 1 and count["replay", "null"] == 0
    cells = {dict(c.configuration.parameters).get("cells") for c in firsts if c.configuration.backend == "voxel"}
    assert {16, 32, 64, 128, 256} <= cells


@pytest.mark.parametrize("backend", ["voxel", "sdf", "bvh"])
def test_the_study_shows_runs_with_and_without_a_clearance_cache(backend):
    chosen = [c.configuration for c in measured() if c.configuration.backend == backend]
    assert {configuration.has_cache for configuration in chosen} == {True, False}


def test_repetitions_come_round_by_round_and_shuffled():
    cases = measured()
    rounds = [case.repetition for case in cases]
    assert rounds == sorted(rounds) and set(rounds) == {0, 1, 2}
    orders = [[c.name[:-3] for c in cases if c.repetition == r and c.configuration.backend == "voxel"
               and c.group.name in ("replay", "coupled")] for r in range(3)]
    assert sorted(orders[0]) == sorted(orders[1]) == sorted(orders[2])
    assert orders[0] != orders[1] != orders[2] != sorted(orders[0])
    assert plan() == plan() != plan(file=replace(FILE, seed=2))


def test_only_the_first_repetition_is_judged_and_keeps_shapes():
    for case in measured():
        words = case.arguments(FOLDERS)
        is_first = case.repetition == 0
        if case.group.name == "probe" or case.group.name.startswith(("arms", "forces")):
            continue
        assert ("--no-referee" in words) != is_first
        assert ("--snapshots" in words) == (is_first and case.mode == "coupled")


def test_long_cases_are_repeated_less():
    count = Counter((case.group.name, case.configuration.label) for case in measured())
    assert count["replay", "voxel-cells=64"] == 3
    assert count["coupled", "fcl"] == 2
    assert count["replay", "brute_force"] == 1


def test_work_keeps_to_the_promised_minutes():
    assert seconds([case for case in plan() if "-arms-" not in case.name and "-forces-" not in case.name]) / 2 < 30 * 60
    first_look = quick(fake_registry.scene("synthetic/iliacus"))
    assert seconds([case for case in first_look if "-arms-" not in case.name and "-forces-" not in case.name]) / 2 < 4.5 * 60


def test_what_is_slow_is_run_where_it_is_affordable():
    cases = plan(*MUSCLES)
    too_long = [case for case in cases if case.is_too_long]
    assert {case.configuration.backend for case in too_long} == {fake_registry.roles().reference}
    replays = [case.name for case in of_group(too_long, "replay")]
    assert replays and not any(name.startswith("adductor_brevis") for name in replays)
    assert len(of_group(too_long, "coupled")) == len(of_group(too_long, "arms")) == len(MUSCLES)
    floors = of_group(cases, "floor")
    assert [case.configuration.label for case in floors] == ["bvh"] * len(MUSCLES)
    assert "start_noise_m=1e-12" in floors[0].arguments(FOLDERS)


def test_moment_arms_are_of_runs_of_their_own():
    arms, coupled = of_group(plan(), "arms"), of_group(plan(), "coupled")
    assert len(arms) == len([case for case in coupled if case.repetition == 0 and case.threads == 1])
    words = next(case for case in arms if case.name == "iliacus-arms-bvh-r0").arguments(FOLDERS)
    assert words[words.index("--preset") + 1] == "standard" and words[words.index("--fibres-if-possible") + 1] == "100"
    assert "--no-referee" in words and "--snapshots" not in words
    pressed = next(case for case in of_group(plan(), "forces") if case.name == "iliacus-forces-bvh-r0").arguments(FOLDERS)
    assert "--no-referee" in pressed and "--snapshots" in pressed  # a picture of pressure needs shapes
    floor, = of_group(plan(), "arms_floor")
    assert floor.name == "iliacus-arms_floor-bvh-r0" and "start_noise_m=1e-12" in floor.arguments(FOLDERS)


@pytest.mark.parametrize("milliseconds", [0.0, 0.1, 10.0, 100.0, 1e4])
def test_strides_are_powers_of_two_that_keep_enough_frames(milliseconds):
    first = replace(of_group(expansion(FILE, ILIACUS).firsts(), "replay")[0], repetition=0)
    case = replace(first, configuration=Configuration("a backend of its own", step_ms=milliseconds),
                   group=replace(first.group, replay_s=12.0))
    stride = stride_of(case, [])
    replay = replace(case, stride=stride)
    assert stride in (1, 2, 4, 8, 16) and replay.frames >= 20
    assert replay.guessed_step_seconds <= 12.0 or stride == 16
    assert stride == 1 or replace(case, stride=stride // 2).guessed_step_seconds > 12.0


def test_configurations_of_a_backend_replay_the_same_frames_and_all_of_them_with_a_clearance_cache():
    strides = {}
    for case in of_group(plan(*MUSCLES), "replay"):
        key = (case.scene.key, case.configuration.backend, case.configuration.has_cache)
        strides.setdefault(key, set()).add(case.stride)
    assert all(len(of_backend) == 1 for of_backend in strides.values())
    assert all(of_backend == {1} for (_, _, has_cache), of_backend in strides.items() if has_cache)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 100])
def test_parts_are_disjoint_complete_and_even(count):
    whole = measured(*MUSCLES)
    parts = [of_groups(in_shard(whole, number, count)) for number in range(1, count + 1)]
    assert sorted(case.name for part in parts for case in part) == sorted(case.name for case in whole)
    if count <= 7:
        assert max(map(seconds, parts)) < 1.3 * seconds(whole) / count


def of_groups(cases):
    return [case for case in cases if not isinstance(case, RecordCase)]


def test_a_part_records_only_the_muscles_that_it_replays():
    for number in (1, 2, 3):
        cases = in_shard(plan(*MUSCLES), number, 3)
        replayed = {case.scene for case in of_group(cases, "replay")}
        assert {case.scene for case in cases if isinstance(case, RecordCase)} == replayed


def test_what_shares_structures_stays_in_one_part():
    built = [{case.builder for case in of_groups(in_shard(measured(*MUSCLES), number, 4))} - {""} for number in (1, 2, 3, 4)]
    assert sum(map(len, built)) == len(set().union(*built)) > 8


def run(backend, repetition=0, threads=1):
    """A case whose name holds the word."""
    some = of_group(plan(), "floor")[0]
    return replace(some, configuration=Configuration(backend, threads=threads), repetition=repetition)


def test_a_queue_keeps_cases_until_what_they_need_has_ended():
    replay = next(case for case in of_group(plan(), "replay") if case.builder)
    probe = next(case for case in plan() if case.name == replay.builder)
    recording = RecordCase(ILIACUS)
    queue = CaseQueue([replay, recording, probe])
    assert queue.take() == recording and queue.take() == probe and queue.take() is None
    queue.end(recording)
    assert queue.take() is None
    queue.end(probe)
    assert queue.take() == replay
    queue.end(replay)
    assert not queue


def test_a_queue_gives_several_threads_a_machine_of_their_own():
    wide, narrow = run("wide", threads=2), run("narrow")
    queue = CaseQueue([narrow, wide])
    assert queue.take() == narrow and queue.take() is None
    queue.end(narrow)
    assert queue.take() == wide
    queue = CaseQueue([wide, narrow])
    assert queue.take() == wide and queue.take() is None


def test_a_queue_lets_nobody_overtake_a_case_of_several_threads():
    wide, narrow = run("wide", threads=2), run("narrow")
    later = [run("narrow", repetition) for repetition in (1, 2)]
    queue = CaseQueue([narrow, wide, *later])
    assert queue.take() == narrow and queue.take() is None  # with one core free: the wide case wants all of them
    queue.end(narrow)
    assert queue.take() == wide and queue.take() is None
    queue.end(wide)
    assert [queue.take(), queue.take()] == later


def test_a_queue_goes_past_a_case_of_several_threads_that_waits_for_another():
    narrow, probe = run("narrow"), run("probe", threads=2)
    wide = replace(run("wide", threads=2), builder=probe.name)
    queue = CaseQueue([wide, narrow, probe])
    assert wide.needs == (probe.name,)
    for case in (narrow, probe, wide):
        assert queue.take() == case and queue.take() is None
        queue.end(case)
    assert not queue


def test_what_is_too_long_is_a_choice():
    shorter = FILE.with_groups(longest_s=50.0)
    kept = [case.guessed_seconds for case in measured(*MUSCLES, file=shorter) if not case.is_too_long]
    more = [case.guessed_seconds for case in measured(*MUSCLES) if not case.is_too_long]
    assert max(kept) <= 50 < max(more)
